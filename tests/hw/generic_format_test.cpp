// SPDX-License-Identifier: Apache-2.0
#include "hw/generic_format.h"

#include <gmock/gmock.h>

#include "fem/numbers/value_error.h"
#include "tests/hw/byte_vectors.h"

namespace tactel::hw::tests::generic_format_test {

using ::testing::ElementsAre;

GenericLayout small_layout() {
  return {.sync = {0xA5, 0x5A},
          .header = 4,
          .counter = {2, 1},
          .clock = {3, 1},
          .clock_tick = 1e-3,
          .channels = 2,
          .confirmations = 1};
}

TEST(GenericFormat, SampleTypesInBothByteOrders) {
  struct {
    SampleType type;
    bool big_endian;
    ByteVector samples;
    double first, second;
  } const cases[] = {{SampleType::u16, false, {0x01, 0x02, 0xFF, 0xFF}, 513, 65535},
                     {SampleType::u16, true, {0x01, 0x02, 0xFF, 0xFF}, 258, 65535},
                     {SampleType::i16, false, {0xFE, 0xFF, 0x00, 0x80}, -2, -32768},
                     {SampleType::i32, true, {0xFF, 0xFF, 0xFF, 0xFE, 0, 0, 1, 0}, -2, 256},
                     {SampleType::f32, false, {0, 0, 0xC0, 0x3F, 0, 0, 0, 0xC0}, 1.5, -2},
                     {SampleType::f64, true, {0x3F, 0xF8, 0, 0, 0, 0, 0, 0, 0xC0, 0, 0, 0, 0, 0, 0, 0}, 1.5, -2}};
  for (const auto& c : cases) {
    GenericLayout layout = small_layout();
    layout.sample = c.type;
    layout.big_endian = c.big_endian;
    ByteVector frame = {0xA5, 0x5A, 9, 250};
    append(frame, c.samples);
    const Decoded decoded = decode(generic_format(layout), frame);
    ASSERT_EQ(decoded.values.size(), 1u);
    EXPECT_THAT(decoded.values[0], ElementsAre(c.first, c.second));
    EXPECT_DOUBLE_EQ(*decoded.device_time[0], 0.250);
  }
}

TEST(GenericFormat, Checksums) {
  EXPECT_EQ(crc16(Bytes(reinterpret_cast<const std::uint8_t*>("123456789"), 9)),
            0x29B1);  // the catalogue's check value
  struct {
    Checksum kind;
    ByteVector sum;
  } const cases[] = {{Checksum::sum8, {0x1A}}, {Checksum::sum16, {0x1A, 0x01}}, {Checksum::xor8, {0xF2}}};
  for (const auto& c : cases) {  // A5 + 5A + 01 + 02 + 03 + 04 + 05 + 0C = 11A, exclusive or of them F2
    GenericLayout layout = small_layout();
    layout.checksum = c.kind;
    layout.trailer = {0x77};
    ByteVector frame = {0xA5, 0x5A, 1, 2, 3, 4, 5, 0x0C};
    append(frame, c.sum);
    frame.push_back(0x77);
    EXPECT_EQ(decode(generic_format(layout), frame).counts.frames, 1u);
    frame[4] ^= 1;
    EXPECT_EQ(decode(generic_format(layout), frame).counts.frames, 0u);
  }
}

ByteVector counted(std::initializer_list<int> counters, int clock_step = 0) {
  ByteVector stream;
  int clock = 0;
  for (const int counter : counters) {
    append(stream, {0xA5, 0x5A, static_cast<std::uint8_t>(counter), static_cast<std::uint8_t>(clock), 1, 0, 2, 0});
    clock += clock_step;
  }
  return stream;
}

TEST(GenericFormat, CountsLostAndDuplicatedFramesThroughTheWrap) {
  EXPECT_EQ(decode(generic_format(small_layout()), counted({254, 255, 0, 1})).counts, (DecoderCounts{.frames = 4}));
  EXPECT_EQ(decode(generic_format(small_layout()), counted({254, 1, 1, 2})).counts,
            (DecoderCounts{.frames = 3, .lost = 2, .duplicated = 1}));
  EXPECT_EQ(decode(generic_format(small_layout()), counted({100, 3, 4})).counts,
            (DecoderCounts{.frames = 3, .lost = 0}))
      << "a device that began anew has lost nothing";
}

TEST(GenericFormat, TheClockGoesOnThroughItsWrap) {
  const Decoded decoded = decode(generic_format(small_layout()), counted({1, 2, 3, 4}, 100));
  EXPECT_DOUBLE_EQ(*decoded.device_time[2], 0.200);
  EXPECT_DOUBLE_EQ(*decoded.device_time[3], 0.300);  // sent as 300 - 256 = 44
}

// The samples of the true frames hold the sync bytes while the stream begins in the middle of a frame.
TEST(GenericFormat, SyncBytesInsideThePayloadDoNotRotateTheImage) {
  GenericLayout layout = small_layout();
  layout.confirmations = 3;
  ByteVector stream = {0xA5, 0x5A, 7, 7};
  for (int i = 0; i < 8; ++i) {
    append(stream, {0xA5, 0x5A, static_cast<std::uint8_t>(i), 0});
    append(stream, i < 2 ? ByteVector{0xA5, 0x5A, 7, 7} : ByteVector{1, 0, 2, 0});
  }
  const Decoded decoded = decode(generic_format(layout), stream);
  ASSERT_GE(decoded.values.size(), 6u);
  EXPECT_THAT(decoded.values.back(), ElementsAre(1, 2));
  EXPECT_EQ(decoded.counts.lost, 0u);
}

TEST(GenericFormat, WritesWhatItReads) {
  GenericLayout layout = small_layout();
  layout.sample = SampleType::i16;
  layout.checksum = Checksum::crc16;
  layout.trailer = {0x0D, 0x0A};
  for (const bool big_endian : {false, true}) {
    layout.big_endian = big_endian;
    ByteVector frame(generic_frame_length(layout));
    const double samples[] = {-1.6, 1e9};
    write_generic_frame(layout, 5, 6, samples, frame);
    const Decoded decoded = decode(generic_format(layout), frame);
    ASSERT_EQ(decoded.values.size(), 1u);
    EXPECT_THAT(decoded.values[0], ElementsAre(-2, 32767));
  }
}

TEST(GenericFormat, RefusesLayoutsThatCannotBeMeant) {
  const auto refused = [](auto&& change) {
    GenericLayout layout = small_layout();
    change(layout);
    EXPECT_THROW(layout.validate(), ValueError);
  };
  refused([](GenericLayout& l) { l.sync.clear(); });
  refused([](GenericLayout& l) { l.header = 1; });
  refused([](GenericLayout& l) { l.channels = 0; });
  refused([](GenericLayout& l) { l.channels = 1'000'000; });
  refused([](GenericLayout& l) { l.counter = {3, 2}; });
  refused([](GenericLayout& l) { l.counter = {2, 3}; });
  refused([](GenericLayout& l) { l.clock = {-1, 1}; });
  refused([](GenericLayout& l) { l.clock_tick = 0; });
  refused([](GenericLayout& l) { l.checksum_from = 99; });
  refused([](GenericLayout& l) { l.confirmations = 0; });
}

}  // namespace tactel::hw::tests::generic_format_test
