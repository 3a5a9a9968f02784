// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

#include "nn/philox.h"

namespace tactel::host {

/// Returns the row that stands for part k of `parts` equal parts of `rows`, k < parts <= rows. A hash of k chooses it:
/// the rows of all parts are not those of one load step, or one value of a grid, as at equal distances they may be.
constexpr std::uint64_t chosen_row(std::uint64_t k, std::uint64_t parts, std::uint64_t rows) {
  const std::uint64_t first = k * rows / parts, size = (k + 1) * rows / parts - first;
  return first + nn::philox4x32({static_cast<std::uint32_t>(k), 0, 0, 0}, {})[0] % size;
}

}  // namespace tactel::host
