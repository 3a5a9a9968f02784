// SPDX-License-Identifier: Apache-2.0
#include "host/contact/strata.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace tactel::host {

std::vector<int> strata(std::span<const double> numbers, int count) {
  std::vector<std::size_t> order(numbers.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](std::size_t i) {
    return std::pair(std::isnan(numbers[i]) ? -std::numeric_limits<double>::infinity() : numbers[i], i);
  });
  std::vector<int> all(numbers.size());
  for (std::size_t k = 0; k < order.size(); ++k) all[order[k]] = static_cast<int>(k * count / order.size());
  return all;
}

}  // namespace tactel::host
