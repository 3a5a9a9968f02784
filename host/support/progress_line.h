#pragma once
#include <cstddef>
#include <memory>
#include <string>

#include "host/support/log.h"

namespace tactel::host {

/// Times of a progress line, s.
struct ProgressTimes {
  double first = 1;    ///< after the start, so that a quick job says nothing
  double every = 30;   ///< between two lines in a log or pipe
  double again = 0.2;  ///< between two pictures of the line on a terminal, at least
};

/// Reports on stderr a job and its progress: percent, rate, time left. On a terminal it redraws one line, which
/// is cleared at the end. Elsewhere it prints a line after the first second and each half minute. A job without
/// show() is reported with its elapsed time. Of several lines at once the latest is shown. It has a thread of its
/// own, and does without where none can be created.
class ProgressLine {
 public:
  /// `job` begins the line; `unit` is what is counted, `per_count` how many of it one count of the job is. `quiet` says
  /// nothing at all.
  ProgressLine(std::string job, std::string unit, bool quiet, double per_count = 1, ProgressTimes times = {});
  ~ProgressLine();  ///< clears the line
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// `rate`: what to say in place of the line's own rate.
  void show(std::size_t done, std::size_t total, const std::string& rate = "");
  void clear();  ///< says no more until the next show()

 private:
  struct State;
  std::unique_ptr<State> state_;  ///< none when quiet
};

/// A job without counted progress: ProgressLine without show().
class StageLine {
 public:
  StageLine(std::string job, bool quiet, ProgressTimes times = {}) : line_(std::move(job), "", quiet, 1, times) {}

 private:
  ProgressLine line_;
};

/// "12.3 M", "4.56 k", "789".
std::string with_prefix(double number);
/// "42 s", "3 min 10 s", "2 h 05 min".
std::string duration_text(double seconds);

}  // namespace tactel::host
