#include "host/train_request.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "host/errors.h"

namespace tactel::host {
namespace {

constexpr int default_epochs = 1000;

/// What the library calls by a name of its own, as the user wrote it.
[[noreturn]] void blame_option(const ValueError& error) {
  static const std::map<std::string, std::string> options = {{"training.rate", "--learning-rate"},
                                                             {"training.momentum", "--momentum"},
                                                             {"training.stop_error", "--stop-error"},
                                                             {"training.cycle_limit", "--cycles"},
                                                             {"training.batch", "--batch"}};
  const auto found = options.find(error.key);
  throw ConfigError("command line", found == options.end() ? "--" + error.key : found->second, error.value,
                    error.allowed);
}

void refuse_unless_batch(const TrainRequest& request) {
  const char* option = request.optimizer ? "--optimizer" : request.batch ? "--batch" : nullptr;
  if (option && request.schedule != "batch")
    throw ConfigError("command line", option, request.optimizer.value_or(std::to_string(request.batch.value_or(0))),
                      "left out, or with --schedule batch");
}

nn::BatchOptions batch_options(const TrainRequest& request) {
  nn::BatchOptions batch;
  if (request.optimizer) batch.rule = nn::parse_rule(*request.optimizer);
  if (request.batch) batch.batch = *request.batch;
  batch.rate = request.rate.value_or(batch.rule == nn::BatchRule::adam ? 1e-3 : 0.1);
  if (request.momentum) batch.momentum = *request.momentum;
  batch.order = nn::parse_order(request.order);
  return batch;
}

std::vector<nn::Topology> topologies_of(const TrainRequest& request) {
  std::vector<std::string> names = request.networks;
  if (names.empty()) names = {"1", "2", "3", "4", "5", "6"};
  std::vector<nn::Topology> topologies;
  for (const std::string& name : names) {
    topologies.push_back(nn::Topology::parse(name));
    if (std::ranges::count(topologies, topologies.back()) > 1) throw ValueError("network", name, "named once");
  }
  return topologies;
}

}  // namespace

NamedSet read_set(const std::string& file) {
  NamedSet set{file, read_contact_set(file), {}};
  set.rows = answered_rows(set.contacts, file);
  return set;
}

NamedSet read_learning_set(const TrainRequest& request) try {
  NamedSet set = read_set(request.set);
  set.rows.frames.validate();
  nn::fit_scaling(nn::parse_scaling(request.scaling), set.rows.frames);
  return set;
} catch (const ValueError& error) {
  throw ConfigError(request.set, error);
}

SweepPlan plan_of(const TrainRequest& request) try {
  refuse_unless_batch(request);
  SweepPlan plan;
  plan.topologies = topologies_of(request);
  if (request.seeds > 1'000'000) throw ValueError("seeds", std::to_string(request.seeds), "at most a million");
  for (std::uint64_t i = 0; i < request.seeds; ++i) plan.seeds.push_back(request.first_seed + i);
  if (!request.noises.empty()) plan.noises = request.noises;
  if (std::set<double>(plan.noises.begin(), plan.noises.end()).size() < plan.noises.size())
    throw ValueError("noise", fmt::format("{}", fmt::join(plan.noises, ", ")), "levels that differ");
  plan.scaling = nn::parse_scaling(request.scaling);
  plan.options.stop_error = request.stop_error;
  plan.options.cycle_limit = request.cycles.value_or(request.schedule == "batch" ? default_epochs : 0);
  plan.options.order = nn::parse_order(request.order);
  if (request.schedule == "batch") {
    plan.batch = batch_options(request);
  } else {
    plan.options.rate = request.rate.value_or(plan.options.rate);
    plan.options.momentum = request.momentum.value_or(plan.options.momentum);
  }
  plan.validate();
  return plan;
} catch (const ValueError& error) {
  blame_option(error);
}

void check_width(const SweepPlan& plan, const NamedSet& set) {
  for (const nn::Topology& topology : plan.topologies)
    if (topology.inputs() != set.contacts.inputs)
      throw ConfigError("command line", "--network", topology.text(),
                        fmt::format("a network with {} inputs, as many as {} has", set.contacts.inputs, set.file));
}

}  // namespace tactel::host
