// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
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

/// Throws where a title holds control characters, which terminals obey and pages and pictures cannot hold.
inline void check_title(const std::string& title) {
  for (std::size_t k = 0; k < title.size(); ++k) {
    const auto byte = static_cast<unsigned char>(title[k]);
    const bool second =
        byte == 0xC2 && k + 1 < title.size() && static_cast<unsigned char>(title[k + 1]) < 0xA0;  // UTF-8
    if (byte < 0x20 || byte == 0x7F || second)
      throw ValueError("title", "(text)", "a text without control characters such as ESC and line breaks");
  }
}

}  // namespace tactel
