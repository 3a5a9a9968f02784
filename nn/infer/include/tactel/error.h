// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/export.h>

#include <stdexcept>
#include <string>

namespace tactel {

/// Base of the exceptions of the libraries, std::bad_alloc apart.
class TACTEL_API Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  ~Error() override;
};

/// A file, value or call that cannot be used. what() is "place: problem; fix".
class TACTEL_API InputError : public Error {
 public:
  InputError(std::string place, std::string problem, std::string fix);
  ~InputError() override;

  std::string place;    ///< file, with its line where known, or the name of a value: "scene.toml:7", "sensor.poisson"
  std::string problem;  ///< "0.7", "cannot be read (No such file or directory)"
  std::string fix;      ///< what is allowed, or the remedy
};

}  // namespace tactel
