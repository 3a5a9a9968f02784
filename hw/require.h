// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "fem/numbers/value_error.h"

namespace tactel::hw {

/// Throws ValueError, with a key of profile files, for an invalid description of a device.
inline void require(bool met, const std::string& key, const std::string& value, const std::string& allowed) {
  if (!met) throw ValueError(key, value, allowed);
}

inline void require_within(const std::string& key, long value, long least, long most) {
  require(value >= least && value <= most, key, std::to_string(value),
          "a whole number from " + std::to_string(least) + " to " + std::to_string(most));
}

}  // namespace tactel::hw
