#include "host/group_supply.h"

#include <algorithm>
#include <cmath>

namespace tactel::host {

GroupSupply::GroupSupply(std::span<const std::size_t> groups_of_job) {
  std::size_t end = 0;
  for (const std::size_t groups : groups_of_job) ends_.push_back(end += groups);
}

void ChunkPace::measured(std::size_t groups, double seconds) {
  last_ = groups;
  seconds_per_group_ = seconds / static_cast<double>(groups);
}

std::size_t ChunkPace::next(std::size_t remaining) const {
  if (seconds_per_group_ <= 0) return 1;
  const double rest = static_cast<double>(remaining);
  const double rounds = rest * seconds_per_group_ < short_seconds ? 1 : 4;
  double count = std::min(std::ceil(rest / (rounds * threads_)), chunk_seconds / seconds_per_group_);
  if (last_ > 0) count = std::min(count, 2.0 * static_cast<double>(last_));
  return std::clamp<std::size_t>(static_cast<std::size_t>(count), 1, largest_);
}

}  // namespace tactel::host
