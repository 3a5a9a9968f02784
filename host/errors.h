#pragma once
#include <stdexcept>
#include <string>
#include <utility>

#include "fem/value_error.h"

namespace tactel {

/// A file or option that cannot be used. `file` is the path as the user gave it, "--option" names included; `key` the
/// name inside it ("sensor.poisson"), `value` what stood there, `allowed` what may stand there.
class ConfigError : public std::runtime_error {
 public:
  ConfigError(std::string file, std::string key, std::string value, std::string allowed);
  /// The same where the line of the value is known, from 1; 0 where it is not.
  ConfigError(const std::string& file, std::string key, std::string value, std::string allowed, int line)
      : ConfigError(line > 0 ? file + ":" + std::to_string(line) : file, std::move(key), std::move(value),
                    std::move(allowed)) {
    this->file = file;
    this->line = line;
  }
  /// A value that the model refused, with the file that it came from.
  ConfigError(std::string file, const ValueError& error)
      : ConfigError(std::move(file), error.key, error.value, error.allowed) {}
  std::string file, key, value, allowed;
  int line = 0;
};

/// An OpenCL call that failed, or no device to call.
class DeviceError : public std::runtime_error {
 public:
  /// `call`: "clEnqueueNDRangeKernel"; `code`: "CL_OUT_OF_RESOURCES"; `device`: its name; `advice`: what the user can
  /// do, may be empty.
  DeviceError(std::string call, std::string code, std::string device, const std::string& advice = "");
  std::string call, code, device;
};

/// A kernel source that the device's compiler refused. The log names our files and lines.
class KernelBuildError : public std::runtime_error {
 public:
  KernelBuildError(std::string source, std::string options, std::string log);
  std::string source, options, log;
};

}  // namespace tactel
