// SPDX-License-Identifier: Apache-2.0
#include "host/commands/devices_command.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host/device/device.h"
#include "host/support/errors.h"

namespace tactel::host::devices_command_test {

using testing::HasSubstr;

TEST(DevicesCommand, TableAndJsonSayTheSame) {
  std::ostringstream table, json, complaints;
  EXPECT_EQ(devices_command(false, table, complaints), 0);
  EXPECT_EQ(devices_command(true, json, complaints), 0);
  EXPECT_EQ(complaints.str(), "");
  const auto list = nlohmann::json::parse(json.str());
  const auto devices = list_devices();
  ASSERT_EQ(list.size(), devices.size());
  for (const DeviceInfo& info : devices) {
    EXPECT_THAT(table.str(), HasSubstr(info.name));
    const auto& each = list[info.index];
    EXPECT_EQ(each["name"], info.name);
    EXPECT_EQ(each["lanes"]["fp32"], info.lanes_fp32);
    EXPECT_EQ(each["lanes"]["fp64"], info.lanes_fp64);
    EXPECT_EQ(each["default"], info.index == default_device(devices));
  }
}

// The environment must be set before the first OpenCL call: in a process of its own.
TEST(DevicesCommandDeathTest, WithoutDevicesTheErrorNamesTheUsersVariable) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto without_devices = [] {
    setenv("OCL_ICD_VENDORS", "/nonexistent", 1);
    std::ostringstream out;
    const int code = devices_command(false, out, std::cerr);
    try {
      const Device device;
    } catch (const DeviceError& error) {
      std::cerr << error.what();
      std::exit(code);
    }
    std::exit(0);
  };
  EXPECT_EXIT(without_devices(), testing::ExitedWithCode(3),
              "no OpenCL device; OCL_ICD_VENDORS = /nonexistent is set and may hide the devices: unset it");
}

}  // namespace tactel::host::devices_command_test
