// SPDX-License-Identifier: Apache-2.0
#include "host/training/learning_curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "nn/metrics.h"

namespace tactel::host {
namespace {

using Errors = std::vector<float> LearningCurve::*;
using Members = std::vector<const TrainedNetwork*>;

std::vector<double> noises_of(std::span<const TrainedNetwork> networks) {
  std::set<double> noises;
  for (const TrainedNetwork& network : networks) noises.insert(network.noise);
  return {noises.begin(), noises.end()};
}

// Networks of one level of noise that differ in their seed alone, in the order given.
std::vector<Members> members_of(std::span<const TrainedNetwork> networks, double noise) {
  std::vector<Members> all;
  for (const TrainedNetwork& network : networks) {
    if (network.noise != noise || network.curve.cycle.empty()) continue;
    const auto same = [&](const Members& members) { return members[0]->topology == network.topology; };
    const auto found = std::ranges::find_if(all, same);
    if (found == all.end())
      all.push_back({&network});
    else
      found->push_back(&network);
  }
  return all;
}

// The errors that a curve holds for a cycle: its own, or those of the last point before.
double errors_at(const LearningCurve& curve, Errors errors, std::uint64_t cycle) {
  const auto after = std::ranges::upper_bound(curve.cycle, cycle) - curve.cycle.begin();
  return (curve.*errors)[static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - 1, 0))];
}

// A logarithmic axis has no place for zero, NaN or infinity.
double drawable(double value) { return value > 0 && std::isfinite(value) ? value : NAN; }

std::vector<Series> curves_of(const Members& members, Errors errors, Ink ink) {
  std::set<std::uint64_t> cycles;
  for (const TrainedNetwork* network : members) cycles.insert(network->curve.cycle.begin(), network->curve.cycle.end());
  Series line{.label = members[0]->topology.text(), .mark = Mark::line, .ink = ink};
  Series band{.mark = Mark::band, .ink = ink};
  for (const std::uint64_t cycle : cycles) {
    std::vector<double> values;
    for (const TrainedNetwork* network : members) {
      const double value = drawable(errors_at(network->curve, errors, cycle));
      if (!std::isnan(value)) values.push_back(value);
    }
    const auto at = [&](double q) { return values.empty() ? NAN : nn::quantile(values, q); };
    line.x.push_back(static_cast<double>(cycle));
    line.y.push_back(at(0.5));
    band.low.push_back(at(0.05));
    band.high.push_back(at(0.95));
  }
  band.x = line.x;
  band.y = line.y;
  if (std::ranges::all_of(line.y, [](double y) { return std::isnan(y); })) return {};
  if (members.size() == 1) return {line};
  return {band, line};
}

Panel panel_of(std::span<const Members> all, Errors errors, const std::string& title, const std::string& y_label) {
  constexpr int inks = 8;
  Panel panel{.title = title, .x_label = "cycle", .y_label = y_label, .log_x = true, .log_y = true};
  for (std::size_t i = 0; i < all.size(); ++i)
    for (Series& series : curves_of(all[i], errors, static_cast<Ink>(i % inks)))
      panel.series.push_back(std::move(series));
  if (panel.series.empty()) panel.y_range = {0.1, 1};  // every network diverged at once
  return panel;
}

// gnuplot draws no axis over a single place, or without any value: such an axis has a range by itself.
void keep_drawable(Panel& panel) {
  const auto empty = [](const Series& series) {
    return std::ranges::all_of(series.y, [](double y) { return std::isnan(y); });
  };
  double first = std::numeric_limits<double>::infinity(), last = 0;
  for (const Series& series : panel.series)
    for (const double x : series.x) first = std::min(first, x), last = std::max(last, x);
  if (!(first < last)) panel.x_range = last > 0 ? std::pair{last / 2, last * 2} : std::pair{1.0, 10.0};
  if (std::ranges::all_of(panel.series, empty)) panel.y_range = {0.1, 1};
  std::erase_if(panel.series, empty);
}

}  // namespace

Figure learning_curves(std::span<const TrainedNetwork> networks, double stop_error) {
  Figure figure{.title = "Learning curves", .columns = 2, .width = 1000, .panel_height = 340};
  double last = 2;
  std::size_t most_seeds = 0;
  for (const TrainedNetwork& network : networks) last = std::max(last, static_cast<double>(network.cycles));
  for (const double noise : noises_of(networks)) {
    const std::vector<Members> all = members_of(networks, noise);
    for (const Members& members : all) most_seeds = std::max(most_seeds, members.size());
    const std::string shown = noise == 0 ? "without noise" : fmt::format("noise {:g} %", 100 * noise);
    figure.panels.push_back(panel_of(all, &LearningCurve::sse, "Sum of squared errors, " + shown, "SSE of a cycle"));
    figure.panels.push_back(panel_of(all, &LearningCurve::largest, "Largest error, " + shown, "largest |error|"));
    if (stop_error > 0)
      figure.panels.back().series.push_back(
          {.x = {1, last}, .y = {stop_error, stop_error}, .mark = Mark::dashed, .ink = Ink::grey});
  }
  for (Panel& panel : figure.panels) panel.x_range = {1, last};
  if (most_seeds > 1) figure.title += fmt::format(": median of up to {} seeds, 5 to 95 %", most_seeds);
  return figure;
}

Figure stream_curves(std::span<const TrainedNetwork> networks, bool validated) {
  constexpr Ink inks[] = {Ink::black, Ink::blue, Ink::green, Ink::orange, Ink::red, Ink::purple, Ink::brown, Ink::grey};
  Panel block{.title = "new frames, before the networks learn them",
              .x_label = "rows seen",
              .y_label = "root mean square error of S",
              .log_x = true,
              .log_y = true};
  Panel recall = block;
  recall.title = "validation set", recall.y_label = "mean error of S";
  std::vector<nn::Topology> topologies;
  for (const TrainedNetwork& network : networks) {
    const bool first_seed = std::ranges::find(topologies, network.topology) == topologies.end();
    if (first_seed) topologies.push_back(network.topology);
    Series curve{.label = first_seed ? network.topology.text() : "",
                 .mark = Mark::line_dots,
                 .ink = inks[(topologies.size() - 1) % std::size(inks)]};
    Series validation = curve;
    for (std::size_t k = 0; k < network.curve.cycle.size(); ++k) {
      curve.x.push_back(static_cast<double>(network.curve.cycle[k]));
      curve.y.push_back(drawable(std::sqrt(network.curve.sse[k])));
      validation.y.push_back(drawable(network.curve.largest[k]));
    }
    validation.x = curve.x;
    block.series.push_back(std::move(curve));
    recall.series.push_back(std::move(validation));
  }
  for (Panel* panel : {&block, &recall}) keep_drawable(*panel);
  Figure figure{.panels = {block}, .columns = 2, .width = 900, .panel_height = 340};
  if (validated) figure.panels.push_back(recall);
  return figure;
}

}  // namespace tactel::host
