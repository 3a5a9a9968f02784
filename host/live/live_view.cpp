#include "host/live/live_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace tactel::host {
namespace {

constexpr int widest_bar = 40, least_columns = 20;
constexpr auto refresh = std::chrono::milliseconds(50);
constexpr int lines = 5;

std::string bar(float share, int width) {
  const int full = std::isfinite(share) ? static_cast<int>(std::lround(std::clamp(share, 0.0f, 1.0f) * width)) : 0;
  std::string text;
  for (int i = 0; i < width; ++i) text += i < full ? "█" : "·";
  return text;
}

/// The stress of the largest size in each of `columns` groups of neighbours; as many groups as tactels where they fit.
std::vector<float> grouped(std::span<const float> stresses, std::size_t columns) {
  const std::size_t groups = std::min(stresses.size(), columns);
  std::vector<float> largest(groups, 0.0f);
  for (std::size_t i = 0; i < stresses.size(); ++i) {
    float& of_group = largest[i * groups / stresses.size()];
    if (std::isfinite(stresses[i]) && std::abs(stresses[i]) > std::abs(of_group)) of_group = stresses[i];
  }
  return largest;
}

std::size_t height(float stress, float largest) {
  return static_cast<std::size_t>(std::lround(8 * std::min(std::abs(stress) / largest, 1.0f)));
}

std::string blocks(const std::vector<float>& stresses, float largest) {
  static constexpr const char* all[] = {" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  std::string text;
  for (const float stress : stresses) text += all[height(stress, largest)];
  return text;
}

/// Only where a block is seen above it.
std::string arrows(const std::vector<float>& stresses, float largest) {
  std::string text;
  for (const float stress : stresses) text += height(stress, largest) == 0 ? " " : stress > 0 ? "→" : "←";
  return text;
}

}  // namespace

std::string view_text(const MonitorLine& line, float largest_stress, int columns) {
  const int width = std::max(columns, least_columns);
  const float s = line.answer.slip_index;
  const auto half = line.stresses.size() / 2;
  const auto room = static_cast<std::size_t>(width - 9);  // beside "normal |" and "|"
  const auto normal = grouped(line.stresses.first(half), room), shear = grouped(line.stresses.subspan(half), room);
  const std::string number = std::isfinite(s) ? fmt::format("{:.3f}", s) : "  -  ";
  const std::string words =
      fmt::format("frame {}, {:.0f} us, full block {:.3g} MPa", line.frame.number, line.latency, largest_stress);
  return fmt::format("S {} {}\nnormal |{}|\nshear  |{}|\n       |{}|\n{}\n", number,
                     bar(s, std::min(widest_bar, width - 8)), blocks(normal, largest_stress),
                     blocks(shear, largest_stress), arrows(shear, largest_stress),
                     words.substr(0, static_cast<std::size_t>(width)));
}

// On a terminal: up over the picture before; each line is cleared to its end.
std::optional<std::string> LiveView::show(const MonitorLine& line, int columns) {
  for (const float stress : line.stresses)
    if (std::isfinite(stress)) largest_stress_ = std::max(largest_stress_, std::abs(stress));
  const auto now = std::chrono::steady_clock::now();
  if (shown_ && now - last_ < refresh) return std::nullopt;
  std::string text = view_text(line, largest_stress_, columns);
  if (terminal_) {
    for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 4) text.replace(at, 1, "\x1b[K\n");
    if (shown_) text.insert(0, fmt::format("\x1b[{}A", lines));
  }
  shown_ = true;
  last_ = now;
  return text;
}

}  // namespace tactel::host
