// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tactel::host {

/// A solved contact over its load steps as the script of pages draws it (host/figures/page/), and what the picture
/// shows, in words.
struct ContactView {
  nlohmann::ordered_json data;
  std::string caption;
};

inline std::vector<double> list(const Eigen::VectorXd& values) { return {values.begin(), values.end()}; }

/// Returns a number with so many significant digits; null where it is none.
inline nlohmann::ordered_json rounded(double value, int digits = 5) {
  if (!std::isfinite(value)) return {};
  return std::strtod(fmt::format("{:.{}g}", value, digits).c_str(), nullptr);
}
nlohmann::ordered_json rounded(const auto& values, int digits = 5) {
  auto out = nlohmann::ordered_json::array();
  for (const double value : values) out.push_back(rounded(value, digits));
  return out;
}

/// Returns which of `count` load steps a page holds: 24 at most, fewer where they are large, always with `shown` and
/// the last. `bytes_each`: of a step on the page, about.
std::vector<std::size_t> shown_steps(std::size_t count, std::size_t shown, std::size_t bytes_each);

/// Says that steps were left out; empty where none was.
std::string steps_left_out(std::size_t shown, std::size_t count);

}  // namespace tactel::host
