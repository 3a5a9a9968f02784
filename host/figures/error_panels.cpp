// SPDX-License-Identifier: Apache-2.0
#include "host/figures/error_panels.h"

#include <algorithm>
#include <cmath>

#include "host/support/chosen_row.h"

namespace tactel::host {

Panel predicted_panel(std::span<const double> truth, std::span<const double> predicted, const std::string& title,
                      std::size_t most) {
  Series rows{.label = "a frame", .mark = Mark::dots, .ink = Ink::blue};
  double low = 0, high = 1;
  const std::size_t count = std::min(truth.size(), most);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t row = chosen_row(k, count, truth.size());
    if (std::isnan(predicted[row])) continue;
    rows.x.push_back(truth[row]), rows.y.push_back(predicted[row]);
    low = std::min({low, truth[row], predicted[row]}), high = std::max({high, truth[row], predicted[row]});
  }
  const std::pair range{low - 0.04, high + 0.04};
  Series equal{.label = "predicted = true",
               .x = {range.first, range.second},
               .y = {range.first, range.second},
               .mark = Mark::dashed,
               .ink = Ink::black};
  return {.title = title,
          .x_label = "true S",
          .y_label = "predicted S",
          .series = {equal, rows},
          .x_range = range,
          .y_range = range};
}

std::vector<double> shares(std::span<const double> values, double most, std::size_t bins) {
  std::vector<double> out(bins);
  std::size_t count = 0;
  for (const double value : values) {
    if (std::isnan(value)) continue;
    ++count;
    ++out[std::min(bins - 1, static_cast<std::size_t>(std::max(0.0, value) / most * static_cast<double>(bins)))];
  }
  for (double& share : out) share /= static_cast<double>(std::max<std::size_t>(count, 1));
  return out;
}

Panel error_histogram(std::span<const double> errors, double most, const std::string& title,
                      const std::vector<Landmark>& landmarks) {
  constexpr std::size_t bins = 25;
  Series bars{.label = "share of the frames", .mark = Mark::bars, .ink = Ink::blue};
  for (const double share : shares(errors, most, bins)) {
    bars.x.push_back((static_cast<double>(bars.x.size()) + 0.5) * most / bins);
    bars.y.push_back(100 * share);
  }
  const double top = 1.08 * std::max(1.0, std::ranges::max(bars.y));
  Panel panel{.title = title,
              .x_label = "|error of S|, the last bar and beyond",
              .y_label = "share of the frames (%)",
              .series = {std::move(bars)},
              .x_range = std::pair{0.0, most},
              .y_range = std::pair{0.0, top}};
  for (const Landmark& mark : landmarks)
    panel.series.push_back(
        {.label = mark.label, .x = {mark.at, mark.at}, .y = {0, top}, .mark = Mark::line, .ink = mark.ink});
  return panel;
}

}  // namespace tactel::host
