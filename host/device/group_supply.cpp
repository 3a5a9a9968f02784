// SPDX-License-Identifier: Apache-2.0
#include "host/device/group_supply.h"

#include <algorithm>
#include <cmath>

namespace tactel::host {

GroupSupply::GroupSupply(std::span<const std::size_t> groups_of_job) {
  std::size_t end = 0;
  for (const std::size_t groups : groups_of_job) ends_.push_back(end += groups);
}

void ChunkPace::measured(std::size_t groups, double seconds) {
  last_groups_ = groups;
  last_seconds_ = seconds / static_cast<double>(groups);
  busy_seconds_ += seconds;
}

double ChunkPace::aim(double rest_seconds) const {
  if (expected_ > 0 && equal_) return most_seconds;
  if (expected_ > 0) return std::clamp(part_of_rest * rest_seconds / threads_, chunk_seconds, most_seconds);
  return std::clamp(cautious_part * busy_seconds_, cautious_seconds, chunk_seconds);
}

std::size_t ChunkPace::next(std::size_t remaining) const {
  const double each = std::max(expected_, last_seconds_);
  if (each <= 0) return 1;
  const double rest = static_cast<double>(remaining);
  const double rounds = rest * each < short_seconds ? 1 : equal_ ? 2 : 4;
  double count = std::min(std::ceil(rest / (rounds * threads_)), aim(rest * each) / each);
  if (last_groups_ > 0 && !equal_) count = std::min(count, 2.0 * static_cast<double>(last_groups_));
  return std::clamp<std::size_t>(static_cast<std::size_t>(count), 1, largest_);
}

}  // namespace tactel::host
