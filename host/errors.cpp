#include "host/errors.h"

namespace tactel {
namespace {

// "scene.toml: sensor.poisson = 0.5: must be ...", without the parts that are empty.
std::string config_message(const std::string& file, const std::string& key, const std::string& value,
                           const std::string& allowed) {
  std::string text = file;
  if (!key.empty()) text += (text.empty() ? "" : ": ") + key;
  if (!value.empty()) text += (key.empty() ? ": " : " = ") + value;
  return text + ": must be " + allowed;
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
