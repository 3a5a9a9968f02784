// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "host/training/training_directory.h"
#include "nn/metrics.h"

namespace tactel::host {
namespace {

using Members = std::vector<const TrainedNetwork*>;
using Place = std::uint64_t CurvePoint::*;
using Error = double (*)(const CurvePoint&);
struct Drawn {
  Error error;
  Mark mark = Mark::line_dots;
};

// Networks of one level of noise that differ in their seed alone, in the order given.
std::vector<Members> members_of(std::span<const TrainedNetwork> networks, double noise) {
  std::vector<Members> all;
  for (const TrainedNetwork& network : networks) {
    if (network.noise != noise || network.curve.empty()) continue;
    const auto same = [&](const Members& members) { return members[0]->topology == network.topology; };
    const auto found = std::ranges::find_if(all, same);
    if (found == all.end())
      all.push_back({&network});
    else
      found->push_back(&network);
  }
  return all;
}

// A logarithmic axis has no place for zero, NaN or infinity.
double drawable(double value) { return value > 0 && std::isfinite(value) ? value : NAN; }

// None where no error can be drawn.
std::vector<Series> curves_of(const Members& members, Place place, const Drawn& drawn, Ink ink) {
  std::set<std::uint64_t> places;
  for (const TrainedNetwork* network : members)
    for (const CurvePoint& point : network->curve) places.insert(point.*place);
  Series line{.label = plain(members[0]->topology.text()), .mark = drawn.mark, .ink = ink};
  Series band{.mark = Mark::band, .ink = ink};
  for (const std::uint64_t at : places) {
    std::vector<double> values;
    for (const TrainedNetwork* network : members)
      if (const double value = drawable(drawn.error(point_at(network->curve, place, at))); !std::isnan(value))
        values.push_back(value);
    const auto quantile = [&](double q) { return values.empty() ? NAN : nn::quantile(values, q); };
    line.x.push_back(static_cast<double>(at));
    line.y.push_back(quantile(0.5));
    band.low.push_back(quantile(0.05));
    band.high.push_back(quantile(0.95));
  }
  band.x = line.x, band.y = line.y;
  if (std::ranges::all_of(line.y, [](double y) { return std::isnan(y); })) return {};
  if (members.size() == 1) return {line};
  return {band, line};
}

Panel panel_of(std::span<const Members> all, Place place, const std::vector<Drawn>& errors, const std::string& title,
               const std::string& y_label) {
  constexpr int inks = 8;
  Panel panel{.title = title,
              .x_label = place == &CurvePoint::rows ? "rows seen" : "cycle",
              .y_label = y_label,
              .log_x = true,
              .log_y = true};
  for (const Drawn& drawn : errors)
    for (std::size_t i = 0; i < all.size(); ++i)
      for (Series& series : curves_of(all[i], place, drawn, static_cast<Ink>(i % inks))) {
        if (drawn.mark != errors[0].mark) series.label.clear();  // its colour is in the legend
        panel.series.push_back(std::move(series));
      }
  if (panel.series.empty()) panel.y_range = {0.1, 1};  // every network diverged at once
  return panel;
}

}  // namespace

Figure learning_curves(std::span<const TrainedNetwork> networks, const CurveKind& kind) {
  const int columns = kind.validated && !kind.stream ? 3 : 2;
  Figure figure{.title = "Learning curves", .columns = columns, .width = 500 * columns, .panel_height = 340};
  const Place place = kind.stream ? &CurvePoint::rows : &CurvePoint::cycle;
  std::uint64_t first = std::numeric_limits<std::uint64_t>::max(), last = 0;
  std::size_t most_seeds = 0;
  std::set<double> noises;
  for (const TrainedNetwork& network : networks) {
    noises.insert(network.noise);
    if (network.curve.empty()) continue;
    first = std::min(first, network.curve.front().*place), last = std::max(last, network.curve.back().*place);
  }
  for (const double noise : noises) {
    const std::vector<Members> all = members_of(networks, noise);
    for (const Members& members : all) most_seeds = std::max(most_seeds, members.size());
    const std::string shown = noise == 0 ? ", without noise" : fmt::format(", noise {:g} %", 100 * noise);
    const auto add = [&](const std::vector<Drawn>& errors, const std::string& title, const std::string& y_label) {
      figure.panels.push_back(panel_of(all, place, errors, title + shown, y_label));
    };
    const Drawn recall{[](const CurvePoint& p) { return double{p.recall}; }};
    const Drawn validation{[](const CurvePoint& p) { return p.validation; }, Mark::dashed};
    if (kind.stream) {
      add({{[](const CurvePoint& p) { return std::sqrt(double{p.mean_square}); }}},
          "New frames, before they are learnt", "root mean square error of S");
      if (kind.judged && kind.validated)
        add({recall, validation}, "Recall set; dashed: validation set", "mean error of S");
      else if (kind.judged)
        add({recall}, "Recall set", "mean error of S");
    } else {
      add({{[](const CurvePoint& p) { return double{p.sse}; }}}, "Sum of squared errors", "SSE of a cycle");
      add({{[](const CurvePoint& p) { return double{p.largest}; }}}, "Largest error", "largest |error|");
    }
    if (!kind.stream && kind.stop_error > 0)
      figure.panels.back().series.push_back({.x = {1, std::max(2.0, static_cast<double>(last))},
                                             .y = {kind.stop_error, kind.stop_error},
                                             .mark = Mark::dashed,
                                             .ink = Ink::grey});
    if (kind.validated && !(kind.stream && kind.judged)) add({validation}, "Validation set", "mean error of S");
  }
  const auto begin = static_cast<double>(std::min(first, last)), end = static_cast<double>(last);
  for (Panel& panel : figure.panels)
    panel.x_range = begin < end ? std::pair{begin, end} : std::pair{std::max(0.5, end / 2), std::max(2.0, 2 * end)};
  if (most_seeds > 1) figure.title += fmt::format(": median of up to {} seeds, 5 to 95 %", most_seeds);
  return figure;
}

}  // namespace tactel::host
