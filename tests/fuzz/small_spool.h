// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "host/sets/set_spool.h"
#include "tests/fuzz/small_set.h"

namespace tactel::fuzz {

inline const std::string spool_plan = "a plan";
inline constexpr std::uint64_t small_chunks = 2;

/// An unfinished set of two chunks, whose parts stay beside `output`.
inline void write_small_spool(const std::filesystem::path& output) {
  host::SetSpool spool(output, spool_plan, small_inputs, small_chunks, host::SetSpool::Open::fresh);
  for (std::uint64_t chunk = 0; chunk < small_chunks; ++chunk) spool.append(chunk, small_set());
}

}  // namespace tactel::fuzz
