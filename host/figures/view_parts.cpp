// SPDX-License-Identifier: Apache-2.0
#include "host/figures/view_parts.h"

#include <algorithm>
#include <set>

namespace tactel::host {

std::vector<std::size_t> shown_steps(std::size_t count, std::size_t shown, std::size_t bytes_each) {
  constexpr std::size_t budget = 330'000, most_steps = 24;  // bytes of all steps
  const std::size_t most = std::clamp<std::size_t>(budget / bytes_each, 2, most_steps);
  std::set<std::size_t> steps = {shown, count - 1};
  const std::size_t even = count <= most ? count : most - 2;  // evenly along the path, from the first on
  for (std::size_t k = 0; k < even; ++k) steps.insert(k * count / even);
  return {steps.begin(), steps.end()};
}

std::string steps_left_out(std::size_t shown, std::size_t count) {
  return shown == count ? "" : fmt::format("{} of {} load steps are shown. ", shown, count);
}

}  // namespace tactel::host
