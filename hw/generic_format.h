// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <vector>

#include "hw/wire_format.h"

namespace tactel::hw {

enum class SampleType { i16, u16, i32, f32, f64 };
enum class Checksum { none, sum8, sum16, xor8, crc16 };

/// A number in a frame's header: `width` bytes (1, 2, 4, 8) from `offset` of the frame. Width 0: absent.
struct HeaderField {
  int offset = 0, width = 0;
};

/// Frames of fixed length: sync bytes, header, samples, checksum, trailer. Defaults as in a profile file.
struct GenericLayout {
  std::vector<std::uint8_t> sync;  ///< 1 to 16 bytes at the beginning of every frame
  int header = 0;                  ///< bytes before the samples, sync included
  HeaderField counter, clock;
  double clock_tick = 1e-6;  ///< s
  int channels = 0;          ///< 1 to 1024 samples
  SampleType sample = SampleType::u16;
  bool big_endian = false;             ///< samples, counter, clock and checksum
  Checksum checksum = Checksum::none;  ///< of all bytes from checksum_from up to itself
  int checksum_from = 0;               ///< offset in the frame, bytes
  std::vector<std::uint8_t> trailer;   ///< at most 16 bytes at the end of every frame
  int confirmations = 3;               ///< frames in a row before the first counts
  void validate() const;               ///< throws ValueError, keys as in profile files
};

std::unique_ptr<const WireFormat> generic_format(const GenericLayout& layout);

/// Writes a frame of this layout, for simulated devices. samples: [channels], rounded and clipped to the range of
/// the sample type. out: exactly the frame's bytes.
void write_generic_frame(const GenericLayout& layout, std::uint64_t counter, std::uint64_t clock,
                         std::span<const double> samples, std::span<std::uint8_t> out);
std::size_t generic_frame_length(const GenericLayout& layout);

/// Returns CRC-16/CCITT-FALSE: polynomial 0x1021, initial value 0xFFFF, not reflected.
std::uint16_t crc16(Bytes bytes);

}  // namespace tactel::hw
