// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/figures/page.h"
#include "nn/metrics.h"

namespace tactel::host {

/// What the reports of studies share: errors of many networks as a median with quantiles, in texts, figures and JSON.

using Reports = std::vector<nn::ErrorReport>;

/// Return an error over all rows of a report.
inline double max_error(const nn::ErrorReport& report) { return report.all.max; }
inline double mean_error(const nn::ErrorReport& report) { return report.all.mean; }
inline double std_error(const nn::ErrorReport& report) { return report.all.std; }

/// Median over networks with the 5 and 95 % quantiles.
struct Spread {
  double median = 0, low = 0, high = 0;
};
/// Returns the spread of one number of each report.
Spread spread(const Reports& reports, const std::function<double(const nn::ErrorReport&)>& figure);
/// Returns "0.031 [0.012, 0.070]".
std::string text_of(const Spread& spread, int digits = 3);
/// Returns medians over the reports of max, mean and standard deviation; "low" and "high" are the 5 and 95 % quantiles.
nlohmann::ordered_json errors_json(const Reports& reports);

/// Adds a mark with whiskers to a series.
void add_whisker(Series& series, double x, const Spread& spread);
/// Adds the mean error of every network to `each`, side by side about x over `width`, and their spread to `median`.
void add_networks(Series& each, Series& median, double x, double width, const Reports& reports);

}  // namespace tactel::host
