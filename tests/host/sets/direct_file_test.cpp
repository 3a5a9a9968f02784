// SPDX-License-Identifier: Apache-2.0
#include "host/sets/direct_file.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "tests/host/support/run_tactel.h"

namespace tactel::host {
namespace {

Pages pages_of(char letter, std::size_t bytes) {
  Pages pages(bytes);
  std::memset(pages.data(), letter, bytes);
  return pages;
}

TEST(DirectFile, HoldsWholePagesInAnyOrder) {
  const ScratchFolder folder;
  const std::string path = folder / "file";
  std::ofstream(path).close();
  DirectFile file(path);
  ASSERT_TRUE(file.write(2 * page_bytes, pages_of('b', 5)));
  ASSERT_TRUE(file.write(0, pages_of('a', page_bytes + 1)));
  ASSERT_TRUE(file.write(3 * page_bytes, Pages()));
  const auto zeros = [](std::size_t count) { return std::string(count, '\0'); };
  EXPECT_EQ(text_of(path), std::string(page_bytes + 1, 'a') + zeros(page_bytes - 1) + "bbbbb" + zeros(page_bytes - 5));
}

TEST(DirectFile, SaysThatADeviceIsFull) {
  DirectFile file("/dev/full");
  EXPECT_FALSE(file.write(0, pages_of('a', 3)));
  EXPECT_EQ(errno, ENOSPC);
}

TEST(DirectFile, ThrowsWhereThereIsNoFile) {
  const ScratchFolder folder;
  EXPECT_THROW(DirectFile(folder / "none"), std::system_error);
}

}  // namespace
}  // namespace tactel::host
