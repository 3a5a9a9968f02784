#include "host/progress_line.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace tactel::host {
namespace {

constexpr double show_every = 0.2;  // s
constexpr const char* clear_line = "\r\x1b[K";

double seconds(std::chrono::steady_clock::duration time) { return std::chrono::duration<double>(time).count(); }

}  // namespace

ProgressLine::ProgressLine(std::string job, std::string unit, bool quiet, double per_count)
    : job_(std::move(job)), unit_(std::move(unit)), visible_(!quiet && isatty(STDERR_FILENO)), per_count_(per_count) {}

ProgressLine::~ProgressLine() { clear(); }

void ProgressLine::show(std::size_t done, std::size_t total, const std::string& rate_text) {
  const auto now = Clock::now();
  if (start_ == Clock::time_point{}) start_ = now, first_done_ = done;
  if (!visible_ || total == 0 || (shown_ && seconds(now - last_) < show_every)) return;
  const double rate = static_cast<double>(done - first_done_) / std::max(seconds(now - start_), 1e-9);
  std::string line = fmt::format("{}: {:.1f} %", job_, 100.0 * static_cast<double>(done) / static_cast<double>(total));
  if (done > first_done_)
    line += fmt::format(", {}, {} left",
                        rate_text.empty() ? with_prefix(rate * per_count_) + " " + unit_ + "/s" : rate_text,
                        duration_text(static_cast<double>(total - done) / rate));
  fmt::print(stderr, "{}{}", clear_line, line);
  std::fflush(stderr);
  shown_ = true;
  last_ = now;
}

void ProgressLine::clear() {
  if (shown_) fmt::print(stderr, "{}", clear_line);
  shown_ = false;
}

std::string with_prefix(double number) {
  for (const auto& [limit, prefix] : {std::pair{1e9, " G"}, {1e6, " M"}, {1e3, " k"}})
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
