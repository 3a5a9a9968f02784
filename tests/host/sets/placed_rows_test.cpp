// SPDX-License-Identifier: Apache-2.0
#include "host/sets/placed_rows.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

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

/// Two datasets in stripes of four rows.
PlacedRows two_datasets() {
  std::vector<PlacedRows::Dataset> datasets;
  datasets.push_back({"wide", 3});
  datasets.push_back({"narrow", 1});
  return {std::move(datasets), 4};
}

// Nine rows: however they come, each stays where it is. Each piece is placed by another process, which has the tail of
// the one before; the last writes the last stripe, and all others theirs after it.
TEST(PlacedRows, PlacesDoNotDependOnThePiecesAndProcesses) {
  const ScratchFolder folder;
  const std::string wide = "aaabbbcccdddeeefffggghhhiii", narrow = "123456789";
  std::string whole;
  for (const std::vector<std::uint64_t>& pieces : std::vector<std::vector<std::uint64_t>>{
           {9}, {1, 1, 1, 1, 1, 1, 1, 1, 1}, {3, 6}, {4, 4, 1}, {0, 8, 1}, {2, 7}}) {
    const std::string path = folder / "rows";
    std::ofstream(path).close();
    DirectFile file(path);
    struct Unwritten {
      std::vector<PlacedRows::Stripe> stripes;
      PlacedRows::Values values;
    };
    std::vector<Unwritten> unwritten;
    PlacedRows rows = two_datasets();
    std::uint64_t end = 0, at = 0;
    for (const std::uint64_t count : pieces) {
      const PlacedRows::Values values = {std::string_view(wide).substr(3 * at, 3 * count),
                                         std::string_view(narrow).substr(at, count)};
      unwritten.push_back({rows.place(end, count, values), values});
      at += count;
      PlacedRows next = two_datasets();
      std::uint64_t same_end = 0;
      next.skip(same_end, at);
      EXPECT_EQ(same_end, end);
      const std::string tail = rows.tail();
      std::string_view bytes = tail;
      next.take_tail(bytes);
      EXPECT_TRUE(bytes.empty());
      rows = std::move(next);
    }
    ASSERT_TRUE(rows.flush(file));
    for (auto piece = unwritten.rbegin(); piece != unwritten.rend(); ++piece)
      for (PlacedRows::Stripe& stripe : piece->stripes) ASSERT_TRUE(rows.write(file, std::move(stripe), piece->values));
    const std::string bytes = text_of(path);
    EXPECT_EQ(bytes.size(), end);
    EXPECT_EQ(end, 3 * page_bytes);
    EXPECT_EQ(bytes.substr(0, 12), "aaabbbcccddd");
    EXPECT_EQ(bytes.substr(16, 4), "1234");
    EXPECT_EQ(bytes.substr(2 * page_bytes, 12), std::string("iii") + std::string(9, '\0'));
    if (whole.empty()) whole = bytes;
    EXPECT_EQ(bytes, whole);
    EXPECT_EQ(rows.datasets()[0].sum.text(), checksum_text(wide));

    PlacedRows again = two_datasets();
    std::vector<std::string> values;
    const int open = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    end = 0;
    EXPECT_TRUE(again.read(open, end, 9, values));
    EXPECT_EQ(values, (std::vector{wide, narrow}));
    end = 0;
    EXPECT_FALSE(again.read(open, end, 13, values));  // beyond the end
    ::close(open);
  }
}

}  // namespace
}  // namespace tactel::host
