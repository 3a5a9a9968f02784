// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <stdexcept>
#include <string>

namespace tactel {

/// A value that the model rejects. `key` is its name for the user ("sensor.poisson"). A reader of a file adds the
/// file's name (host/support/errors.h).
class ValueError : public std::invalid_argument {
 public:
  ValueError(std::string key, std::string value, std::string allowed)
      : std::invalid_argument(key + " = " + value + ": must be " + allowed),
        key(std::move(key)),
        value(std::move(value)),
        allowed(std::move(allowed)) {}
  std::string key, value, allowed;
};

}  // namespace tactel
