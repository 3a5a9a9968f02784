// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <vector>

namespace tactel::host {

/// Returns the stratum of each number, 0 to count - 1: strata of equal size (but for one) in ascending order. NaN is
/// below all numbers.
///
/// Lanes of a group wait for the slowest. Sweeps depend on friction and on the size of a contact: scenes of one stratum
/// of friction in the order of their size wait less than scenes in the order of either.
std::vector<int> strata(std::span<const double> numbers, int count);

}  // namespace tactel::host
