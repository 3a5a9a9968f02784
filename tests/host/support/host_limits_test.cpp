// SPDX-License-Identifier: Apache-2.0

// What a container hides of /sys.
#include "host/support/host_limits.h"

#include <gtest/gtest.h>

#include "tests/scratch.h"

namespace tactel::host::host_limits_test {

namespace fs = std::filesystem;

TEST(HostThreads, ProcessorsAreShown) {
  const ScratchFolder sys;
  EXPECT_FALSE(shows_processors(sys / ""));  // all of it is hidden
  fs::create_directories(sys / "devices/system/cpu/cpu0/topology");
  EXPECT_TRUE(shows_processors(sys / ""));  // a kernel without nodes
  fs::create_directories(sys / "devices/system/node");
  EXPECT_FALSE(shows_processors(sys / ""));  // with hidden ones
  fs::create_directories(sys / "devices/system/node/node0");
  EXPECT_TRUE(shows_processors(sys / ""));
  fs::create_directories(sys / "bus/node/devices");
  fs::create_directory_symlink("gone", sys / "bus/node/devices/node0");
  EXPECT_FALSE(shows_processors(sys / ""));
  fs::remove(sys / "bus/node/devices/node0");
  fs::create_directory_symlink("../../../devices/system/node/node0", sys / "bus/node/devices/node0");
  EXPECT_TRUE(shows_processors(sys / ""));
  fs::remove_all(sys / "devices/system/cpu/cpu0");
  EXPECT_FALSE(shows_processors(sys / ""));
}

}  // namespace tactel::host::host_limits_test
