#pragma once
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

#include "hw/wire_format.h"

namespace tactel::hw {

/// Bytes that came together.
struct Packet {
  Bytes bytes;             ///< valid until the next wait
  double arrival = 0;      ///< s since the source was opened; of a replay: as recorded
  bool after_gap = false;  ///< the device was away before these bytes: what was unfinished stays so
};

/// What became of the transport below the frames.
struct TransportCounts {
  std::uint64_t packets = 0, bytes = 0;
  std::uint64_t overruns = 0;    ///< packets dropped because nobody took them in time
  std::uint64_t stalls = 0;      ///< endpoint halted, and cleared again
  std::uint64_t errors = 0;      ///< other transfers that failed
  std::uint64_t reconnects = 0;  ///< the device came back after it was away
};

/// A device or file that cannot be used: what happened, and what the user can do.
class SourceError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A recording that cannot be used.
class RecordingError : public SourceError {
  using SourceError::SourceError;
};

/// Where the bytes of frames come from: a device, a recording, a simulation. Only the wire format knows what they mean.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// The next packet; none when nothing came within `timeout` seconds, or at the end. Throws SourceError.
  virtual std::optional<Packet> wait(double timeout) = 0;
  /// Nothing more will come.
  virtual bool finished() const = 0;
  /// Whether it goes on by the clock: a live source loses what is not taken, the others wait.
  virtual bool live() const = 0;
  /// s, the clock of arrivals, now: what has passed since a packet arrived is its age.
  virtual double now() const = 0;
  virtual TransportCounts counts() const = 0;
};

}  // namespace tactel::hw
