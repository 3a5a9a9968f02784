// SPDX-License-Identifier: Apache-2.0
#include "host/support/progress_line.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <functional>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace tactel::host {
namespace {

using Clock = std::chrono::steady_clock;
const std::string clear_line = "\r\x1b[K";

/// Ignores failures: a closed pipe or a full disk must not end a job for the sake of its progress.
void write(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

double seconds(Clock::duration time) { return std::chrono::duration<double>(time).count(); }

Clock::time_point after(Clock::time_point start, double seconds) {
  return start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

/// A thread that takes no signals: they are for the threads that wait for them.
std::thread thread_without_signals(const std::function<void()>& work) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread thread;
  try {
    thread = std::thread(work);
  } catch (const std::system_error&) {
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return thread;
}

}  // namespace

struct ProgressLine::State {
  const std::string job, unit;
  const double per_count;
  const ProgressTimes times;
  const bool terminal = isatty(STDERR_FILENO) != 0;
  const Clock::time_point begun = Clock::now();

  // Guarded by screen().mutex.
  bool counting = false;  ///< show() has been called
  bool silent = false;    ///< since clear()
  bool shown = false;     ///< there is a line on the terminal to be cleared
  bool over = false;
  std::size_t done = 0, total = 0;
  std::size_t first_done = 0;        ///< what was done before this run, as after a resume
  Clock::time_point start, counted;  ///< of the first and the last show()
  Clock::time_point last;            ///< line on the terminal
  std::string rate_text;
  std::condition_variable wake;
  std::thread ticker;

  /// All lines that there are, the latest last: stderr is one for all of them.
  struct Screen {
    std::mutex mutex;
    std::vector<const State*> lines;
  };
  static Screen& screen() {
    static Screen of_stderr;
    return of_stderr;
  }

  State(std::string job, std::string unit, double per_count, ProgressTimes times)
      : job(std::move(job)), unit(std::move(unit)), per_count(per_count), times(times) {}

  bool speaks() const { return !silent && screen().lines.back() == this; }

  std::string text(Clock::time_point now) const {
    if (!counting || total == 0) {
      const double passed = seconds(now - begun);
      return passed < times.first + 1 ? job + " ..." : fmt::format("{}, {} ...", job, duration_text(passed));
    }
    std::string line = fmt::format("{}: {:.1f} %", job, 100.0 * static_cast<double>(done) / static_cast<double>(total));
    if (done <= first_done) return line;
    const double rate = static_cast<double>(done - first_done) / std::max(seconds(counted - start), 1e-9);
    const std::string pace = rate_text.empty() ? with_prefix(rate * per_count) + " " + unit + "/s" : rate_text;
    const double left = static_cast<double>(total - done) / rate - seconds(now - counted);
    return line + fmt::format(", {}, {} left", pace, duration_text(left));
  }

  void draw(Clock::time_point now) {
    write(terminal ? clear_line + text(now) : text(now) + "\n");
    shown = terminal;
    last = now;
  }

  void erase() {
    if (shown) write(clear_line);
    shown = false;
  }

  /// The ticker's work: the first line, then one each half minute; on a terminal each second until show() draws.
  void tick() {
    std::unique_lock lock(screen().mutex);
    for (auto next = after(begun, times.first); !over;
         next = after(next, terminal ? std::max(times.first, 1.0) : times.every)) {
      if (wake.wait_until(lock, next, [this] { return over; })) return;
      if (speaks() && !(terminal && counting)) draw(Clock::now());
    }
  }
};

ProgressLine::ProgressLine(std::string job, std::string unit, bool quiet, double per_count, ProgressTimes times) {
  if (quiet) return;
  state_ = std::make_unique<State>(std::move(job), std::move(unit), per_count, times);
  {
    const std::lock_guard lock(State::screen().mutex);
    State::screen().lines.push_back(state_.get());
  }
  state_->ticker = thread_without_signals([state = state_.get()] { state->tick(); });
}

ProgressLine::~ProgressLine() {
  if (!state_) return;
  {
    const std::lock_guard lock(State::screen().mutex);
    std::erase(State::screen().lines, state_.get());
    state_->erase();
    state_->over = true;
  }
  state_->wake.notify_all();
  if (state_->ticker.joinable()) state_->ticker.join();
}

void ProgressLine::show(std::size_t done, std::size_t total, const std::string& rate) {
  if (!state_) return;
  State& s = *state_;
  const std::lock_guard lock(State::screen().mutex);
  const auto now = Clock::now();
  if (!s.counting) s.start = now, s.first_done = done;
  s.counting = true, s.silent = false, s.counted = now;
  s.done = done, s.total = total, s.rate_text = rate;
  if (s.terminal && total > 0 && s.speaks() && (!s.shown || seconds(now - s.last) >= s.times.again)) s.draw(now);
}

void ProgressLine::clear() {
  if (!state_) return;
  const std::lock_guard lock(State::screen().mutex);
  state_->erase();
  state_->silent = true;
}

std::string with_prefix(double number) {
  for (const auto& [limit, prefix] : {std::pair{1e15, " P"}, {1e12, " T"}, {1e9, " G"}, {1e6, " M"}, {1e3, " k"}})
    if (number >= limit) return fmt::format("{:.3g}{}", number / limit, prefix);
  return fmt::format("{:.3g}", number);
}

std::string duration_text(double seconds) {
  const auto whole = static_cast<long>(std::lround(std::clamp(seconds, 0.0, 1e9)));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

}  // namespace tactel::host
