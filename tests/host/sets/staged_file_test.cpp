// SPDX-License-Identifier: Apache-2.0
#include "host/sets/staged_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <random>

#include "tests/host/support/run_tactel.h"

namespace tactel::host {
namespace {

// Pieces of 3 MiB + 5 bytes in any order, more than two blocks of which stay incomplete for a while; the file is closed
// and opened between some, as after a kill.
TEST(StagedFile, HoldsWhatWasWrittenInAnyOrder) {
  const ScratchFolder folder;
  const std::string path = folder / "file";
  std::ofstream(path).close();
  std::mt19937 random(5);
  std::string bytes((3 << 20) + 5, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random());
  std::vector<std::pair<std::size_t, std::size_t>> pieces;  // begin, size
  for (std::size_t at = 0; at < bytes.size(); at += pieces.back().second)
    pieces.emplace_back(at, std::min<std::size_t>(1 + random() % 200000, bytes.size() - at));
  std::ranges::shuffle(pieces, random);
  std::optional<StagedFile> file(std::in_place, path);
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    const auto [at, size] = pieces[k];
    ASSERT_TRUE(file->write(at, std::string_view(bytes).substr(at, size)));
    if (k % 7 != 6) continue;
    ASSERT_TRUE(file->flush());
    if (k % 2 == 0) file.emplace(path);
  }
  ASSERT_TRUE(file->flush());
  std::string read = text_of(path);
  ASSERT_GE(read.size(), bytes.size());
  EXPECT_EQ(read.substr(bytes.size()), std::string(read.size() - bytes.size(), '\0'));  // to a whole page
  read.resize(bytes.size());
  EXPECT_TRUE(read == bytes);
}

TEST(StagedFile, SaysThatADeviceIsFull) {
  StagedFile file("/dev/full");
  EXPECT_TRUE(file.write(0, "row"));
  EXPECT_FALSE(file.flush());
  EXPECT_EQ(errno, ENOSPC);
}

TEST(StagedFile, ThrowsWhereThereIsNoFile) {
  const ScratchFolder folder;
  EXPECT_THROW(StagedFile(folder / "none"), std::system_error);
}

}  // namespace
}  // namespace tactel::host
