// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

#include "hw/wire_format.h"

namespace tactel::hw {

/// Bytes that arrived together.
struct Packet {
  Bytes bytes;             ///< valid until the next wait
  double arrival = 0;      ///< s since the source was opened; of a replay: as recorded
  bool after_gap = false;  ///< the device was away before these bytes: unfinished frames stay unfinished
};

/// Counts of the transport below the frames.
struct TransportCounts {
  std::uint64_t packets = 0, bytes = 0;
  std::uint64_t overruns = 0;    ///< packets dropped because they were not read in time
  std::uint64_t stalls = 0;      ///< endpoint halted, and cleared again
  std::uint64_t errors = 0;      ///< other transfers that failed
  std::uint64_t reconnects = 0;  ///< the device came back after it was away
  std::uint64_t bad = 0;         ///< lines of text that were no frame
};

/// A device or file that cannot be used, with the reason and a remedy.
class SourceError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A recording that cannot be read or written.
class RecordingError : public SourceError {
  using SourceError::SourceError;
};

/// Source of the bytes of frames: a device, a recording, a simulation. Only the wire format interprets them.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// Returns the next packet. Returns none where no packet arrives within `timeout` seconds, or at the end.
  /// Throws SourceError.
  virtual std::optional<Packet> wait(double timeout) = 0;
  /// Tells the source that frames were found in its last packet.
  virtual void answered() {}
  /// Returns true at the end of the source.
  virtual bool finished() const = 0;
  /// Returns true where the source runs by the clock. A live source loses what is not read; the others wait.
  virtual bool live() const = 0;
  /// Returns false where neither frames nor packets have a time, as lines of a file without one.
  virtual bool timed() const { return true; }
  /// Returns the current time of the clock of arrivals, s. now() - arrival is the age of a packet.
  virtual double now() const = 0;
  virtual TransportCounts counts() const = 0;
  /// Ends the source after this time of its own, s. Returns false where its time is that of the clock.
  virtual bool end_after(double) { return false; }
  /// Returns true where the source was truncated, such as a recording that was cut off. Known once finished.
  virtual bool cut_short() const { return false; }
  /// Returns what was wrong with the first of TransportCounts::bad; empty: none were.
  virtual std::string first_bad() const { return ""; }
  /// Returns a descriptor that is readable while packets wait, for an event loop; -1 where the source has none.
  virtual int fd() const { return -1; }
};

/// The clock of a source that is read again: its packets come at their original pace, or as fast as they are read.
class Pace {
 public:
  explicit Pace(bool real_time = false) : real_time_(real_time) {}

  /// Waits for the time of the packet that arrived at `arrival` s. Returns false where that is not within `timeout` s.
  bool due(double arrival, double timeout) {
    if (!real_time_) return true;
    const auto now = Clock::now();
    if (!zero_) zero_ = now - seconds(arrival);
    const auto time = *zero_ + seconds(arrival), end = now + seconds(std::min(timeout, longest_wait));
    std::this_thread::sleep_until(std::min(time, end));
    return time <= end;
  }
  void hand_out(double arrival) { last_arrival_ = arrival, handed_out_ = Clock::now(); }
  /// Returns the arrival of the last packet plus the time since it was handed out, s.
  double now() const { return last_arrival_ + std::chrono::duration<double>(Clock::now() - handed_out_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr double longest_wait = 3600;  // s: a longer timeout would leave the clock's range
  static Clock::duration seconds(double s) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
  }
  bool real_time_;
  std::optional<Clock::time_point> zero_;
  double last_arrival_ = 0;
  Clock::time_point handed_out_ = Clock::now();
};

}  // namespace tactel::hw
