// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gmock/gmock.h>

#include <map>
#include <string>
#include <vector>

#include "host/device/executor.h"

namespace tactel::host {

/// The devices that tests run on: PoCL's two, whatever else there is. By the beginning of their names.
inline std::vector<std::string> tested_devices() { return {"basic", "pthread"}; }

/// Opened once a process: a context takes some 50 ms.
inline const Device& device(const std::string& choice = "basic") {
  static std::map<std::string, Device> opened;
  const auto found = opened.find(choice);
  return found != opened.end() ? found->second : opened.emplace(choice, Device(choice)).first->second;
}

/// Of all threads on the default device.
inline Executor& executor() {
  static Executor executor{Device()};
  return executor;
}

/// `basic` with each number of lanes that a device may have, with vectors in two halves and whole, as single contacts
/// run on it, and as a GPU.
inline std::vector<Device> devices_of_all_lanes() {
  const Device basic("basic");
  std::vector<Device> devices;
  for (const int lanes : {16, 1, 2, 4, 8}) devices.push_back(basic.with_lanes(lanes));
  for (const bool halves : {false, true}) devices.push_back(basic.with_halves(halves));
  devices.push_back(basic.for_one_contact());
  devices.push_back(basic.as_gpu());
  return devices;
}

inline Defines lanes_of(const Device& device, Precision precision) {
  return {{"LANES", std::to_string(device.lanes(precision))}, {"REAL", real_type(precision)}};
}

/// Matches a call that throws a DeviceError of this OpenCL call and code, on a device of such a name.
inline auto throws_device_error(const std::string& call, const std::string& code, const std::string& device = "") {
  using ::testing::Field;
  return ::testing::Throws<DeviceError>(::testing::AllOf(Field(&DeviceError::call, call),
                                                         Field(&DeviceError::code, code),
                                                         Field(&DeviceError::device, ::testing::StartsWith(device))));
}

}  // namespace tactel::host
