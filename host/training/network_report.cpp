// SPDX-License-Identifier: Apache-2.0
#include "host/training/network_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_lines = 24;

/// Networks that differ in their seed alone.
struct Group {
  std::string label;
  std::vector<std::size_t> networks;
};

std::string label_of(const nn::Model& model) {
  std::string label = model.weights.topology.text();
  if (model.noise != 0) label += fmt::format(" {:g}%", 100 * model.noise);
  if (model.scaling.kind != nn::ScalingKind::set) label += fmt::format(" {}", nn::name(model.scaling.kind));
  if (model.scaling.markers) label += " markers";
  if (model.history.path() > 1) label += fmt::format(" {}:{}", model.history.path(), model.history.stride);
  return label;
}

std::vector<Group> groups_of(std::span<const NamedNetwork> networks) {
  std::vector<Group> groups;
  for (std::size_t i = 0; i < networks.size(); ++i) {
    const std::string label = label_of(networks[i].model);
    const auto found = std::ranges::find(groups, label, &Group::label);
    if (found == groups.end())
      groups.push_back({label, {i}});
    else
      found->networks.push_back(i);
  }
  return groups;
}

std::size_t label_width(const std::vector<Group>& groups) {
  std::size_t width = 9;
  for (const Group& group : groups) width = std::max(width, group.label.size() + 2);
  return width;
}

std::string number(double value) { return fmt::format("{:10.5f}", value); }

std::string errors_text(const nn::ErrorSummary& errors) {
  if (errors.count == 0) return fmt::format("{:>10}{:>10}{:>10}", "-", "-", "-");
  return number(errors.max) + number(errors.mean) + number(errors.std);
}

/// "median  [5 %, 95 %]" of one figure over the networks of a group that have errors at all.
std::string quantiles_text(const Group& group, std::span<const NetworkResult> results,
                           double nn::ErrorSummary::*figure) {
  std::vector<double> values;
  for (const std::size_t i : group.networks)
    if (results[i].errors.all.count > 0) values.push_back(results[i].errors.all.*figure);
  if (values.empty()) return fmt::format("{:>29}", "-");
  const auto at = [&](double q) { return nn::quantile(values, q); };
  return fmt::format("  {:9.5f} [{:7.5f}, {:7.5f}]", at(0.5), at(0.05), at(0.95));
}

std::string lines_by_network(std::span<const NamedNetwork> networks, std::span<const NetworkResult> results,
                             const std::vector<Group>& groups) {
  const std::size_t width = label_width(groups);
  std::string text = fmt::format("{:<{}}{:>8}{:>9}{:>11}{:>10}{:>10}{:>10}\n", "network", width, "seed", "rows",
                                 "no answer", "max", "mean", "std");
  for (std::size_t i = 0; i < networks.size(); ++i) {
    const nn::ErrorReport& errors = results[i].errors;
    text += fmt::format("{:<{}}{:>8}{:>9}{:>11}{}\n", label_of(networks[i].model), width, networks[i].model.seed,
                        errors.all.count, errors.without_answer, errors_text(errors.all));
  }
  return text;
}

std::string lines_by_group(std::span<const NetworkResult> results, const std::vector<Group>& groups) {
  const std::size_t width = label_width(groups);
  std::string text = fmt::format("{:<{}}{:>8}{:>11}  {:>29}{:>29}{:>29}\n", "network", width, "seeds", "no answer",
                                 "max: median [5 %, 95 %]", "mean", "std");
  for (const Group& group : groups) {
    std::size_t without_answer = 0;
    for (const std::size_t i : group.networks) without_answer += results[i].errors.without_answer;
    text += fmt::format("{:<{}}{:>8}{:>11}  ", group.label, width, group.networks.size(), without_answer);
    for (const auto figure : {&nn::ErrorSummary::max, &nn::ErrorSummary::mean, &nn::ErrorSummary::std})
      text += quantiles_text(group, results, figure);
    text += '\n';
  }
  return text;
}

using Kinds = std::map<int, nn::ErrorSummary>;

std::optional<double> median_of_mean(const Group& group, std::span<const NetworkResult> results,
                                     Kinds nn::ErrorReport::*kinds, int kind) {
  std::vector<double> means;
  for (const std::size_t i : group.networks) {
    const Kinds& errors = results[i].errors.*kinds;
    if (const auto found = errors.find(kind); found != errors.end()) means.push_back(found->second.mean);
  }
  if (means.empty()) return std::nullopt;
  return nn::quantile(means, 0.5);
}

template <class Name>
std::string lines_by_kind(std::span<const NetworkResult> results, const std::vector<Group>& groups, const char* title,
                          Kinds nn::ErrorReport::*kinds, const Name& name) {
  const std::size_t width = label_width(groups);
  std::map<int, std::size_t> rows;
  for (const NetworkResult& result : results)
    for (const auto& [kind, errors] : result.errors.*kinds) rows[kind] = std::max(rows[kind], errors.count);
  std::string text = fmt::format("{:<21}{:>8}", title, "rows");
  for (const Group& group : groups) text += fmt::format("{:>{}}", group.label, width);
  text += '\n';
  for (const auto& [kind, count] : rows) {
    text += fmt::format("{:<21}{:>8}", name(kind), count);
    for (const Group& group : groups) {
      const auto mean = median_of_mean(group, results, kinds, kind);
      text += fmt::format("{:>{}}", mean ? fmt::format("{:.5f}", *mean) : "-", width);
    }
    text += '\n';
  }
  return text;
}

}  // namespace

std::string errors_of(nn::Target target) {
  return fmt::format("errors |{0} - {0} of the set|", target == nn::Target::slip_index ? "S" : nn::name(target));
}

std::string error_table(std::span<const NamedNetwork> networks, std::span<const NetworkResult> results) {
  const std::vector<Group> groups = groups_of(networks);
  return networks.size() <= most_lines ? lines_by_network(networks, results, groups) : lines_by_group(results, groups);
}

std::string error_table_by_kind(std::span<const NamedNetwork> networks, std::span<const NetworkResult> results,
                                const std::vector<std::string>& indenter_names) {
  const std::vector<Group> groups = groups_of(networks);
  const auto name = [&](int kind) { return indenter_name(indenter_names, kind); };
  const bool pad = !results.empty() && !results.front().errors.by_torque.empty();
  std::string text = lines_by_kind(results, groups, "mean by indenter", &nn::ErrorReport::by_class, name);
  if (results.empty() || !results.front().errors.by_contact_nodes.empty())
    text += "\n" + lines_by_kind(results, groups, pad ? "by tactels touching" : "by nodes touching",
                                 &nn::ErrorReport::by_contact_nodes, [](int nodes) { return std::to_string(nodes); });
  if (pad)
    text += "\n" + lines_by_kind(results, groups, "by torque", &nn::ErrorReport::by_torque, nn::torque_class_name);
  return text;
}

Json to_json(const nn::ErrorSummary& errors) {
  const auto figure = [&](double value) { return errors.count > 0 ? Json(value) : Json(nullptr); };
  return {
      {"max", figure(errors.max)}, {"mean", figure(errors.mean)}, {"std", figure(errors.std)}, {"rows", errors.count}};
}

Json to_json(const NamedNetwork& network) {
  const nn::Model& model = network.model;
  const int number = paper_number(model.weights.topology);
  Json json = {{"file", network.file},
               {"network", number > 0 ? Json(number) : Json(nullptr)},
               {"topology", model.weights.topology.text()},
               {"target", nn::name(model.target)},
               {"scaling", nn::name(model.scaling.kind)},
               {"noise", model.noise},
               {"seed", model.seed},
               {"cycles", model.cycles},
               {"learning_set", model.learning_set},
               {"learning", to_json(model.learning_errors)}};
  if (model.bound) json["calibration"] = to_json(*model.bound);
  return json;
}

Json to_json(const NetworkResult& result, const std::vector<std::string>& indenter_names) {
  const auto list = [](const char* key, const Kinds& kinds, const auto& name) {
    Json array = Json::array();
    for (const auto& [kind, errors] : kinds) {
      array.push_back({{key, name(kind)}});
      array.back().update(to_json(errors));
    }
    return array;
  };
  const bool pad = !result.errors.by_torque.empty();
  const auto number = [](int touching) { return touching; };
  Json frames = Json::object();
  for (std::size_t status = 0; status < result.frames.size(); ++status)
    frames[nn::name(static_cast<nn::FrameStatus>(status))] = result.frames[status];
  Json json = {{"recalling", to_json(result.errors.all)},
               {"without_answer", result.errors.without_answer},
               {"frames", frames},
               {"by_indenter", list("indenter", result.errors.by_class,
                                    [&](int kind) { return indenter_name(indenter_names, kind); })}};
  if (pad) {
    json["by_tactels"] = list("tactels", result.errors.by_contact_nodes, number);
    json["by_torque"] = list("torque", result.errors.by_torque, nn::torque_class_name);
  } else {
    json["by_contact_nodes"] = list("contact_nodes", result.errors.by_contact_nodes, number);
  }
  if (result.bound) json["bound"] = to_json(*result.bound, indenter_names);
  return json;
}

}  // namespace tactel::host
