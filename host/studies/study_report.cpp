// SPDX-License-Identifier: Apache-2.0
#include "host/studies/study_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace tactel::host {

Spread spread(const Reports& reports, const std::function<double(const nn::ErrorReport&)>& figure) {
  std::vector<double> values;
  for (const nn::ErrorReport& report : reports) values.push_back(figure(report));
  return {nn::quantile(values, 0.5), nn::quantile(values, 0.05), nn::quantile(values, 0.95)};
}

std::string text_of(const Spread& s, int digits) {
  return fmt::format("{:.{}f} [{:.{}f}, {:.{}f}]", s.median, digits, s.low, digits, s.high, digits);
}

nlohmann::ordered_json errors_json(const Reports& reports) {
  const Spread max = spread(reports, max_error), mean = spread(reports, mean_error), std = spread(reports, std_error);
  return {{"max", max.median},
          {"mean", mean.median},
          {"std", std.median},
          {"low", {{"max", max.low}, {"mean", mean.low}, {"std", std.low}}},
          {"high", {{"max", max.high}, {"mean", mean.high}, {"std", std.high}}}};
}

void add_whisker(Series& series, double x, const Spread& s) {
  series.x.push_back(x), series.y.push_back(s.median);
  series.low.push_back(s.low), series.high.push_back(s.high);
}

void add_networks(Series& each, Series& median, double x, double width, const Reports& reports) {
  for (std::size_t i = 0; i < reports.size(); ++i) {
    const auto last = static_cast<double>(reports.size() - 1);
    each.x.push_back(x + width * (last > 0 ? static_cast<double>(i) / last - 0.5 : 0));
    each.y.push_back(mean_error(reports[i]));
  }
  add_whisker(median, x, spread(reports, mean_error));
}

}  // namespace tactel::host
