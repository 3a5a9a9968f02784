// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <functional>
#include <optional>

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

/// The rate of frames by their times, anew each second.
class RateMeter {
 public:
  explicit RateMeter(double hz) : rate_(hz) {}
  double rate() const { return rate_; }
  /// Takes the time of the next frame, s. Returns the rate where it differs by a tenth from the last one.
  std::optional<double> next(double time) {
    if (frames_++ == 0) begin_ = time;
    const double passed = time - begin_;
    if (passed < 1) return std::nullopt;
    const double rate = (frames_ - 1) / passed;
    const bool whole = passed < 2 && frames_ > fewest;  // no pause
    begin_ = time, frames_ = 1;
    if (!whole || std::abs(rate - rate_) < 0.1 * rate_) return std::nullopt;
    return rate_ = rate;
  }

 private:
  static constexpr int fewest = 5;
  double rate_, begin_ = 0;
  int frames_ = 0;
};

}  // namespace tactel::host
