// SPDX-License-Identifier: Apache-2.0

// What holds for every format: splits do not matter, damage costs what it must and no more, random bytes do no harm.
#include "hw/decoder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "hw/formats.h"
#include "hw/generic_format.h"
#include "tests/hw/byte_vectors.h"

namespace tactel::hw::tests::decoder_test {

struct Case {
  const char* name;
  std::function<std::unique_ptr<const WireFormat>()> format;
  std::function<ByteVector(int)> frame;
  bool checksum;  ///< a damaged frame shows: what is decoded was sent
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

GenericLayout crc_layout() {
  return {.sync = {0xA5, 0x5A},
          .header = 4,
          .counter = {2, 2},
          .channels = 2,
          .checksum = Checksum::crc16,
          .confirmations = 2};
}

ByteVector crc_frame(int i) {
  ByteVector frame = {0xA5, 0x5A, static_cast<std::uint8_t>(i), 0, 0xA5, 0x5A, static_cast<std::uint8_t>(3 * i), 0};
  put(frame, crc16(frame), 2);
  return frame;
}

const Case cases[] = {{"glove", glove_format, [](int i) { return glove_frame(37 * i); }, false},
                      {"papillarray", [] { return papillarray_format(1); },
                       [](int i) {
                         return papillarray_frame(
                             {.counter = static_cast<std::uint32_t>(i), .first_force = 0.5f * static_cast<float>(i)});
                       },
                       true},
                      {"anyskin", [] { return anyskin_format(); },
                       [](int i) { return anyskin_frame(20.0f + 1.7f * static_cast<float>(i)); }, false},
                      {"agni", agni_format, [](int i) { return agni_frame(100 * i); }, true},
                      {"paxini", [] { return paxini_format(2, 2); },
                       [](int i) { return paxini_frame(static_cast<std::uint8_t>(i)); }, true},
                      {"generic", [] { return generic_format(crc_layout()); }, crc_frame, true},
                      {"csv", [] { return csv_format(2); },
                       [](int i) {
                         ByteVector frame;
                         append_csv_frame(static_cast<std::uint64_t>(i), 0.1 * i, std::array{1.5, 1e-3 * i}, frame);
                         return frame;
                       },
                       true}};

class EveryFormat : public ::testing::TestWithParam<Case> {
 protected:
  ByteVector stream(int frames) const {
    ByteVector all;
    for (int i = 0; i < frames; ++i) append(all, GetParam().frame(i));
    return all;
  }
  Decoded run(const ByteVector& bytes, std::size_t first = 0, std::size_t part = static_cast<std::size_t>(-1)) const {
    return decode(GetParam().format(), bytes, first, part);
  }
  /// Whether every decoded frame is one of those sent.
  static bool all_sent(const Decoded& decoded, const Decoded& sent) {
    return std::ranges::all_of(decoded.values,
                               [&](const auto& v) { return std::ranges::find(sent.values, v) != sent.values.end(); });
  }
};

TEST_P(EveryFormat, DecodesACleanStreamWhole) { EXPECT_EQ(run(stream(8)).counts, (DecoderCounts{.frames = 8})); }

TEST_P(EveryFormat, SplitsDoNotMatter) {
  ByteVector bytes = stream(6);
  bytes.erase(bytes.begin() + static_cast<long>(bytes.size() / 3));  // with a search in the midst of it
  const Decoded whole = run(bytes);
  for (std::size_t split = 0; split <= bytes.size(); ++split)
    ASSERT_EQ(run(bytes, split), whole) << "split at " << split;
  for (const std::size_t part : {1, 2, 3, 7, 62, 63, 64, 65, 512})
    ASSERT_EQ(run(bytes, 0, part), whole) << "parts of " << part;
}

// At most the frame of the lost byte is missing, and one more whose beginning it touches. (It lies behind the first
// four frames, with which the slowest format finds its sync.)
TEST_P(EveryFormat, ALostByteCostsItsFrame) {
  const ByteVector bytes = stream(10);
  const Decoded sent = run(bytes);
  const std::size_t length = GetParam().frame(0).size();
  for (std::size_t at = 5 * length; at < 6 * length; ++at) {
    ByteVector damaged = bytes;
    damaged.erase(damaged.begin() + static_cast<long>(at));
    const Decoded decoded = run(damaged);
    ASSERT_GE(decoded.values.size(), 8u) << "byte " << at << " lost";
    ASSERT_TRUE(!GetParam().checksum || all_sent(decoded, sent)) << "byte " << at << " lost";
    ASSERT_EQ(decoded.values.back(), sent.values.back());
  }
}

TEST_P(EveryFormat, AFlippedBitIsNotDecodedAsAnotherFrame) {
  if (!GetParam().checksum) return;
  const ByteVector bytes = stream(6);
  const Decoded sent = run(bytes);
  const std::size_t length = GetParam().frame(0).size();
  for (std::size_t bit = 0; bit < 8 * length; ++bit) {
    ByteVector damaged = bytes;
    damaged[2 * length + bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
    const Decoded decoded = run(damaged);
    ASSERT_EQ(decoded.values.size(), 5u) << "bit " << bit;
    ASSERT_TRUE(all_sent(decoded, sent)) << "bit " << bit;
  }
}

TEST_P(EveryFormat, StartsAnywhere) {
  const ByteVector bytes = stream(8);
  const Decoded sent = run(bytes);
  const std::size_t length = GetParam().frame(0).size();
  for (std::size_t begin = 1; begin < length; ++begin) {
    const Decoded decoded = run({bytes.begin() + static_cast<long>(begin), bytes.end()});
    ASSERT_EQ(decoded.values, std::vector(sent.values.begin() + 1, sent.values.end())) << "from byte " << begin;
    ASSERT_EQ(decoded.counts.resynchronised, 0u);
  }
}

TEST_P(EveryFormat, GoesOnAfterAnInterruption) {
  const ByteVector bytes = stream(10);
  const std::size_t length = GetParam().frame(0).size();
  Decoder decoder(GetParam().format());
  const FrameSink sink = [](const DecodedFrame&) {};
  decoder.feed(Bytes(bytes).first(4 * length + length / 2), sink);
  decoder.interrupt();
  decoder.feed(Bytes(bytes).subspan(5 * length), sink);
  EXPECT_EQ(decoder.counts().frames, 9u);
  EXPECT_EQ(decoder.counts().lost, decoder.format().counter_bits() > 0 ? 1u : 0u);
}

// Random bytes, random cuts of true frames, and what random edits make of them. Under sanitizers a read out of bounds
// ends the program; a search that does not end meets the time limit. More of it: tests/fuzz.
TEST_P(EveryFormat, RandomBytesDoNoHarm) {
  std::mt19937 random(20);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  const ByteVector clean = stream(6);
  Decoder decoder(GetParam().format());
  std::uint64_t seen = 0;
  const FrameSink sink = [&](const DecodedFrame& frame) { seen += frame.values.size() > 0; };
  std::uint64_t fed = 0;
  for (int i = 0; i < 20000; ++i) {
    ByteVector bytes(clean.begin() + static_cast<long>(below(clean.size())), clean.end());
    bytes.resize(below(bytes.size()) + 1);
    for (std::size_t edits = below(4); edits > 0; --edits)
      bytes[below(bytes.size())] = static_cast<std::uint8_t>(random());
    if (i % 4 == 0) std::ranges::generate(bytes, [&] { return static_cast<std::uint8_t>(random()); });
    decoder.feed(bytes, sink);
    fed += bytes.size();
  }
  EXPECT_EQ(seen, decoder.counts().frames);
  EXPECT_LE(decoder.counts().discarded, fed);
  decoder.feed(clean, sink);
  const std::uint64_t before = decoder.counts().frames;
  decoder.feed(clean, sink);
  EXPECT_GE(decoder.counts().frames, before + 5) << "the decoder must find its way back";
}

INSTANTIATE_TEST_SUITE_P(Formats, EveryFormat, ::testing::ValuesIn(cases), [](const auto& i) { return i.param.name; });

}  // namespace tactel::hw::tests::decoder_test
