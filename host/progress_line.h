#pragma once
#include <chrono>
#include <string>

#include "host/log.h"

namespace tactel::host {

/// Says on stderr how far a long job is: percent, rate, time left. Only on a terminal, a few times a second; `quiet`
/// says nothing at all.
class ProgressLine {
 public:
  /// `job` begins the line; `unit` is what is counted, `per_count` how many of it one count of the job is.
  ProgressLine(std::string job, std::string unit, bool quiet, double per_count = 1);
  ~ProgressLine();  ///< clears the line
  /// `rate`: what to say in place of the line's own rate.
  void show(std::size_t done, std::size_t total, const std::string& rate = "");
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  std::string job_, unit_;
  bool shown_ = false, visible_;
  double per_count_;
  std::size_t first_done_ = 0;  ///< what was done before this run, as after a resume
  Clock::time_point start_, last_;
};

/// "12.3 M", "4.56 k", "789".
std::string with_prefix(double number);
/// "42 s", "3 min 10 s", "2 h 05 min".
std::string duration_text(double seconds);

}  // namespace tactel::host
