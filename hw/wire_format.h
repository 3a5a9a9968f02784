#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace tactel::hw {

using Bytes = std::span<const std::uint8_t>;

/// What stands at the beginning of some bytes.
struct Verdict {
  enum Kind {
    incomplete,  ///< more bytes are needed to tell
    nothing,     ///< no frame begins here
    damaged,     ///< a frame begins here, but its checksum or structure is wrong
    whole        ///< a frame of `length` bytes
  };
  Kind kind = nothing;
  std::size_t length = 0;  ///< bytes; of a damaged frame where known, else 0
};

/// What a frame holds besides its values.
struct FrameHeader {
  std::optional<std::uint64_t> counter;  ///< as sent, wraps at 2^counter_bits
  std::optional<std::uint64_t> clock;    ///< the device's, in ticks as sent, wraps at 2^clock_bits
};

/// How a device writes frames into its stream of bytes. Stateless: what it says depends on the bytes alone, and never
/// changes when more of them follow, save from `incomplete` to something else. So splits of the stream cannot matter.
class WireFormat {
 public:
  virtual ~WireFormat() = default;
  virtual Verdict inspect(Bytes bytes) const = 0;
  /// Reads a whole frame. values: [channels()], in the device's units.
  virtual FrameHeader read(Bytes frame, std::span<double> values) const = 0;

  virtual std::size_t channels() const = 0;
  /// Bytes. So many or more are never `incomplete`.
  virtual std::size_t longest_frame() const = 0;
  /// How many frames must follow each other without a gap before the first of them counts, where a frame's marks can
  /// also stand inside its payload.
  virtual int confirmations() const = 0;
  virtual int counter_bits() const { return 0; }   ///< 0: no counter
  virtual int clock_bits() const { return 0; }     ///< 0: no clock
  virtual double clock_tick() const { return 0; }  ///< s
};

}  // namespace tactel::hw
