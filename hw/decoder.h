// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "hw/wire_format.h"

namespace tactel::hw {

/// A frame as the device sent it. The values are valid until the sink returns.
struct DecodedFrame {
  std::span<const double> values;     ///< [channels], the device's units
  std::optional<double> device_time;  ///< s by the device's clock, unwrapped, from the clock's own zero
};
using FrameSink = std::function<void(const DecodedFrame&)>;

/// Counts of a stream.
struct DecoderCounts {
  std::uint64_t frames = 0;          ///< passed to the sink
  std::uint64_t lost = 0;            ///< missing by the device's counter
  std::uint64_t bad = 0;             ///< in sync, but with a wrong checksum or structure
  std::uint64_t resynchronised = 0;  ///< number of times that sync was found again
  std::uint64_t duplicated = 0;      ///< repeated counter; the second frame is not passed on
  std::uint64_t discarded = 0;       ///< bytes that belong to no valid frame
  bool operator==(const DecoderCounts&) const = default;
};

/// Finds frames in a stream of bytes. The same bytes give the same frames and counts for every split. Allocates
/// nothing after construction.
class Decoder {
 public:
  explicit Decoder(std::unique_ptr<const WireFormat> format);

  /// Takes the next bytes of the stream. Calls the sink for each frame that they complete.
  void feed(Bytes bytes, const FrameSink& sink);
  /// Marks an interruption of the stream (the device was away): drops unfinished bytes, keeps the counts. Where
  /// the counter continues, missing frames are counted as lost.
  void interrupt();

  const DecoderCounts& counts() const { return counts_; }
  const WireFormat& format() const { return *format_; }

 private:
  Bytes pending() const { return {buffer_.data() + begin_, end_ - begin_}; }
  bool step(const FrameSink& sink);
  bool step_in_sync(const FrameSink& sink);
  bool step_searching();
  void take(Bytes frame, const FrameSink& sink);
  bool is_new(const FrameHeader& header);
  std::optional<double> unwrap(const FrameHeader& header);
  void discard(std::size_t bytes);
  Verdict::Kind confirm(Bytes bytes) const;

  std::unique_ptr<const WireFormat> format_;
  std::vector<std::uint8_t> buffer_;  ///< bytes begin_ ... end_ are incomplete
  std::size_t begin_ = 0, end_ = 0;
  std::vector<double> values_;  ///< [channels]
  bool in_sync_ = false, was_in_sync_ = false;
  std::size_t discarded_since_sync_ = 0, damaged_length_ = 0;
  std::optional<std::uint64_t> last_counter_, last_clock_;
  std::uint64_t clock_wraps_ = 0;
  DecoderCounts counts_;
};

}  // namespace tactel::hw
