// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "host/sets/contact_set.h"

namespace tactel::fuzz {

inline constexpr std::size_t small_rows = 3;
inline constexpr int small_inputs = 4;

/// A set of three rows for two tactels.
inline host::ContactSet small_set() {
  host::ContactSet set;
  set.inputs = small_inputs;
  host::each_dataset(set, [](const char*, auto& values, int columns, const char*) {
    for (std::size_t i = 0; i < small_rows * static_cast<std::size_t>(columns > 0 ? columns : 1); ++i)
      values.push_back(static_cast<typename std::remove_reference_t<decltype(values)>::value_type>(i));
  });
  set.indenter = {0, 1, 0};
  set.indenter_names = {"flat", "parabola"};
  set.sweep = "[sweep]\ncontacts = 3\n";
  set.device = "a device";
  set.rung = "patch-8";
  set.seed = 7;
  return set;
}

}  // namespace tactel::fuzz
