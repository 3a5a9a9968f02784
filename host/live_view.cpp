#include "host/live_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace tactel::host {
namespace {

constexpr int bar_width = 40;
constexpr auto refresh = std::chrono::milliseconds(50);

std::string bar(float share) {
  const int full = std::isfinite(share) ? static_cast<int>(std::lround(std::clamp(share, 0.0f, 1.0f) * bar_width)) : 0;
  std::string text;
  for (int i = 0; i < bar_width; ++i) text += i < full ? "█" : "·";
  return text;
}

/// A block as high as |stress|, one a tactel.
std::string strip(std::span<const float> stresses, float largest) {
  static constexpr const char* blocks[] = {" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  std::string text;
  for (const float stress : stresses) {
    const float share = std::isfinite(stress) ? std::min(std::abs(stress) / largest, 1.0f) : 0.0f;
    text += blocks[static_cast<std::size_t>(std::lround(8 * share))];
  }
  return text;
}

}  // namespace

std::string view_text(const MonitorLine& line, float largest_stress) {
  const float s = line.answer.slip_index;
  const auto half = line.stresses.size() / 2;
  return fmt::format("S      {} {}\nnormal |{}| of {:.3g} MPa\nshear  |{}| frame {}, {:.0f} us\n", bar(s),
                     std::isfinite(s) ? fmt::format("{:.3f}", s) : "  -  ",
                     strip(line.stresses.first(half), largest_stress), largest_stress,
                     strip(line.stresses.subspan(half), largest_stress), line.frame.number, line.latency);
}

void LiveView::show(const MonitorLine& line) {
  for (const float stress : line.stresses)
    if (std::isfinite(stress)) largest_stress_ = std::max(largest_stress_, std::abs(stress));
  const auto now = std::chrono::steady_clock::now();
  if (shown_ && now - last_ < refresh) return;
  // Up three lines and over what stands there; each line is cleared to its end.
  std::string text = view_text(line, largest_stress_);
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 4) text.replace(at, 1, "\x1b[K\n");
  fmt::print("{}{}", shown_ ? "\x1b[3A" : "", text);
  std::fflush(stdout);
  shown_ = true;
  last_ = now;
}

void LiveView::finish() { std::fflush(stdout); }

}  // namespace tactel::host
