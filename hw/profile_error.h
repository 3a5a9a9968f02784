// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <stdexcept>
#include <string>

namespace tactel::hw {

/// An invalid description of a device. `key` is that of the profile file.
class ProfileError : public std::invalid_argument {
 public:
  ProfileError(std::string key, std::string value, std::string allowed)
      : std::invalid_argument(key + " = " + value + ": must be " + allowed),
        key(std::move(key)),
        value(std::move(value)),
        allowed(std::move(allowed)) {}
  std::string key, value, allowed;
};

inline void require(bool met, const std::string& key, const std::string& value, const std::string& allowed) {
  if (!met) throw ProfileError(key, value, allowed);
}

inline void require_within(const std::string& key, long value, long least, long most) {
  require(value >= least && value <= most, key, std::to_string(value),
          "a whole number from " + std::to_string(least) + " to " + std::to_string(most));
}

}  // namespace tactel::hw
