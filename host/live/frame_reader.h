// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>

#include "hw/decoder.h"
#include "hw/frame_source.h"

namespace tactel::host {

inline constexpr double longest_wait = 0.05;  ///< s: interval at which read_frames calls `stop` without packets

/// Callbacks of read_frames. Empty functions are allowed.
struct ReadingEvents {
  std::function<void(const hw::Packet&)> packet{};                       ///< each packet, before its frames
  std::function<void(const hw::DecodedFrame&, double arrival)> frame{};  ///< arrival: s, of its last byte
  std::function<void()> turn{};                                          ///< after each wait, with or without a packet
  std::function<bool()> stop{};                                          ///< true ends the reading
};

/// Decodes the packets of a source until it ends or `stop` returns true. A gap interrupts the decoder. Throws
/// hw::SourceError.
void read_frames(hw::FrameSource& source, hw::Decoder& decoder, const ReadingEvents& events);

}  // namespace tactel::host
