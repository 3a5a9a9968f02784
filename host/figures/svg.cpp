// SPDX-License-Identifier: Apache-2.0

// Figures as SVG, by the rules of pages (host/figures/page/), in the colours of its style.css and raster.js.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/figures/plot.h"

namespace tactel::host {
namespace {

using std::string;
using Range = std::pair<double, double>;

constexpr const char *head_colour = "#1a2029", *letter_colour = "#56616e", *axis_colour = "#8a939d",
                     *grid_colour = "#e4e6e7";
const char* colour(Ink ink) {
  constexpr std::array inks = {"#1f66b5", "#b85a00", "#00806a", "#8240a8", "#bd2c2c", "#85602b", "#6b7580", "#1a2029"};
  return inks[static_cast<std::size_t>(ink)];
}
using Stops = std::array<unsigned, 5>;
const Stops& stops(const Mosaic& m) {
  static constexpr Stops sequential = {0xf8f5ee, 0xf1c573, 0xd76f3d, 0x8d2048, 0x360d3c},
                         diverging = {0x1b4b96, 0x6ba1d6, 0xf5f4f0, 0xe88f6c, 0xa11d22};
  return m.palette == Palette::diverging ? diverging : sequential;
}

/// Text on the line (0), below it (-1) or above it (1).
struct Piece {
  string text;
  int height;
};

/// Pieces of "τ_{xy}" and "σ_y". A backslash makes the next letter plain.
std::vector<Piece> pieces(const string& text) {
  std::vector<Piece> out;
  for (std::size_t i = 0; i < text.size();) {
    int height = text[i] == '_' ? -1 : text[i] == '^' ? 1 : 0;
    if ((height != 0 || text[i] == '\\') && i + 1 < text.size())
      ++i;
    else
      height = 0;
    std::size_t end = height != 0 && text[i] == '{' ? text.find('}', i) : string::npos, next = end + 1;
    if (end != string::npos) {
      ++i;
    } else {  // a letter with the bytes that continue it
      end = i + 1;
      while (end < text.size() && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) ++end;
      next = end;
    }
    if (out.empty() || out.back().height != height) out.push_back({"", height});
    out.back().text += text.substr(i, end - i);
    i = next;
  }
  return out;
}

/// About, in pixels.
double text_width(const string& text) {
  constexpr double letter = 6.9;
  double width = 0;
  for (const Piece& piece : pieces(text))
    for (const char c : piece.text)
      if ((static_cast<unsigned char>(c) & 0xc0) != 0x80) width += piece.height == 0 ? letter : 0.8 * letter;
  return width;
}

/// XML holds no control characters.
string escaped(const string& text) {
  string out;
  for (const char c : text) {
    if (c == '<' || c == '>' || c == '&')
      out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : "&amp;";
    else
      out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return out;
}

/// `turn`: degrees about the place. `more`: attributes.
string text(double x, double y, const string& words, const char* anchor, int turn = 0, const string& more = "") {
  string out = fmt::format(
      "<text xml:space=\"preserve\" transform=\"translate({:.1f},{:.1f}) rotate({})\" text-anchor=\"{}\" {}>", x, y,
      turn, anchor, more);
  int low = 0;
  for (const Piece& piece : pieces(words)) {
    const int down = piece.height == 1 ? -4 : piece.height == -1 ? 3 : 0;
    out += fmt::format("<tspan dy=\"{}\"{}>{}</tspan>", down - low, down == 0 ? "" : " font-size=\"80%\"",
                       escaped(piece.text));
    low = down;
  }
  return out + "</text>\n";
}

/// A bold text, smaller where it is wider than its room.
string heading(double x, double y, const string& words, const char* anchor, double size, double room) {
  constexpr double bold = 1.15;
  const double width = bold * text_width(words) * size / 12;
  return text(x, y, words, anchor, 0,
              fmt::format("font-weight=\"bold\" font-size=\"{:.1f}\" fill=\"{}\"",
                          size * std::min(1.0, room / std::max(width, 1.0)), head_colour));
}

string path(const string& way, const string& look) { return fmt::format("<path d=\"{}\" {}/>\n", way, look); }
string line(double x1, double y1, double x2, double y2, const char* stroke) {
  return path(fmt::format("M{:.1f},{:.1f}L{:.1f},{:.1f}", x1, y1, x2, y2), fmt::format("stroke=\"{}\"", stroke));
}

struct Tick {
  double at;
  string name;
};

/// A number with few digits: "0.25", "5·10^{−4}".
string number(double value) {
  string out = fmt::format("{:.6g}", value);
  if (value != 0 && (std::abs(value) < 1e-3 || std::abs(value) >= 1e5)) {
    const int power = static_cast<int>(std::floor(std::log10(std::abs(value)) + 1e-9));
    const string front = fmt::format("{:.4g}", value / std::pow(10.0, power));
    out = (front == "1" ? "" : front + "·") + fmt::format("10^{{{}}}", power);
  }
  for (std::size_t at = 0; (at = out.find('-', at)) != string::npos;) out.replace(at, 1, "−");
  return out;
}

struct Axis {
  Range range, pixels;
  bool log = false;

  /// NaN where the axis has no place for a value.
  double operator()(double value) const {
    const auto scaled = [this](double v) { return log ? std::log10(v) : v; };
    const double low = scaled(range.first), part = (scaled(value) - low) / (scaled(range.second) - low),
                 at = pixels.first + part * (pixels.second - pixels.first);
    return std::isfinite(at) ? std::clamp(at, -1e5, 1e5) : NAN;
  }

  /// At most so many; on a logarithmic axis powers of ten, of three or less with their 2 and 5.
  std::vector<Tick> ticks(double most) const {
    const double low = range.first, high = range.second;
    std::vector<Tick> out;
    const auto add = [&](double at) {
      if (at >= low - 1e-9 * (high - low) && at <= high + 1e-9 * (high - low)) out.push_back({at, number(at)});
    };
    const int first = log ? static_cast<int>(std::floor(std::log10(low))) : 0,
              last = log ? static_cast<int>(std::ceil(std::log10(high))) : 0,
              every = std::max(1, static_cast<int>(std::ceil((last - first) / most)));
    for (int power = first; log && power <= last; power += every)
      for (const double front : {1.0, 2.0, 5.0})
        if (front == 1 || last - first <= 3) add(front * std::pow(10.0, power));
    const double step = tick_distance(range, static_cast<int>(most));
    if (out.size() > 2 || (log && high > 5 * low) || !(step > 0)) return out;
    out.clear();
    const double start = std::ceil(low / step - 1e-9);
    for (int k = 0; k <= most + 1; ++k) add((start + k) * step + 0.0);  // no -0
    return out;
  }
};

/// The given range, where it has a place on the axis, or that of numbers with room around them.
Range range_of(const std::vector<double>& values, const std::optional<Range>& given, bool log, double room) {
  if (given && (!log || given->first > 0)) return *given;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double value : values)
    if (std::isfinite(value) && (!log || value > 0)) low = std::min(low, value), high = std::max(high, value);
  if (!(low <= high)) return log ? Range(0.1, 1) : Range(0, 1);
  if (log) {
    const double factor = low == high ? 2 : std::pow(high / low, room);
    return {low / factor, high * factor};
  }
  const double more = low < high ? room * (high - low) : low == 0 ? 0.5 : 0.1 * std::abs(low);
  return {low - more, high + more};
}

Range x_range(const Panel& p) {
  std::vector<double> values;
  for (const Series& s : p.series) values.insert(values.end(), s.x.begin(), s.x.end());
  return range_of(values, p.x_range, p.log_x, p.x_ticks.empty() ? 0.02 : 0.08);
}

Range y_range(const Panel& p) {
  std::vector<double> values;
  for (const Series& s : p.series)
    for (const auto* numbers : {&s.y, &s.low, &s.high}) values.insert(values.end(), numbers->begin(), numbers->end());
  if (p.zero_line) values.push_back(0);
  const Range range = range_of(values, p.y_range, p.log_y, 0.05);
  const bool from_zero = p.zero_line && !p.y_range && std::abs(range.first) < 0.06 * (range.second - range.first);
  return from_zero ? Range(0, range.second) : range;
}

constexpr double sample_width = 22, row_height = 20, title_height = 34;  // pixels

/// Where a series stands in the legend.
struct Entry {
  const Series* series;
  double x;
  int row;
};

std::vector<Entry> legend(const Panel& p, double width) {
  std::vector<Entry> out;
  double x = 0;
  int row = 0;
  for (const Series& s : p.series) {
    if (s.label.empty() || s.x.empty()) continue;
    const double wide = sample_width + 8 + text_width(s.label);
    if (x > 0 && x + wide > width) x = 0, ++row;
    out.push_back({&s, x, row});
    x += wide + 20;
  }
  return out;
}

/// A panel's axes, pixels from its upper left corner.
struct Axes {
  double left = 82, right, top = 34, floor;
  bool tilted = false;  ///< names of ticks
};

Axes axes_of(const Figure& f, const Panel& p) {
  constexpr double margin = 24, colour_scale = 56, longest_name = 110;
  Axes axes{.right = static_cast<double>(f.width) / std::max(1, f.columns) - margin - (p.mosaic ? colour_scale : 0),
            .floor = f.panel_height - 54.0};
  const double width = axes.right - axes.left;
  if (const std::vector<Entry> entries = legend(p, width); !entries.empty())
    axes.top += row_height * (entries.back().row + 1);
  double widest = 0;
  for (const auto& [at, name] : p.x_ticks) widest = std::max(widest, text_width(name));
  const auto [from, to] = x_range(p);
  axes.tilted = p.x_ticks.size() > 1 && widest > width * (p.x_ticks[1].first - p.x_ticks[0].first) / (to - from) - 4;
  if (axes.tilted) axes.floor -= std::min(longest_name, 0.57 * widest);
  return axes;
}

string point(Mark kind, double x, double y, double r, const char* ink) {
  const string look = fmt::format("fill=\"{}\" stroke=\"#fff\" stroke-width=\"0.8\"", ink);
  if (kind == Mark::triangles || kind == Mark::dash_triangles)
    return path(fmt::format("M{:.1f},{:.1f}l{:.1f},{:.1f}h{:.1f}Z", x, y - 1.25 * r, 1.15 * r, 2.1 * r, -2.3 * r),
                look);
  if (kind == Mark::diamonds)
    return path(
        fmt::format("M{0:.1f},{1:.1f}l{2:.1f},{2:.1f}l-{2:.1f},{2:.1f}l-{2:.1f},-{2:.1f}Z", x, y - 1.5 * r, 1.5 * r),
        look);
  return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" {}/>\n", x, y, r, look);
}

bool has_line(Mark mark) {
  return mark == Mark::line || mark == Mark::dashed || mark == Mark::long_dashes || mark == Mark::line_dots ||
         mark == Mark::dash_triangles;
}
bool has_points(Mark mark) {
  return mark == Mark::circles || mark == Mark::triangles || mark == Mark::diamonds || mark == Mark::line_dots ||
         mark == Mark::dash_triangles;
}
const char* dashes(Mark mark) {
  if (mark == Mark::dashed) return " stroke-dasharray=\"5 4\"";
  return mark == Mark::long_dashes || mark == Mark::dash_triangles ? " stroke-dasharray=\"11 3\"" : "";
}

/// Attributes of a line or a band.
string look(const Series& s) {
  if (s.mark == Mark::band) return fmt::format("fill=\"{}\" fill-opacity=\"0.16\"", colour(s.ink));
  return fmt::format("fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"{}", colour(s.ink),
                     s.mark == Mark::line || s.mark == Mark::long_dashes ? 1.9 : 1.6, dashes(s.mark));
}

class PanelPainter {
 public:
  PanelPainter(const Figure& f, std::size_t index) : p_(f.panels[index]), index_(index), axes_(axes_of(f, p_)) {
    if (p_.raster) throw PlotError("no file shows a raster; a page does");
    const int columns = std::max(1, f.columns), place = static_cast<int>(index), row = place / columns;
    width_ = static_cast<double>(f.width) / columns, height_ = f.panel_height;
    left_ = width_ * (place % columns), top_ = (f.title.empty() ? 0 : title_height) + height_ * row;
    x_ = {x_range(p_), {axes_.left, axes_.right}, p_.log_x}, y_ = {y_range(p_), {axes_.floor, axes_.top}, p_.log_y};
  }

  string drawn() const {
    string out = fmt::format("<g transform=\"translate({},{})\">\n", left_, top_) + grid();
    if (p_.mosaic) out += tiles(*p_.mosaic);
    out += fmt::format(
        "<clipPath id=\"clip{0}\"><rect x=\"{1}\" y=\"{2}\" width=\"{3}\" height=\"{4}\"/></clipPath>\n"
        "<g clip-path=\"url(#clip{0})\">\n",
        index_, axes_.left, axes_.top, axes_.right - axes_.left, axes_.floor - axes_.top);
    for (const Series& s : p_.series) out += line_of(s);
    out += "</g>\n";
    for (const Series& s : p_.series) out += points_of(s);
    return out + head() + "</g>\n";
  }

 private:
  string grid() const {
    const auto [left, right, top, floor, tilted] = axes_;
    string out;
    for (const Tick& tick : y_.ticks(std::clamp((floor - top) / 26, 3.0, 10.0))) {
      if (!p_.mosaic) out += line(left, y_(tick.at), right, y_(tick.at), grid_colour);
      out += text(left - 8, y_(tick.at) + 4, tick.name, "end");
    }
    std::vector<Tick> ticks;
    for (const auto& [at, name] : p_.x_ticks) ticks.push_back({at, name});
    if (ticks.empty()) ticks = x_.ticks(std::clamp((right - left) / 58, 2.0, 12.0));
    for (const Tick& tick : ticks) {
      const double at = x_(tick.at);
      if (std::isnan(at)) continue;
      if (!p_.mosaic && p_.x_ticks.empty()) out += line(at, top, at, floor, grid_colour);
      out += text(at + (tilted ? 4 : 0), floor + (tilted ? 14 : 18), tick.name, tilted ? "end" : "middle",
                  tilted ? -35 : 0);
    }
    if (p_.zero_line && y_.range.first < 0) out += line(left, y_(0), right, y_(0), axis_colour);
    out += path(fmt::format("M{},{}V{}H{}{}", left, top, floor, right, p_.mosaic ? fmt::format("V{}Z", top) : ""),
                fmt::format("fill=\"none\" stroke=\"{}\"", axis_colour));
    return out + text((left + right) / 2, height_ - 14, p_.x_label, "middle") +
           text(left - 60, (top + floor) / 2, p_.y_label, "middle", -90);
  }

  /// Title and legend.
  string head() const {
    string out = heading(axes_.left, 20, p_.title, "start", 13, width_ - axes_.left);
    for (const auto& [s, along, row] : legend(p_, axes_.right - axes_.left)) {
      const double x = axes_.left + along, y = 37 + row_height * row;
      const char* end = s->mark == Mark::band ? "v5h-22v-10h22Z" : "";
      if (s->mark == Mark::band || has_line(s->mark)) out += path(fmt::format("M{:.1f},{}h22{}", x, y, end), look(*s));
      if (has_points(s->mark)) out += point(s->mark, x + sample_width / 2, y, 3.6, colour(s->ink));
      out += text(x + sample_width + 8, y + 4, s->label, "start");
    }
    return out;
  }

  /// A line or a band.
  string line_of(const Series& s) const {
    if (has_line(s.mark)) return path(way(s.x, s.y), look(s));
    if (s.mark != Mark::band) return "";
    std::vector<double> x = s.x, y = s.high;
    x.insert(x.end(), s.x.rbegin(), s.x.rend()), y.insert(y.end(), s.low.rbegin(), s.low.rend());
    return path(way(x, y, false) + "Z", look(s));
  }

  string points_of(const Series& s) const {
    if (s.mark == Mark::band || (has_line(s.mark) && !has_points(s.mark))) return "";
    if (!has_points(s.mark)) throw PlotError("no file shows this mark; a page does");
    const double r = has_line(s.mark) ? 2.8 : p_.mosaic ? 3.2 : 4;
    string out;
    for (std::size_t k = 0; k < std::min(s.x.size(), s.y.size()); ++k) {
      const double x = x_(s.x[k]), y = y_(s.y[k]);
      if (x > axes_.left - 1 && x < axes_.right + 1 && y > axes_.top - 1 && y < axes_.floor + 1)
        out += point(s.mark, x, y, r, colour(s.ink));
    }
    return out;
  }

  /// A line through points. A NaN breaks it or is passed over.
  string way(const std::vector<double>& x, const std::vector<double>& y, bool breaks = true) const {
    string out;
    bool pen = false;
    for (std::size_t k = 0; k < std::min(x.size(), y.size()); ++k) {
      const double across = x_(x[k]), up = y_(y[k]);
      const bool there = !std::isnan(across + up);
      if (there) out += fmt::format("{}{:.1f},{:.1f}", pen ? 'L' : 'M', across, up);
      pen = there || (pen && !breaks);
    }
    return out;
  }

  /// Quadrangles, with edges of their colour lest seams show; beside the axes the scale of colours.
  string tiles(const Mosaic& m) const {
    const Axis scale{{m.palette == Palette::diverging ? -m.most : 0, m.most}, {0, 4}};
    string out;
    for (std::size_t tile = 0; tile < m.values.size(); ++tile) {
      string corners;
      for (std::size_t k = 4 * tile; k < 4 * tile + 4; ++k)
        corners += fmt::format("{:.1f},{:.1f} ", x_(m.x[k]), y_(m.y[k]));
      const double at = std::clamp(scale(m.values[tile]), 0.0, 4.0);
      const auto from = std::min<std::size_t>(static_cast<std::size_t>(at), 3);
      unsigned rgb = 0;
      for (const unsigned shift : {16U, 8U, 0U}) {
        const double low = stops(m)[from] >> shift & 0xffU, high = stops(m)[from + 1] >> shift & 0xffU;
        rgb |= static_cast<unsigned>(std::lround(low + (at - static_cast<double>(from)) * (high - low))) << shift;
      }
      out += fmt::format("<polygon points=\"{0}\" fill=\"#{1:06x}\" stroke=\"#{1:06x}\" stroke-width=\"0.5\"/>\n",
                         corners, rgb);
    }
    out += fmt::format("<linearGradient id=\"scale{}\" x1=\"0\" y1=\"1\" x2=\"0\" y2=\"0\">", index_);
    for (std::size_t k = 0; k < stops(m).size(); ++k)
      out += fmt::format("<stop offset=\"{}\" stop-color=\"#{:06x}\"/>", static_cast<double>(k) / 4, stops(m)[k]);
    out +=
        fmt::format("</linearGradient>\n<rect x=\"{}\" y=\"{}\" width=\"10\" height=\"{}\" fill=\"url(#scale{})\"/>\n",
                    axes_.right + 12, axes_.top, axes_.floor - axes_.top, index_);
    const Axis beside{scale.range, y_.pixels};
    for (const Tick& tick : beside.ticks(5)) out += text(axes_.right + 27, beside(tick.at) + 4, tick.name, "start");
    return out + text(width_ - 6, axes_.top - 10, m.unit, "end");
  }

  const Panel& p_;
  std::size_t index_;
  Axes axes_;
  double left_, top_, width_, height_;  ///< of the panel
  Axis x_, y_;
};

}  // namespace

string plain(const string& text) {
  string out;
  for (const char c : text) {
    if (string("_^{}@&~\\").find(c) != string::npos) out += '\\';
    out += c;
  }
  return out;
}

double tick_distance(Range range, int most) {
  const double least = (range.second - range.first) / std::max(2, most);
  if (!(least > 0) || !std::isfinite(least)) return 0;
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= least * (1 - 1e-9)) return factor * power;
  return 10 * power;
}

Range axes_size(const Figure& figure, const Panel& panel) {
  const Axes axes = axes_of(figure, panel);
  return {axes.right - axes.left, axes.floor - axes.top};
}

string render_svg(const Figure& f) {
  const int columns = std::max(1, f.columns), rows = (static_cast<int>(f.panels.size()) + columns - 1) / columns;
  string out = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" fill=\"{2}\" "
      "font-family=\"DejaVu Sans,Verdana,sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" "
      "fill=\"#fff\"/>\n",
      f.width, rows * f.panel_height + (f.title.empty() ? 0 : title_height), letter_colour);
  if (!f.title.empty()) out += heading(f.width / 2.0, 22, f.title, "middle", 15, f.width - 20);
  for (std::size_t i = 0; i < f.panels.size(); ++i) out += PanelPainter(f, i).drawn();
  return out + "</svg>\n";
}

}  // namespace tactel::host
