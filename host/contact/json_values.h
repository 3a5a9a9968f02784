// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <nlohmann/json.hpp>
#include <vector>

#include "fem/contact_solution.h"

namespace tactel::host {

// Parts that the JSON of lines and of pads shares.

inline nlohmann::ordered_json json_numbers(const Eigen::VectorXd& values) {
  return std::vector<double>(values.begin(), values.end());
}

inline nlohmann::ordered_json json_statuses(const std::vector<fem::GapStatus>& statuses) {
  auto names = nlohmann::ordered_json::array();
  for (const fem::GapStatus status : statuses)
    names.push_back(status == fem::GapStatus::open ? "open" : status == fem::GapStatus::stick ? "stick" : "slip");
  return names;
}

}  // namespace tactel::host
