// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <memory>
#include <string>

#include "host/support/log.h"

namespace tactel::host {

/// Times of a progress line, s.
struct ProgressTimes {
  double first = 1;    ///< after the start; a shorter job prints nothing
  double every = 30;   ///< between two lines in a log or pipe
  double again = 0.2;  ///< between two pictures of the line on a terminal, at least
};

/// Reports on stderr a job and its progress: percent, rate, time left. On a terminal it redraws one line, which is
/// cleared at the end. Elsewhere it prints a line after the first second and each half minute. A job without show()
/// is reported with its elapsed time. Of several lines at once the latest is shown. A thread of its own draws it;
/// where none can be created, only show() does.
class ProgressLine {
 public:
  /// The line begins with `job`. `unit` names the counted items; one count of the job is `per_count` of them.
  /// `quiet` prints nothing.
  ProgressLine(std::string job, std::string unit, bool quiet, double per_count = 1, ProgressTimes times = {});
  ~ProgressLine();  ///< clears the line

  /// `rate` replaces the line's own rate.
  void show(std::size_t done, std::size_t total, const std::string& rate = "");
  void clear();  ///< removes the line until the next show()

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

/// Returns "12.3 M", "4.56 k", "789".
std::string with_prefix(double number);
/// Returns "42 s", "3 min 10 s", "2 h 05 min".
std::string duration_text(double seconds);

}  // namespace tactel::host
