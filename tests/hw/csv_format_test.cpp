// SPDX-License-Identifier: Apache-2.0

// Frames of lines of numbers: values bit for bit, times to the nanosecond, and lines without one.
#include <gtest/gtest.h>

#include <array>

#include "hw/decoder.h"
#include "hw/formats.h"

namespace tactel::hw::tests::csv_format_test {

TEST(CsvFormat, GivesBackValuesAndTimes) {
  const std::array first{0.1, -1e300, 16777217.0}, second{1.0, 2.0, 3.0};
  std::vector<std::uint8_t> bytes;
  append_csv_frame(0, 1.7e9 + 0.125, first, bytes);
  append_csv_frame(1, std::nullopt, second, bytes);
  append_csv_frame(4, 0.0, second, bytes);
  append_csv_frame(5, csv_latest_time, second, bytes);
  Decoder decoder(csv_format(3));
  std::vector<std::vector<double>> values;
  std::vector<std::optional<double>> times;
  decoder.feed(bytes, [&](const DecodedFrame& frame) {
    values.emplace_back(frame.values.begin(), frame.values.end());
    times.push_back(frame.device_time);
  });
  ASSERT_EQ(values.size(), 4u);
  EXPECT_EQ(values[0], std::vector<double>(first.begin(), first.end()));
  EXPECT_EQ(values[3], std::vector<double>(second.begin(), second.end()));
  EXPECT_NEAR(times[0].value(), 1.7e9 + 0.125, 3e-7);  // a double of 1.7e9 has steps of 2.4e-7
  EXPECT_EQ(times[1], std::nullopt);
  EXPECT_EQ(times[2], 0.0);
  EXPECT_NEAR(times[3].value(), csv_latest_time, 2e-6);  // alike
  EXPECT_EQ(decoder.counts(), (DecoderCounts{.frames = 4, .lost = 2}));
}

}  // namespace tactel::hw::tests::csv_format_test
