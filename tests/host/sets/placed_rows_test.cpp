// SPDX-License-Identifier: Apache-2.0
#include "host/sets/placed_rows.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/host/support/run_tactel.h"

namespace tactel::host {
namespace {

// Published values (Wikipedia, "Fletcher's checksum", words with the low byte first), each half with its bytes turned
// about: HDF5 takes the high byte first.
TEST(PlacedRows, FletcherChecksumsArePublishedOnes) {
  EXPECT_EQ(fletcher32("abcde"), 0x4ff029c7u);
  EXPECT_EQ(fletcher32("abcdef"), 0x50562a2du);
  EXPECT_EQ(fletcher32("abcdefgh"), 0xe1eb9195u);
  EXPECT_EQ(fletcher32(std::string(3000, '\0')), 0u);
  EXPECT_EQ(fletcher32(std::string(3000, '\xff')), 0xffffffffu);  // multiples of 65535 stay, as they are not 0
}

// Nine rows of two datasets in stripes of four: however they come, each stays where it is.
TEST(PlacedRows, PlacesDoNotDependOnThePieces) {
  const ScratchFolder folder;
  const std::string wide = "aaabbbcccdddeeefffggghhhiii", narrow = "123456789";
  std::string whole;
  for (const std::vector<std::uint64_t>& pieces :
       std::vector<std::vector<std::uint64_t>>{{9}, {1, 1, 1, 1, 1, 1, 1, 1, 1}, {3, 6}, {4, 4, 1}, {0, 8, 1}}) {
    const std::string path = folder / "rows";
    std::ofstream(path).close();
    StagedFile file(path);
    std::vector<PlacedRows::Dataset> datasets;
    datasets.push_back({"wide", 3});
    datasets.push_back({"narrow", 1});
    PlacedRows rows(std::move(datasets), 4);
    std::uint64_t end = 0, at = 0;
    for (const std::uint64_t count : pieces) {
      const std::vector<std::string_view> values = {std::string_view(wide).substr(3 * at, 3 * count),
                                                    std::string_view(narrow).substr(at, count)};
      ASSERT_TRUE(rows.append(file, end, count, values));
      at += count;
    }
    ASSERT_TRUE(rows.finish(file));
    ASSERT_TRUE(file.flush());
    std::string bytes = text_of(path);
    ASSERT_GE(bytes.size(), end);  // whole pages
    bytes.resize(end);
    EXPECT_EQ(end, 3 * (12 + 4 + 4 + 4));
    EXPECT_EQ(bytes.substr(0, 12), "aaabbbcccddd");
    EXPECT_EQ(bytes.substr(16, 4), "1234");
    EXPECT_EQ(bytes.substr(48, 12), std::string("iii") + std::string(9, '\0'));
    if (whole.empty()) whole = bytes;
    EXPECT_EQ(bytes, whole);
    EXPECT_EQ(rows.datasets()[0].sum.text(), checksum_text(wide));
  }
}

}  // namespace
}  // namespace tactel::host
