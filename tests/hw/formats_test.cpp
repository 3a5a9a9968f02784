// SPDX-License-Identifier: Apache-2.0

// What each format reads from frames written by hand, and marks that stand inside payloads.
#include "hw/formats.h"

#include <gmock/gmock.h>

#include "fem/numbers/value_error.h"
#include "tests/hw/byte_vectors.h"

namespace tactel::hw::tests::formats_test {

using ::testing::ElementsAre;

TEST(GloveFormat, ReadsPressuresOfAllCells) {
  const Decoded decoded = decode(glove_format(), glove_frame(1000));
  ASSERT_EQ(decoded.values.size(), 1u);
  for (int ch = 0; ch < 64; ++ch) EXPECT_EQ(decoded.values[0][static_cast<std::size_t>(ch)], 4095 - (1000 + ch));
  EXPECT_FALSE(decoded.device_time[0]);
}

TEST(GloveFormat, PublishedPacketByHand) {
  ByteVector stream = glove_frame(0);
  stream[2] = 0x0A, stream[3] = 0xBC;  // cell 0: 0xABC = 2748
  EXPECT_EQ(decode(glove_format(), stream).values[0][0], 4095 - 2748);
}

TEST(GloveFormat, IdsInsideReadingsDoNotRotateTheImage) {
  ByteVector frame = glove_frame(0);
  for (std::size_t cell = 0; cell < 64; ++cell) frame[5 * cell + 2] = 0x3C, frame[5 * cell + 3] = 0x01;
  ByteVector stream(frame.begin() + 2, frame.end());  // begins inside a frame, with what looks like cell 0
  for (int i = 0; i < 2; ++i) append(stream, frame);
  const Decoded decoded = decode(glove_format(), stream);
  EXPECT_EQ(decoded.values.size(), 2u);
  for (const auto& image : decoded.values) EXPECT_THAT(image, ::testing::Each(4095 - 0xC01));
}

TEST(GloveFormat, AnImageWithAMissingCellIsNotShown) {
  ByteVector stream = glove_frame(0), cut = glove_frame(1);
  cut.erase(cut.begin() + 100, cut.begin() + 105);  // cell 20
  append(stream, cut);
  append(stream, glove_frame(2));
  const Decoded decoded = decode(glove_format(), stream);
  ASSERT_EQ(decoded.values.size(), 2u);
  EXPECT_EQ(decoded.values[1][0], 4095 - 2);
  EXPECT_EQ(decoded.counts, (DecoderCounts{.frames = 2, .bad = 1, .resynchronised = 1, .discarded = 315}));
}

TEST(PapillarrayFormat, PublishedLengths) {
  EXPECT_EQ(papillarray_frame({}).size(), 433u);
  EXPECT_EQ(papillarray_frame({.sensors = 2}).size(), 815u);
}

TEST(PapillarrayFormat, ReadsForcesDisplacementsCounterAndClock) {
  const PapillarrayBlocks blocks{.sensors = 2, .counter = 7, .microseconds = 2'500'000, .first_force = -1.5f};
  const Decoded decoded = decode(papillarray_format(2), papillarray_frame(blocks));
  ASSERT_EQ(decoded.values.size(), 1u);
  const auto& values = decoded.values[0];
  ASSERT_EQ(values.size(), 108u);
  EXPECT_EQ(values[0], -1.5);
  EXPECT_EQ(values[1], 0.125);
  EXPECT_EQ(values[6 * 8 + 5], 8.625);        // Dz of the last pillar of the first sensor
  EXPECT_EQ(values[54 + 6 * 3 + 2], 103.25);  // Fz of the fourth pillar of the second
  EXPECT_EQ(decoded.device_time[0], 2.5);
}

TEST(PapillarrayFormat, MarksInsideAFloatAreData) {
  const float tail = float_of_bytes(0xAA, 0xBB, 0xCC, 0xDD), head = float_of_bytes(0x55, 0x66, 0x77, 0x88);
  ByteVector stream = papillarray_frame({.counter = 1, .first_force = tail});
  append(stream, papillarray_frame({.counter = 2, .first_force = head}));
  const Decoded decoded = decode(papillarray_format(1), stream);
  ASSERT_EQ(decoded.values.size(), 2u);
  EXPECT_EQ(decoded.values[0][0], tail);
  EXPECT_EQ(decoded.values[1][0], head);
  EXPECT_EQ(decoded.counts, (DecoderCounts{.frames = 2}));
}

TEST(PapillarrayFormat, BeginsInsideAFrameWithAHeadInItsPayload) {
  const PapillarrayBlocks blocks{.first_force = float_of_bytes(0x55, 0x66, 0x77, 0x88)};
  const ByteVector frame = papillarray_frame(blocks);
  ByteVector stream(frame.begin() + 30, frame.end());
  append(stream, frame);
  EXPECT_EQ(decode(papillarray_format(1), stream).values.size(), 1u);
}

TEST(PapillarrayFormat, AWrongChecksumCostsItsFrameAlone) {
  ByteVector stream = papillarray_frame({.counter = 1}), broken = papillarray_frame({.counter = 2});
  broken[100] ^= 0x40;
  append(stream, broken);
  append(stream, papillarray_frame({.counter = 3}));
  const Decoded decoded = decode(papillarray_format(1), stream);
  EXPECT_EQ(decoded.counts, (DecoderCounts{.frames = 2, .lost = 1, .bad = 1, .discarded = 433}));
}

TEST(PapillarrayFormat, UndocumentedBlocksArePassedOver) {
  ByteVector stream;
  for (const std::uint32_t i : {1u, 2u}) append(stream, papillarray_frame({.counter = i, .undocumented = true}));
  EXPECT_EQ(decode(papillarray_format(1), stream).counts, (DecoderCounts{.frames = 2}));
}

ByteVector anyskin_stream(int frames, float fifth) {
  ByteVector stream;
  for (int i = 0; i < frames; ++i) append(stream, anyskin_frame(20.5f + static_cast<float>(i), fifth));
  return stream;
}

TEST(AnyskinFormat, ReadsTwentyValues) {
  const Decoded decoded = decode(anyskin_format(), anyskin_stream(4, 0));
  ASSERT_EQ(decoded.values.size(), 4u);
  EXPECT_EQ(decoded.values[0][0], 20.5);
  EXPECT_EQ(decoded.values[3][19], 42.5);
}

// A fingertip has two, a skin of the larger kind sixteen.
TEST(AnyskinFormat, ReadsOtherNumbersOfMagnetometers) {
  for (const int magnetometers : {2, 16}) {
    ByteVector stream;
    for (int i = 0; i < 6; ++i) append(stream, anyskin_frame(20.5f + static_cast<float>(i), 0, magnetometers));
    stream.erase(stream.begin(), stream.begin() + 7);
    const Decoded decoded = decode(anyskin_format(magnetometers), stream);
    ASSERT_EQ(decoded.values.size(), 5u);
    EXPECT_EQ(decoded.values[4].size(), static_cast<std::size_t>(4 * magnetometers));
    EXPECT_EQ(decoded.values[4].back(), 20.5 + 5 + 4 * magnetometers - 1);
  }
}

// 0D 0A at each byte of a float that never changes, and a stream that begins just behind it.
TEST(AnyskinFormat, ALineEndInsideAFloatIsNoLineEnd) {
  const float inside[] = {float_of_bytes(0x0D, 0x0A, 0x80, 0x41), float_of_bytes(0x12, 0x0D, 0x0A, 0x42)};
  for (std::size_t place = 0; place < 2; ++place) {
    const ByteVector whole = anyskin_stream(12, inside[place]);
    const ByteVector stream(whole.begin() + static_cast<long>(20 + place + 2), whole.end());
    const Decoded decoded = decode(anyskin_format(), stream);
    ASSERT_EQ(decoded.values.size(), 11u);
    for (const auto& values : decoded.values) EXPECT_EQ(values[5], inside[place]);
  }
}

TEST(AnyskinFormat, FindsItsFramesAgainAfterALostByte) {
  ByteVector stream = anyskin_stream(12, 0);
  stream.erase(stream.begin() + 5 * 82 + 17);
  const Decoded decoded = decode(anyskin_format(), stream);
  EXPECT_EQ(decoded.counts, (DecoderCounts{.frames = 11, .resynchronised = 1, .discarded = 81}));
}

TEST(AgniFormat, PutsReadingsByTheirIds) {
  const ByteVector frame = agni_frame(300);
  ASSERT_EQ(frame.size(), 200u);
  const Decoded decoded = decode(agni_format(), frame);
  ASSERT_EQ(decoded.values.size(), 1u);
  for (std::size_t i = 0; i < 64; ++i) EXPECT_EQ(decoded.values[0][i], 300.0 + static_cast<double>(i));
}

TEST(AgniFormat, AFalseParityOrADoubledIdIsBad) {
  ByteVector flipped = agni_frame(1), doubled = agni_frame(1), stream = agni_frame(0);
  flipped[50] ^= 1;
  doubled[7] ^= 1, doubled.back() ^= 1;  // id 63 becomes 62, the parity agrees
  append(stream, flipped);
  append(stream, doubled);
  append(stream, agni_frame(2));
  EXPECT_EQ(decode(agni_format(), stream).counts.frames, 2u);
}

TEST(PaxiniFormat, ReadsSignedShearAndUnsignedNormalForce) {
  ByteVector stream = paxini_frame(0x80);
  append(stream, paxini_frame(1));
  const Decoded decoded = decode(paxini_format(2, 2), stream);
  ASSERT_EQ(decoded.values.size(), 2u);
  EXPECT_THAT(decoded.values[0], ElementsAre(-128, -1, 200, 3, 4, 5, 6, 7, 8, 9, 10, 11));
}

TEST(PaxiniFormat, TheBoardsOwnErrorIsABadFrame) {
  ByteVector stream, error = paxini_frame(1);
  error[5] = 1, error.back() -= 1;
  for (int i = 0; i < 2; ++i) append(stream, paxini_frame(1));
  append(stream, error);
  for (int i = 0; i < 2; ++i) append(stream, paxini_frame(1));
  const Decoded decoded = decode(paxini_format(2, 2), stream);
  EXPECT_EQ(decoded.counts, (DecoderCounts{.frames = 4, .bad = 1, .discarded = 31}));
}

TEST(Formats, RefuseWhatCannotBeMeant) {
  EXPECT_THROW(papillarray_format(3), ValueError);
  EXPECT_THROW(anyskin_format(0), ValueError);
  EXPECT_THROW(anyskin_format(65), ValueError);
  EXPECT_THROW(paxini_format(0, 9), ValueError);
  EXPECT_THROW(paxini_format(1, 100000), ValueError);
}

}  // namespace tactel::hw::tests::formats_test
