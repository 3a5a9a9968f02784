// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <chrono>
#include <optional>
#include <thread>

namespace tactel::hw {

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
