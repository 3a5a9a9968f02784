// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json.hpp>
#include <vector>

namespace tactel::host {

/// A number alone, or an array.
inline nlohmann::ordered_json one_or_more(const std::vector<double>& values) {
  if (values.size() == 1) return values.front();
  return values;
}

}  // namespace tactel::host
