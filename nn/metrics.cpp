// SPDX-License-Identifier: Apache-2.0
#include "nn/metrics.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "fem/numbers/value_error.h"

namespace tactel::nn {
namespace {

template <class Label>
std::map<int, ErrorSummary> summarize_by(std::span<const double> errors, const std::vector<Label>& labels) {
  std::map<int, std::vector<double>> groups;
  for (std::size_t row = 0; row < labels.size(); ++row)
    if (!std::isnan(errors[row])) groups[labels[row]].push_back(errors[row]);
  std::map<int, ErrorSummary> summaries;
  for (const auto& [label, group] : groups) summaries[label] = summarize(group);
  return summaries;
}

}  // namespace

ErrorSummary summarize(std::span<const double> absolute_errors) {
  ErrorSummary summary{.count = absolute_errors.size()};
  if (summary.count == 0) return summary;
  for (const double error : absolute_errors) {
    summary.max = std::max(summary.max, error);
    summary.mean += error / static_cast<double>(summary.count);
  }
  double variance = 0;
  for (const double error : absolute_errors)
    variance += (error - summary.mean) * (error - summary.mean) / static_cast<double>(summary.count);
  summary.std = std::sqrt(variance);
  return summary;
}

std::uint8_t torque_class(float slip_index, float force_ratio) {
  constexpr float smallest = 0.05f;
  if (slip_index < smallest) return 0;
  const float share = 1 - force_ratio / slip_index;
  return static_cast<std::uint8_t>(1 + (share > 1.0f / 3) + (share > 2.0f / 3));
}

const char* torque_class_name(int torque_class) {
  constexpr const char* names[] = {"S below 0.05", "torque below 1/3", "torque 1/3 to 2/3", "torque above 2/3"};
  return names[torque_class];
}

ErrorReport report_errors(std::span<const double> errors, const FrameSet& set) {
  std::vector<double> answered;
  std::copy_if(errors.begin(), errors.end(), std::back_inserter(answered), [](double e) { return !std::isnan(e); });
  ErrorReport report{.all = summarize(answered),
                     .by_class = summarize_by(errors, set.shape_class),
                     .by_contact_nodes = summarize_by(errors, set.contact_nodes),
                     .by_torque = summarize_by(errors, set.torque)};
  report.without_answer = errors.size() - answered.size();
  return report;
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) throw ValueError("quantile", "of no values", "taken of at least one value");
  if (!(q >= 0 && q <= 1)) throw ValueError("quantile", std::to_string(q), "0 to 1");
  std::sort(values.begin(), values.end());
  const double place = q * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
}

}  // namespace tactel::nn
