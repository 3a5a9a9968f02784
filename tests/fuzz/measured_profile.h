// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string_view>

#include "tests/fuzz/fuzz.h"

namespace tactel::fuzz {

/// Writes folder()/measured.csv and heights.csv once: what `file = "measured.csv"` of a scene names.
inline void provide_measured_profile() {
  static const auto path = [] {
    constexpr std::string_view text = "x,y\n-2,1\n0,0\n2,1\n";
    return write_file("measured.csv", as_bytes(text));
  }();
  static const auto heights = write_file("heights.csv", as_bytes("1,1,1\n1,0,1\n1,1,1\n"));
}

}  // namespace tactel::fuzz
