// SPDX-License-Identifier: Apache-2.0
#include "host/support/errors.h"

#include <algorithm>

namespace tactel {
namespace {

// "scene.toml: sensor.poisson = 0.5: must be ...", without the parts that are empty. Control characters, which a file's
// keys and values may hold, become blanks: the message stays one line, and a terminal shows it as it is.
std::string config_message(const std::string& file, const std::string& key, const std::string& value,
                           const std::string& allowed) {
  std::string text = file;
  if (!key.empty()) text += (text.empty() ? "" : ": ") + key;
  if (!value.empty()) text += (key.empty() ? ": " : " = ") + value;
  text += ": must be " + allowed;
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < 0x20 || c == 0x7F; }, ' ');
  return text;
}

std::string device_message(const std::string& call, const std::string& code, const std::string& device,
                           const std::string& advice) {
  std::string text = call + ": " + code;
  if (!device.empty()) text += " on device " + device;
  if (!advice.empty()) text += "; " + advice;
  return text;
}

}  // namespace

ConfigError::ConfigError(std::string file, std::string key, std::string value, std::string allowed)
    : std::runtime_error(config_message(file, key, value, allowed)),
      file(std::move(file)),
      key(std::move(key)),
      value(std::move(value)),
      allowed(std::move(allowed)) {}

DeviceError::DeviceError(std::string call, std::string code, std::string device, const std::string& advice)
    : std::runtime_error(device_message(call, code, device, advice)),
      call(std::move(call)),
      code(std::move(code)),
      device(std::move(device)) {}

KernelBuildError::KernelBuildError(std::string source, std::string options, std::string log)
    : std::runtime_error("building " + source + " with " + options + " failed:\n" + log),
      source(std::move(source)),
      options(std::move(options)),
      log(std::move(log)) {}

}  // namespace tactel
