// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace tactel::hw {

using Bytes = std::span<const std::uint8_t>;

/// Classification of the beginning of some bytes.
struct Verdict {
  enum Kind {
    incomplete,  ///< more bytes are needed
    nothing,     ///< no frame begins here
    damaged,     ///< a frame begins here, but its checksum or structure is wrong
    whole        ///< a frame of `length` bytes
  };
  Kind kind = nothing;
  std::size_t length = 0;  ///< bytes; of a damaged frame where known, else 0
};

/// Counter and clock of a frame.
struct FrameHeader {
  std::optional<std::uint64_t> counter;  ///< as sent, wraps at 2^counter_bits
  std::optional<std::uint64_t> clock;    ///< clock of the device, in ticks as sent, wraps at 2^clock_bits
};

/// Layout of the frames of a device. Stateless: a verdict depends on the bytes alone. It never changes when more
/// bytes follow, except from `incomplete`. Splits of the stream therefore cannot change the frames.
class WireFormat {
 public:
  virtual ~WireFormat() = default;
  virtual Verdict inspect(Bytes bytes) const = 0;
  /// Reads a whole frame into values [channels()], in the units of the device. Returns its header.
  virtual FrameHeader read(Bytes frame, std::span<double> values) const = 0;

  virtual std::size_t channels() const = 0;
  /// Returns the length in bytes from which a verdict is never `incomplete`.
  virtual std::size_t longest_frame() const = 0;
  /// Returns the number of consecutive frames that establish sync. Above 1 where the marks of a frame can also
  /// occur inside its payload.
  virtual int confirmations() const = 0;
  virtual int counter_bits() const { return 0; }   ///< 0: no counter
  virtual int clock_bits() const { return 0; }     ///< 0: no clock
  virtual double clock_tick() const { return 0; }  ///< s
};

}  // namespace tactel::hw
