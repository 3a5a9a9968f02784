// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/figures/error_panels.h"
#include "host/figures/plot.h"
#include "host/training/network_report.h"

namespace tactel::host {
namespace {

constexpr std::size_t best = 6, most_rows = 40;  // networks with figures, networks in the table
constexpr double large_error = 0.1;              // the paper looked at the examples above it (section V.E)
constexpr Ink inks[] = {Ink::blue, Ink::orange, Ink::green, Ink::purple, Ink::red, Ink::brown};

/// A judged network; errors [rows], NaN where it gave none.
struct Judged {
  const NamedNetwork* network;
  const NetworkResult* result;
  std::vector<double> truth, predicted, errors;

  std::string name() const {
    const nn::Model& model = network->model;
    std::string text = model.weights.topology.text();
    if (model.noise != 0) text += fmt::format(", {:g} % noise", 100 * model.noise);
    return text + fmt::format(", seed {}", model.seed);
  }
  double mean() const { return result->errors.all.count > 0 ? result->errors.all.mean : INFINITY; }
};

/// The networks, best first.
std::vector<Judged> judged(std::span<const NamedNetwork> networks, std::span<const NetworkResult> results,
                           const nn::FrameSet& set) {
  std::vector<Judged> all;
  for (std::size_t i = 0; i < networks.size(); ++i) all.push_back({&networks[i], &results[i], {}, {}, {}});
  std::ranges::stable_sort(all, {}, &Judged::mean);
  for (std::size_t i = 0; i < std::min(best, all.size()); ++i) {
    Judged& network = all[i];
    network.truth.assign(set.slip_index.begin(), set.slip_index.end());
    network.predicted.assign(network.result->slip_index.begin(), network.result->slip_index.end());
    for (std::size_t k = 0; k < network.truth.size(); ++k)
      network.errors.push_back(std::abs(network.predicted[k] - network.truth[k]));
  }
  return all;
}

double share_of_large_errors(const Judged& network) {
  const auto large = std::ranges::count_if(network.errors, [](double e) { return e > large_error; });
  const std::size_t count = network.result->errors.all.count;
  return count > 0 ? static_cast<double>(large) / static_cast<double>(count) : 0;
}

void report_recall_verdict(Page& page, const std::vector<Judged>& all, const AnsweredRows& rows,
                           const std::vector<std::string>& indenter_names) {
  const Judged& first = all.front();
  const nn::ErrorReport& errors = first.result->errors;
  if (errors.all.count == 0) {
    page.verdict("No network gave an answer.");
    return;
  }
  page.verdict(fmt::format("{} errs{}: by {:.4f} in S on average, by {:.3f} at most, on {} frames.", first.name(),
                           all.size() > 1 ? " least" : "", errors.all.mean, errors.all.max, errors.all.count));
  const double learning = first.network->model.learning_errors.mean;
  if (first.network->model.learning_errors.count > 0)
    page.finding(errors.all.mean > 5 * learning                                      ? Tone::poor
                 : errors.all.mean > 1.5 * learning || errors.all.mean > large_error ? Tone::fair
                                                                                     : Tone::good,
                 "generalising",
                 fmt::format("Its mean error is {:.1f} times that on its learning set ({:.4f}).",
                             errors.all.mean / learning, learning));
  const double large = share_of_large_errors(first);
  page.finding(large <= 0.01  ? Tone::good
               : large <= 0.1 ? Tone::fair
                              : Tone::poor,
               "large errors", fmt::format("{:.1f} % of its frames err by more than {}.", 100 * large, large_error));
  if (!errors.by_class.empty()) {
    const auto worst = std::ranges::max_element(errors.by_class, {}, [](const auto& e) { return e.second.mean; });
    const auto place = static_cast<std::size_t>(worst->first);
    page.finding(Tone::fact, "hardest",
                 fmt::format("{}: a mean error of {:.3f}.",
                             place < indenter_names.size() ? indenter_names[place] : fmt::format("kind {}", place),
                             worst->second.mean));
  }
  if (errors.without_answer > 0)
    page.finding(Tone::fair, "no answer", fmt::format("{} frames gave no slippage index.", errors.without_answer));
  if (rows.left_out > 0)
    page.finding(Tone::fact, "left out",
                 fmt::format("{} rows of the set are over tolerance or without a slippage index.", rows.left_out));
}

PageTable network_table(const std::vector<Judged>& all) {
  PageTable table{
      .caption = fmt::format("Errors |S of the network - S of the set|, best first{}",
                             all.size() > most_rows ? fmt::format("; {} of {} networks", most_rows, all.size()) : ""),
      .head = {"network", "recalling: mean", "standard deviation", "largest", "learning: mean", "largest",
               "no answer"}};
  for (std::size_t i = 0; i < std::min(all.size(), most_rows); ++i) {
    const nn::ErrorSummary &recall = all[i].result->errors.all, &learning = all[i].network->model.learning_errors;
    const auto text = [](const nn::ErrorSummary& errors, double value, int digits) {
      return errors.count > 0 ? fmt::format("{:.{}f}", value, digits) : std::string("-");
    };
    table.add({all[i].name(), text(recall, recall.mean, 4), text(recall, recall.std, 4), text(recall, recall.max, 3),
               text(learning, learning.mean, 4), text(learning, learning.max, 3),
               std::to_string(all[i].result->errors.without_answer)});
  }
  return table;
}

using Shown = std::span<const Judged>;

int columns_for(Shown shown) { return shown.size() < 3 ? 2 : 3; }

Figure predicted_figure(Shown shown) {
  Figure figure{.columns = columns_for(shown), .panel_height = 300};
  for (const Judged& network : shown)
    figure.panels.push_back(predicted_panel(network.truth, network.predicted, network.name()));
  return figure;
}

Figure distribution_figure(Shown shown) {
  Figure figure{.columns = columns_for(shown), .panel_height = 250};
  double most = 0.05;
  for (const Judged& network : shown)
    if (network.result->errors.all.count > 0)
      most = std::max(most, network.result->errors.all.mean + 3 * network.result->errors.all.std);
  for (const Judged& network : shown)
    figure.panels.push_back(error_histogram(network.errors, most, plain(network.name()),
                                            {{"mean", network.result->errors.all.mean, Ink::black}}));
  return figure;
}

/// Mean errors by indenter, and by S in ten parts of its range.
Figure where_figure(Shown shown, const std::vector<std::string>& indenter_names) {
  Panel kinds{.title = "by indenter", .y_label = "mean error of S", .zero_line = true};
  Panel index{.title = "by slippage index", .x_label = "true S", .y_label = "mean error of S", .zero_line = true};
  constexpr int parts = 10;
  for (std::size_t i = 0; i < shown.size(); ++i) {
    Series of_kind{.label = plain(shown[i].name()), .mark = Mark::circles, .ink = inks[i]};
    Series of_index{.label = plain(shown[i].name()), .mark = Mark::line_dots, .ink = inks[i]};
    for (const auto& [kind, errors] : shown[i].result->errors.by_class) {
      of_kind.x.push_back(kind), of_kind.y.push_back(errors.mean);
      const auto place = static_cast<std::size_t>(kind);
      if (i == 0)
        kinds.x_ticks.push_back(
            {kind, place < indenter_names.size() ? plain(indenter_names[place]) : fmt::format("kind {}", kind)});
    }
    std::vector<double> sum(parts), count(parts);
    for (std::size_t k = 0; k < shown[i].truth.size(); ++k) {
      if (std::isnan(shown[i].errors[k])) continue;
      const auto part = static_cast<std::size_t>(std::clamp(parts * shown[i].truth[k], 0.0, parts - 1.0));
      sum[part] += shown[i].errors[k], ++count[part];
    }
    for (std::size_t part = 0; part < parts; ++part) {
      of_index.x.push_back((static_cast<double>(part) + 0.5) / parts);
      of_index.y.push_back(count[part] > 0 ? sum[part] / count[part] : NAN);
    }
    kinds.series.push_back(std::move(of_kind)), index.series.push_back(std::move(of_index));
  }
  Figure figure{.columns = 2, .panel_height = 300};
  constexpr std::size_t most_kinds = 40;
  if (!kinds.x_ticks.empty() && kinds.x_ticks.size() <= most_kinds) figure.panels.push_back(std::move(kinds));
  figure.panels.push_back(std::move(index));
  return figure;
}

PageTable coverage_page_table(const BoundReport& report, const std::vector<std::string>& indenter_names) {
  PageTable table{.caption =
                      "Share of the frames below slip_upper, within slip_interval; median width of the interval; "
                      "share of frames unlike the learning set",
                  .head = {"frames", "number", "slip_upper", "interval", "width", "unlike"}};
  const auto add = [&table](const std::string& name, const Coverage& c) {
    table.add({name, std::to_string(c.rows), fmt::format("{:.4f}", c.upper), fmt::format("{:.4f}", c.interval),
               fmt::format("{:.4f}", c.width), fmt::format("{:.4f}", c.unlike)});
  };
  add("all", report.all);
  add("not unlike", report.alike);
  for (const auto& [kind, coverage] : report.by_class) {
    const auto place = static_cast<std::size_t>(kind);
    add(place < indenter_names.size() ? indenter_names[place] : fmt::format("kind {}", kind), coverage);
  }
  for (const auto& [key, coverage] : report.by_touching) add(touching_name(key) + " touching", coverage);
  for (const auto& [key, coverage] : report.by_torque) add(nn::torque_class_name(key), coverage);
  for (const auto& [key, coverage] : report.by_slip)
    add(fmt::format("S {:.1f} to {:.1f}", key / 10.0, (key + 1) / 10.0), coverage);
  return table;
}

/// The bound of the best network that has one.
void add_coverage(Page& page, const std::vector<Judged>& all, const std::vector<std::string>& indenter_names) {
  const auto bounded =
      std::ranges::find_if(all, [](const Judged& network) { return network.result->bound.has_value(); });
  if (bounded == all.end()) return;
  const nn::Bound& bound = *bounded->network->model.bound;
  page.section("Bound");
  page.paragraph(fmt::format("{}: {}.", bounded->name(), bound_line(bound)));
  page.table(coverage_page_table(*bounded->result->bound, indenter_names));
  page.note("The level holds for frames drawn as those of the calibration, and for no others.");
}

void add_decisions(Page& page, std::span<const NamedNetwork> networks, const std::vector<Judged>& all,
                   std::span<const std::vector<DecisionCurve>> decisions) {
  if (decisions.empty()) return;
  page.section("Decision");
  for (std::size_t i = 0; i < std::min<std::size_t>(all.size(), 2); ++i) {
    const auto which = static_cast<std::size_t>(all[i].network - networks.data());
    page.figure(decision_figure(decisions[which]),
                all[i].name() +
                    ": alarms on drags until sliding. A false alarm begins at |S| below 0.5; lead is the "
                    "share of the way to sliding that is left at the alarm (median).");
  }
}

}  // namespace

Page recall_page(std::span<const NamedNetwork> networks, std::span<const NetworkResult> results,
                 const AnsweredRows& rows, const std::vector<std::string>& indenter_names, const std::string& set,
                 std::span<const std::vector<DecisionCurve>> decisions) {
  const std::vector<Judged> all = judged(networks, results, rows.frames);
  const Shown shown = Shown(all).first(std::min(best, all.size()));
  Page page("tactel: networks judged by a set",
            fmt::format("{} network{} on {} frames of {}, by tactel {}", networks.size(),
                        networks.size() == 1 ? "" : "s", rows.frames.rows(), set, TACTEL_VERSION));
  report_recall_verdict(page, all, rows, indenter_names);
  for (std::size_t i = 0; i < networks.size(); ++i)
    if (const auto& bound = results[i].bound; bound && !bound->holds.value_or(true))
      page.finding(Tone::poor, networks[i].file, doubt_text(networks[i].model, *bound, rows.frames) + ".");
  page.table(network_table(all));
  page.figure(
      predicted_figure(shown),
      "Predicted over true slippage index. A dot is a frame of the set, of large sets one of 600 chosen by a hash.");
  page.figure(distribution_figure(shown), "How the errors are spread over all frames of the set.");
  page.figure(where_figure(shown, indenter_names), "Where the errors are.");
  add_coverage(page, all, indenter_names);
  add_decisions(page, networks, all, decisions);
  return page;
}

}  // namespace tactel::host
