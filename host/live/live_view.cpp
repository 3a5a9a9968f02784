// SPDX-License-Identifier: Apache-2.0
#include "host/live/live_view.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/support/terminal.h"

namespace tactel::host {
namespace {

constexpr int least_columns = 20, margin = 9;  // beside "normal |" and "|"
constexpr auto refresh = std::chrono::milliseconds(50);
constexpr const char* eighths[] = {" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
constexpr const char* shades[] = {"·", "░", "▒", "▓", "█"};
constexpr const char* octants[] = {"→", "↗", "↑", "↖", "←", "↙", "↓", "↘"};
constexpr const char* long_octants[] = {"⇒", "⇗", "⇑", "⇖", "⇐", "⇙", "⇓", "⇘"};

/// S from 0 to 1 over `width` columns, a mark where the alarm begins.
std::string bar(float s, float alarm, int width) {
  const auto column = [&](float share) {
    return static_cast<int>(std::lround(std::clamp(share, 0.0f, 1.0f) * static_cast<float>(width)));
  };
  const int full = std::isfinite(s) ? column(s) : 0, mark = std::min(column(alarm), width - 1);
  std::string text;
  for (int i = 0; i < width; ++i) text += i < full ? "█" : i == mark ? "┊" : "·";
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

/// Each text of a column, as often as all of them fit into `room` columns.
std::string stretched(const std::vector<const char*>& texts, std::size_t room) {
  std::string line;
  for (const char* text : texts)
    for (std::size_t i = 0; i < std::max<std::size_t>(room / std::max<std::size_t>(texts.size(), 1), 1); ++i)
      line += text;
  return line;
}

std::string blocks(const std::vector<float>& stresses, float largest, std::size_t room) {
  std::vector<const char*> texts(stresses.size());
  std::ranges::transform(stresses, texts.begin(), [&](float stress) { return eighths[height(stress, largest)]; });
  return stretched(texts, room);
}

/// Only where a block is seen above it.
std::string arrows(const std::vector<float>& stresses, float largest, std::size_t room) {
  std::vector<const char*> texts(stresses.size());
  std::ranges::transform(stresses, texts.begin(), [&](float stress) {
    return height(stress, largest) == 0 ? " " : stress > 0 ? "→" : "←";
  });
  return stretched(texts, room);
}

/// Stresses [2 tactels] MPa as blocks, and the direction of shear.
std::string line_text(std::span<const float> stresses, float largest, std::size_t room) {
  const auto half = stresses.size() / 2;
  const auto normal = grouped(stresses.first(half), room), shear = grouped(stresses.subspan(half), room);
  return fmt::format("normal |{}|\nshear  |{}|\n       |{}|\n", blocks(normal, largest, room),
                     blocks(shear, largest, room), arrows(shear, largest, room));
}

/// The newest columns that fit, the last one at the right.
std::string history_text(const SlipTrace& history, std::size_t room) {
  const auto& all = history.columns();
  const std::size_t shown = std::min(room, all.size());
  std::string text(room - shown, ' ');
  for (std::size_t i = all.size() - shown; i < all.size(); ++i)
    text += std::isfinite(all[i]) ? eighths[1 + std::lround(7 * std::clamp(all[i], 0.0f, 1.0f))] : " ";
  return text;
}

/// An arrow in the direction of the shear; `beside` where it is small.
const char* arrow(float x, float y, float largest, const char* beside) {
  const std::size_t size = height(std::hypot(x, y), largest);
  if (size == 0) return beside;
  const auto octant = static_cast<std::size_t>(std::lround(std::atan2(y, x) / (std::numbers::pi_v<float> / 4)) + 8) % 8;
  return size >= 2 ? long_octants[octant] : octants[octant];
}

/// The lines of a pad's tiles, `width` columns each. stresses: [axes, tactels of all pads] MPa, those of the pad from
/// `first` on.
std::vector<std::string> tiles(std::span<const float> stresses, std::size_t axes, std::size_t first,
                               const PadLayout& pad, float largest, std::size_t width, std::size_t room) {
  const std::size_t all = stresses.size() / axes, nx = static_cast<std::size_t>(pad.tactels[0]);
  const std::size_t shaded = width > 2 ? width - 1 : width;  // a gap beside wide tiles
  std::vector<std::string> lines;
  for (int y = pad.tactels[1]; y-- > 0;) {
    std::string upper, lower;
    for (std::size_t x = 0; x < std::min(nx, room); ++x) {
      const std::size_t tactel = first + static_cast<std::size_t>(y) * nx + x;
      const auto stress = [&](std::size_t axis) {
        const float value = axis < axes ? stresses[axis * all + tactel] : 0;
        return std::isfinite(value) ? value : 0;
      };
      const char* shade = shades[(height(stress(0), largest) + 1) / 2];
      for (std::size_t i = 0; i < width; ++i) {
        upper += i < shaded ? shade : " ";
        lower += i == shaded / 2 ? arrow(stress(1), stress(2), largest, shade) : i < shaded ? shade : " ";
      }
    }
    lines.push_back(std::move(upper));
    lines.push_back(std::move(lower));
  }
  return lines;
}

/// Several pads have their S above their tiles. They stand side by side where each tile has two columns or more.
std::string pads_text(const MonitorLine& line, const std::vector<PadLayout>& pads, float largest, std::size_t room) {
  constexpr std::size_t gap = 3, widest = 6, least = 7;  // columns; least: of an S
  std::size_t all = 0, across = 0, tallest = 0, first = 0;
  for (const PadLayout& pad : pads) {
    all += pad.count(), across += static_cast<std::size_t>(pad.tactels[0]);
    tallest = std::max(tallest, 1 + 2 * static_cast<std::size_t>(pad.tactels[1]));
  }
  const std::size_t gaps = gap * (pads.size() - 1);
  const bool beside = pads.size() > 1 && 2 * across + gaps <= room && pads.size() * least + gaps <= room;
  std::vector<std::string> rows(beside ? tallest : 0);
  for (std::size_t i = 0; i < pads.size(); first += pads[i++].count()) {
    const auto nx = static_cast<std::size_t>(pads[i].tactels[0]);
    const std::size_t width = std::clamp<std::size_t>(beside ? (room - gaps) / across : room / nx, 1, widest);
    std::vector<std::string> pad_rows =
        tiles(line.stresses, line.stresses.size() / all, first, pads[i], largest, width, room);
    if (pads.size() > 1) {
      const float s = i < line.pads.size() ? line.pads[i].answer.slip_index : std::nanf("");
      pad_rows.insert(pad_rows.begin(), std::isfinite(s) ? fmt::format("S {:.3f}", s) : "S   -  ");
    }
    if (!beside) rows.insert(rows.end(), pad_rows.begin(), pad_rows.end());
    for (std::size_t row = 0; beside && row < tallest; ++row) {
      const std::size_t filled = row == 0 ? least : row < pad_rows.size() ? nx * width : 0;
      rows[row] += (row < pad_rows.size() ? pad_rows[row] : "");
      if (i + 1 < pads.size()) rows[row].append(std::max(nx * width, least) + gap - filled, ' ');
    }
  }
  return fmt::format("{}\n", fmt::join(rows, "\n"));
}

Colour colour_of(float s, float alarm) {
  return s >= alarm ? Colour::red : s >= 0.75f * alarm ? Colour::yellow : Colour::green;
}

}  // namespace

void SlipTrace::add(double arrival, float slip_index, std::size_t longest) {
  if (!(std::abs(arrival) < 1e12)) return;
  const auto now = static_cast<std::int64_t>(std::floor(arrival / seconds_per_column));
  if (columns_.empty()) newest_ = now - 1;
  if (now - newest_ > static_cast<std::int64_t>(longest)) columns_.clear();
  if (columns_.empty()) newest_ = now - 1;
  for (; newest_ < now; ++newest_) columns_.push_back(std::nanf(""));
  if (std::isfinite(slip_index)) columns_.back() = std::fmax(columns_.back(), slip_index);
  while (columns_.size() > longest) columns_.pop_front();
}

std::string view_text(const MonitorLine& line, const SlipTrace& history, float largest_stress, int columns,
                      const ViewOptions& options, const std::string& note) {
  const int width = std::max(columns, least_columns);
  const float s = line.answer.slip_index;
  const auto room = static_cast<std::size_t>(width - margin);
  std::string index =
      fmt::format("S {} {}", std::isfinite(s) ? fmt::format("{:.3f}", s) : "  -  ", bar(s, options.alarm, width - 8));
  if (options.colour && std::isfinite(s)) index = painted(index, colour_of(line.acted_on, options.alarm));
  const std::string words = fmt::format(
      "{}{}{}frame {}, {:.0f} us, full block {:.3g} MPa, history {:.0f} s", note.empty() ? "" : note + "; ",
      line.contact == false ? "no contact; "
      : line.cannot_tell    ? (line.alarm ? "ALARM: cannot tell; " : "cannot tell; ")
      : line.alarm          ? "ALARM: slip is near; "
                            : "",
      std::isfinite(line.true_slip_index.value_or(NAN)) ? fmt::format("true S {:.3f}; ", *line.true_slip_index) : "",
      line.frame.number, line.latency, largest_stress, static_cast<double>(room) * SlipTrace::seconds_per_column);
  return fmt::format("{}\nhistory|{}|\n{}{}\n", index, history_text(history, room),
                     options.pads.empty()
                         ? line_text(line.stresses, largest_stress, room)
                         : pads_text(line, options.pads, largest_stress, static_cast<std::size_t>(width)),
                     words.substr(0, static_cast<std::size_t>(width)));
}

std::optional<std::string> LiveView::show(const MonitorLine& line, int columns) {
  for (const float stress : line.stresses)
    if (std::isfinite(stress)) largest_stress_ = std::max(largest_stress_, std::abs(stress));
  for (const Drift& drift : line.drift) note_ = drift.advice();
  history_.add(line.frame.arrival, line.answer.slip_index, static_cast<std::size_t>(std::max(columns, least_columns)));
  const auto now = std::chrono::steady_clock::now();
  if (lines_ == 0 || now - last_ >= refresh) {
    last_ = now;
    return picture(line, columns);
  }
  stresses_.assign(line.stresses.begin(), line.stresses.end());
  waiting_ = line;
  waiting_->stresses = stresses_;
  return std::nullopt;
}

std::optional<std::string> LiveView::show_newest(int columns) {
  if (!waiting_) return std::nullopt;
  return picture(*waiting_, columns);
}

// With a cursor: up over the picture before; each line is cleared to its end.
std::string LiveView::picture(const MonitorLine& line, int columns) {
  std::string text = view_text(line, history_, largest_stress_, columns, options_, note_);
  if (options_.cursor) {
    for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 4) text.replace(at, 1, "\x1b[K\n");
    if (lines_ > 0) text.insert(0, fmt::format("\x1b[{}A", lines_));
  }
  lines_ = std::ranges::count(text, '\n');
  waiting_.reset();
  return text;
}

}  // namespace tactel::host
