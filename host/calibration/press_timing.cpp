// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/press_timing.h"

#include <fmt/format.h>

#include <cmath>

#include "fem/value_error.h"

namespace tactel::host {

void PressTiming::validate(std::size_t steps) const {
  const auto check = [](bool good, const char* key, double value, const char* allowed) {
    if (!good) throw ValueError(key, fmt::format("{:g}", value), allowed);
  };
  for (const auto& [key, values] : {std::pair{"begin", &begin}, {"end", &end}, {"times", &time}})
    if (values->size() != steps)
      throw ValueError(key, fmt::format("{} numbers", values->size()),
                       fmt::format("one for each load step, {}", steps));
  for (std::size_t k = 0; k < steps; ++k) {
    check(begin[k] >= (k > 0 ? time[k - 1] : 0), "begin", begin[k], "s, not before the reading of the last load step");
    check(end[k] >= begin[k], "end", end[k], "s, not before begin");
    check(time[k] >= end[k] && std::isfinite(time[k]), "times", time[k], "s, not before the end of the motion");
  }
}

Eigen::MatrixXd amplifier_response(const PressTiming& timing, double time_constant) {
  const auto steps = static_cast<Eigen::Index>(timing.time.size());
  Eigen::MatrixXd response = Eigen::MatrixXd::Zero(steps, steps);
  for (Eigen::Index k = 0; k < steps; ++k)
    for (Eigen::Index j = 0; j <= k; ++j) {
      const auto to = static_cast<std::size_t>(j);
      const double motion = (timing.end[to] - timing.begin[to]) / time_constant;
      const double since = (timing.time[static_cast<std::size_t>(k)] - timing.end[to]) / time_constant;
      // v' = x' - v / RC for a ramp of height 1, then no motion
      const double left = (motion > 0 ? -std::expm1(-motion) / motion : 1) * std::exp(-since);
      response(k, j) += left;
      if (j > 0) response(k, j - 1) -= left;
    }
  return response;
}

}  // namespace tactel::host
