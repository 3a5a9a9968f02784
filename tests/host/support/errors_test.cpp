// SPDX-License-Identifier: Apache-2.0
#include "host/support/errors.h"

#include <gtest/gtest.h>

namespace tactel::errors_test {

TEST(Errors, ConfigErrorNamesFileKeyValueAndWhatIsAllowed) {
  const ConfigError error("scene.toml", "sensor.poisson", "0.5", "at least 0 and below 0.5");
  EXPECT_STREQ(error.what(), "scene.toml: sensor.poisson = 0.5: must be at least 0 and below 0.5");
  EXPECT_EQ(error.file, "scene.toml");
  EXPECT_EQ(error.allowed, "at least 0 and below 0.5");
}

TEST(Errors, ConfigErrorLeavesOutWhatIsEmpty) {
  EXPECT_STREQ(ConfigError("", "device", "x", "y").what(), "device = x: must be y");
  EXPECT_STREQ(ConfigError("scene.toml", "", "", "readable").what(), "scene.toml: must be readable");
  EXPECT_STREQ(ConfigError("scene.toml", "sensor.x", "", "left out").what(), "scene.toml: sensor.x: must be left out");
}

// A key of a TOML file may be any text: "\u001b[31m" would colour the user's terminal.
TEST(Errors, AMessageIsOneLineWithoutControlCharacters) {
  const ConfigError error("scene.toml", "\x1b[31mred\n", "a\tb\x7F", "known");
  EXPECT_STREQ(error.what(), "scene.toml:  [31mred  = a b : must be known");
  EXPECT_EQ(error.key, "\x1b[31mred\n");
}

TEST(Errors, AValueErrorGetsItsFile) {
  const ConfigError error("scene.toml", ValueError("sensor.rows", "1", "at least 2"));
  EXPECT_STREQ(error.what(), "scene.toml: sensor.rows = 1: must be at least 2");
}

TEST(Errors, DeviceErrorNamesCallCodeDeviceAndAdvice) {
  EXPECT_STREQ(DeviceError("clFinish", "CL_OUT_OF_RESOURCES", "gpu", "use less").what(),
               "clFinish: CL_OUT_OF_RESOURCES on device gpu; use less");
}

}  // namespace tactel::errors_test
