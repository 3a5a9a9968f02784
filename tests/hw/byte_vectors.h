// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <bit>
#include <cstdint>
#include <vector>

#include "hw/decoder.h"

/// Frames written by hand from the published layouts, without the code under test.
namespace tactel::hw::tests {

using ByteVector = std::vector<std::uint8_t>;

inline void put(ByteVector& bytes, std::uint64_t value, int width) {
  for (int i = 0; i < width; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> 8 * i));
}
inline void put_float(ByteVector& bytes, float value) { put(bytes, std::bit_cast<std::uint32_t>(value), 4); }
inline void append(ByteVector& bytes, const ByteVector& more) { bytes.insert(bytes.end(), more.begin(), more.end()); }
/// The float whose four bytes, in the order of the wire, are these.
inline float float_of_bytes(std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(a | b << 8 | c << 16) | static_cast<std::uint32_t>(d) << 24);
}

/// Reading 12 bits of cell `ch`: base + ch. The upper four bits of `hi` are set: they do not belong to the reading.
inline ByteVector glove_frame(int base) {
  ByteVector bytes;
  for (int ch = 0; ch < 64; ++ch) {
    const int reading = (base + ch) & 0x0FFF;
    append(bytes, {static_cast<std::uint8_t>(0x3C + ch), 0x01, static_cast<std::uint8_t>(0x30 | reading >> 8),
                   static_cast<std::uint8_t>(reading & 0xFF), 0x00});
  }
  return bytes;
}

struct PapillarrayBlocks {
  int sensors = 1;
  std::uint32_t counter = 0;
  std::uint64_t microseconds = 0;
  float first_force = 0.25f;  ///< Fx of the first pillar; component k of pillar p of sensor s is 100 s + p + k / 8
  bool undocumented = false;  ///< a block of type 7 at the end, with marks inside
};

inline void put_items(ByteVector& bytes, int items, int kind, const ByteVector& item) {
  for (int i = 0; i < items; ++i) {
    put(bytes, static_cast<std::uint64_t>(kind), 2);
    append(bytes, item);
  }
}

/// Blocks 1, 3, 4, 5, 6 with offsets of two bytes: 433 B for one sensor, 815 B for two.
inline ByteVector papillarray_frame(const PapillarrayBlocks& what) {
  const auto sensors = static_cast<std::size_t>(what.sensors);
  ByteVector blocks[6];
  put(blocks[0], what.counter, 4);
  put(blocks[0], what.microseconds, 8);
  put(blocks[1], sensors, 2);
  blocks[1].resize(2 + 2 * sensors, 0xEE);  // inner offsets: not needed to read the block
  for (std::size_t s = 0; s < sensors; ++s) {
    put(blocks[1], 9, 2);
    blocks[1].resize(blocks[1].size() + 18, 0xEE);
    for (int p = 0; p < 9; ++p) {
      put(blocks[1], 2, 2);
      for (int k = 0; k < 6; ++k) {
        const bool first = s == 0 && p == 0 && k == 0;
        put_float(blocks[1],
                  first ? what.first_force
                        : 100.0f * static_cast<float>(s) + static_cast<float>(p) + 0.125f * static_cast<float>(k));
      }
    }
  }
  put(blocks[2], sensors, 2);
  blocks[2].resize(2 + 2 * sensors, 0xEE);
  put_items(blocks[2], what.sensors, 2, ByteVector(24, 0x11));
  put(blocks[3], sensors, 2);
  blocks[3].resize(2 + 2 * sensors, 0xEE);
  for (std::size_t s = 0; s < sensors; ++s) {
    put(blocks[3], 9, 2);
    blocks[3].resize(blocks[3].size() + 18, 0xEE);
    put_items(blocks[3], 9, 1, ByteVector(5, 0x22));
  }
  put(blocks[4], sensors, 2);
  blocks[4].resize(2 + 2 * sensors, 0xEE);
  put_items(blocks[4], what.sensors, 1, ByteVector(9, 0x33));
  blocks[5] = {0xAA, 0xBB, 0xCC, 0xDD, 0x01, 0x02, 0x03};
  const std::uint16_t types[] = {1, 3, 4, 5, 6, 7};
  const std::size_t count = what.undocumented ? 6 : 5;
  ByteVector payload = {2};
  std::size_t offset = 1 + 4 * count;
  for (std::size_t b = 0; b < count; offset += blocks[b++].size()) {
    put(payload, types[b], 2);
    put(payload, offset, 2);
  }
  for (std::size_t b = 0; b < count; ++b) append(payload, blocks[b]);
  std::uint16_t sum = 0;
  for (const std::uint8_t byte : payload) sum = static_cast<std::uint16_t>(sum + byte);
  ByteVector frame = {0x55, 0x66, 0x77, 0x88};
  append(frame, payload);
  put(frame, sum, 2);
  append(frame, {0xAA, 0xBB, 0xCC, 0xDD});
  return frame;
}

/// Value i is first + i, save value 5 where given.
inline ByteVector anyskin_frame(float first, float fifth = 0, int magnetometers = 5) {
  ByteVector bytes;
  for (int i = 0; i < 4 * magnetometers; ++i)
    put_float(bytes, i == 5 && fifth != 0 ? fifth : first + static_cast<float>(i));
  append(bytes, {0x0D, 0x0A});
  return bytes;
}

/// Cell i reads base + i; the cells come last first, to show that their ids count.
inline ByteVector agni_frame(int base) {
  ByteVector bytes = {0xF0, 0xC4, 0x01, 0x10, 0x20, 0x30, 0x40};
  for (int i = 63; i >= 0; --i) {
    put(bytes, static_cast<std::uint64_t>(i), 1);
    put(bytes, static_cast<std::uint64_t>(base) + static_cast<std::uint64_t>(i), 2);
  }
  std::uint8_t parity = 0;
  for (const std::uint8_t byte : bytes) parity ^= byte;
  bytes.push_back(parity);
  return bytes;
}

/// Two sensors of two points: length 1 + 2 (6 + 6) = 25.
inline ByteVector paxini_frame(std::uint8_t first) {
  ByteVector bytes = {0xAA, 0x56, 0x00, 25, 0, 0};
  append(bytes, {9, 9, 9, 9, 9, 9, first, 0xFF, 200, 3, 4, 5});
  append(bytes, {8, 8, 8, 8, 8, 8, 6, 7, 8, 9, 10, 11});
  std::uint8_t sum = 0;
  for (const std::uint8_t byte : bytes) sum = static_cast<std::uint8_t>(sum + byte);
  bytes.push_back(static_cast<std::uint8_t>(-sum));
  return bytes;
}

struct Decoded {
  std::vector<std::vector<double>> values;
  std::vector<std::optional<double>> device_time;
  DecoderCounts counts;
  bool operator==(const Decoded&) const = default;
};

/// Feeds a stream in parts of at most `part` bytes, the first one of `first` bytes.
inline Decoded decode(std::unique_ptr<const WireFormat> format, const ByteVector& stream, std::size_t first = 0,
                      std::size_t part = static_cast<std::size_t>(-1)) {
  Decoder decoder(std::move(format));
  Decoded decoded;
  const FrameSink sink = [&](const DecodedFrame& frame) {
    decoded.values.emplace_back(frame.values.begin(), frame.values.end());
    decoded.device_time.push_back(frame.device_time);
  };
  Bytes rest(stream);
  decoder.feed(rest.first(first), sink);
  for (rest = rest.subspan(first); !rest.empty();) {
    const std::size_t count = std::min(part, rest.size());
    decoder.feed(rest.first(count), sink);
    rest = rest.subspan(count);
  }
  decoded.counts = decoder.counts();
  return decoded;
}

}  // namespace tactel::hw::tests
