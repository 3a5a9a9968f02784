// SPDX-License-Identifier: Apache-2.0
#include "host/contact/strata.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tactel::host {

std::vector<int> strata(std::span<const double> numbers, int count) {
  std::vector<std::pair<double, std::size_t>> order;
  order.reserve(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i)
    order.emplace_back(std::isnan(numbers[i]) ? -std::numeric_limits<double>::infinity() : numbers[i], i);
  std::ranges::sort(order);
  std::vector<int> all(numbers.size());
  for (std::size_t k = 0; k < order.size(); ++k) all[order[k].second] = static_cast<int>(k * count / order.size());
  return all;
}

}  // namespace tactel::host
