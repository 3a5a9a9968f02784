// SPDX-License-Identifier: Apache-2.0
#include "fem/numbers/array_cache.h"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>

#include "tests/scratch.h"

namespace tactel::fem::array_cache_test {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

TEST(ArrayCache, IsBoundedByWhatWasNotReadForLongest) {
  const ScratchFolder folder;
  const fs::path directory = folder / "";
  std::vector<double> numbers(100, 1.5);  // some 900 bytes a file
  const auto file = [&](const std::string& key) { return cache_file(directory, "pad", "sides", key); };
  const std::array<std::span<const double>, 1> written{numbers};
  const std::array<std::span<double>, 1> read{numbers};
  for (const char* key : {"a", "b", "c"}) {
    write_arrays(file(key), written);
    fs::last_write_time(file(key).path, fs::file_time_type::clock::now() - 1h);
  }
  const fs::path other = directory / "networks.toml";  // of somebody else
  std::ofstream(other) << std::string(5000, 'x');
  ASSERT_TRUE(read_arrays(file("a"), read));  // used last
  bound_cache(directory, 1500);
  EXPECT_TRUE(fs::exists(file("a").path));
  EXPECT_FALSE(fs::exists(file("b").path) || fs::exists(file("c").path));
  EXPECT_TRUE(fs::exists(other));
  EXPECT_EQ(most_cached, 1u << 30);
}

}  // namespace tactel::fem::array_cache_test
