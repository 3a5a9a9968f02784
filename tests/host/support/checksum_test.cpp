// SPDX-License-Identifier: Apache-2.0
#include "host/support/checksum.h"

#include <gtest/gtest.h>

#include <string>

namespace tactel::host::checksum_test {

// Published values (Wikipedia, "Fletcher's checksum", words with the low byte first), each half with its bytes turned
// about: HDF5 takes the high byte first.
TEST(Checksum, FletchersArePublishedOnes) {
  EXPECT_EQ(fletcher32("abcde"), 0x4ff029c7u);
  EXPECT_EQ(fletcher32("abcdef"), 0x50562a2du);
  EXPECT_EQ(fletcher32("abcdefgh"), 0xe1eb9195u);
  EXPECT_EQ(fletcher32(std::string(3000, '\0')), 0u);
  EXPECT_EQ(fletcher32(std::string(3000, '\xff')), 0xffffffffu);  // multiples of 65535 stay, as they are not 0
}

}  // namespace tactel::host::checksum_test
