// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

namespace tactel::host {

/// What `generate` reports of the contacts of a set or a chunk, in the order of ChunkHeader. fell_back, unsolved and
/// without_rows are attributes of a set file.
struct SetCounts {
  std::uint64_t fell_back = 0;     ///< contacts solved by the exact fallback
  std::uint64_t unsolved = 0;      ///< contacts with a load step over tolerance
  std::uint64_t too_deep = 0;      ///< contacts indented beyond the depth to which rubber is linear
  std::uint64_t without_rows = 0;  ///< contacts without a row, because mu P = 0 in every step
  std::uint64_t far_slip = 0;      ///< contacts that slide beyond slip_limit
  std::uint64_t near_edge = 0;     ///< contacts of outside_edges
  std::uint64_t unseen = 0;        ///< of outside_tactels
  std::uint64_t wide_cells = 0;    ///< of outside_cells
  std::uint64_t never_slid = 0;    ///< contacts with rows whose drag until sliding ends without it
  std::uint64_t coarse = 0;        ///< rows that are marked so

  void add(const SetCounts& others) {
    for (std::uint64_t SetCounts::*count :
         {&SetCounts::fell_back, &SetCounts::unsolved, &SetCounts::without_rows, &SetCounts::too_deep,
          &SetCounts::far_slip, &SetCounts::near_edge, &SetCounts::unseen, &SetCounts::wide_cells,
          &SetCounts::never_slid, &SetCounts::coarse})
      this->*count += others.*count;
  }
};

}  // namespace tactel::host
