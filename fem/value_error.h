#pragma once
#include <stdexcept>
#include <string>

namespace tactel {

/// A value that the model cannot accept. `key` is the name a user knows it by ("sensor.poisson"); whoever
/// read it from a file adds the file's name (host/config_error.h).
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
