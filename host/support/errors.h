// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <stdexcept>
#include <string>
#include <utility>

#include "fem/numbers/value_error.h"

namespace tactel {

/// A file or option that cannot be used. `file` is the path as given by the user, "--option" names included;
/// `key` the name inside it ("sensor.poisson"), `value` its value, `allowed` the allowed values.
class ConfigError : public std::runtime_error {
 public:
  ConfigError(std::string file, std::string key, std::string value, std::string allowed);
  /// The same with the line of the value, from 1; 0 where it is unknown.
  ConfigError(const std::string& file, std::string key, std::string value, std::string allowed, int line)
      : ConfigError(line > 0 ? file + ":" + std::to_string(line) : file, std::move(key), std::move(value),
                    std::move(allowed)) {
    this->file = file;
    this->line = line;
  }
  /// A value that the model rejected, with its file.
  ConfigError(std::string file, const ValueError& error)
      : ConfigError(std::move(file), error.key, error.value, error.allowed) {}
  std::string file, key, value, allowed;
  int line = 0;
};

/// An OpenCL call that failed, or a missing device.
class DeviceError : public std::runtime_error {
 public:
  /// `call`: "clEnqueueNDRangeKernel"; `code`: "CL_OUT_OF_RESOURCES"; `device`: its name; `advice`: the remedy, may
  /// be empty.
  DeviceError(std::string call, std::string code, std::string device, const std::string& advice = "");
  std::string call, code, device;
};

/// Thrown by a long job that its Progress cancelled, where the function has no other way to report it.
class Stopped : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A kernel source that the device's compiler rejected. The log names the files and lines of kernels/.
class KernelBuildError : public std::runtime_error {
 public:
  KernelBuildError(std::string source, std::string options, std::string log);
  std::string source, options, log;
};

}  // namespace tactel
