// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <fstream>
#include <string>

#include "test_paths.h"

namespace tactel::hw::udev_rules_test {

using ::testing::AnyOf;
using ::testing::HasSubstr;

// A vendor's number, or a sample id that many boards carry, would open devices that have nothing to do with sensors.
TEST(UdevRules, EachNamesItsDeviceCloselyAndTheSeatsUserAlone) {
  std::ifstream in(TACTEL_SOURCE_DIR "/scripts/70-tactel.rules");
  int rules = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    ++rules;
    EXPECT_THAT(line, HasSubstr("ATTR{idVendor}==")) << line;
    EXPECT_THAT(line, HasSubstr("ATTR{idProduct}==")) << line;
    EXPECT_THAT(line, AnyOf(HasSubstr("ATTR{product}=="), HasSubstr("ATTR{serial}=="))) << line;
    EXPECT_THAT(line, HasSubstr("TAG+=\"uaccess\"")) << line;
    EXPECT_THAT(line, ::testing::Not(HasSubstr("MODE"))) << line;
  }
  EXPECT_GT(rules, 0);
}

}  // namespace tactel::hw::udev_rules_test
