// SPDX-License-Identifier: Apache-2.0
#include "tests/hw/guest/rig.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <thread>

namespace tactel::hw::tests {
namespace {

std::string word_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string word;
  in >> word;
  return word;
}

}  // namespace

std::string device_folder() {
  const auto is_hub_or_interface = [](const std::string& name) {
    return name.starts_with("usb") || name.find(':') != name.npos;
  };
  for (const auto& entry : std::filesystem::directory_iterator("/sys/bus/usb/devices"))
    if (!is_hub_or_interface(entry.path().filename()) && word_of(entry.path() / "idVendor") == "04d8" &&
        word_of(entry.path() / "bConfigurationValue") == "1")
      return entry.path();
  return {};
}

void wait_for_device(bool there) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (device_folder().empty() == there) {
    if (std::chrono::steady_clock::now() > end)
      throw std::runtime_error(there ? "the kernel did not configure the device"
                                     : "the kernel did not drop the device");
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

}  // namespace tactel::hw::tests
