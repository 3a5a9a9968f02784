// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <vector>

#include "fem/gap/gap_increment.h"

namespace tactel::fem {

/// Path following: follows the solution from the previous pose as the load grows to its target, one status change
/// at a time. It is slower, for increments where simultaneous changes cycle. Returns the statuses at the target,
/// or none where the path does not reach it.
std::optional<std::vector<Trial>> follow_path(const GapIncrement& increment, GapSearch& search, double offset_size);

}  // namespace tactel::fem
