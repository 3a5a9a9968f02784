// SPDX-License-Identifier: Apache-2.0
#include "host/figures/gnuplot_script.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/figures/figure_layout.h"

namespace tactel::host {
namespace {

const char* colour(Ink ink) {
  static constexpr const char* colours[] = {"#1f5fa8", "#d9660a", "#1d8f5a", "#7a55b0",
                                            "#c8323c", "#8a5a33", "#8a8f98", "#22262b"};
  return colours[static_cast<int>(ink)];
}

std::string number(double value) { return std::isfinite(value) ? fmt::format("{:.9g}", value) : "NaN"; }

/// Text in double quotes of a gnuplot program. gnuplot runs `commands` in them; in single quotes it ends the text at a
/// doubled quote. What has a meaning stands as an octal code of four digits; a control character, which no SVG may
/// hold, as a blank.
/// As gnuplot reads it. It writes texts into SVG as they are, between "<![CDATA[" and "]]>": the latter gets a space.
std::string in_quotes(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '>' && out.ends_with("]]")) out += ' ';
    if (c == '"' || c == '\\' || c == '`')
      out += fmt::format("\\0{:03o}", static_cast<unsigned>(c));
    else
      out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return out + "\"";
}

/// A tick's name, which gnuplot takes for a format of its number.
std::string tick_in_quotes(const std::string& text) {
  std::string out;
  for (const char c : text) out.append(c == '%' ? 2 : 1, c);
  return in_quotes(out);
}

std::string bold(const std::string& text, double size) {
  return in_quotes(fmt::format("{{/:Bold*{} {}}}", size, text));
}

std::string block_name(std::size_t panel, const std::string& what) { return fmt::format("$panel{}_{}", panel, what); }

/// A named data block: one line a point.
std::string series_data(const std::string& name, const Series& s) {
  std::string out = name + " << END\n";
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    out += number(s.x[i]) + " " + number(i < s.y.size() ? s.y[i] : NAN);
    if (i < s.low.size() && i < s.high.size()) out += " " + number(s.low[i]) + " " + number(s.high[i]);
    out += "\n";
  }
  return out + "END\n";
}

std::string style(const Series& s) {
  const std::string ink = fmt::format("lc rgb '{}'", colour(s.ink));
  switch (s.mark) {
    case Mark::line:
      return "with lines lw 2 " + ink;
    case Mark::thin:
      return "with lines lw 1 " + ink;
    case Mark::dashed:
      return "with lines lw 1.5 dt (6,5) " + ink;
    case Mark::dots:
      return "with points pt 7 ps 0.45 " + ink;
    case Mark::circles:
      return "with points pt 7 ps 0.75 " + ink;
    case Mark::triangles:
      return "with points pt 9 ps 0.9 " + ink;
    case Mark::crosses:
      return "with points pt 2 ps 0.7 lw 1.5 " + ink;
    case Mark::diamonds:
      return "with points pt 13 ps 1 " + ink;
    case Mark::line_dots:
      return "with linespoints pt 7 ps 0.55 lw 2 " + ink;
    case Mark::bars:
      return "with boxes fs solid 0.75 noborder " + ink;
    case Mark::band:
      return "with filledcurves fs transparent solid 0.2 noborder " + ink;
    case Mark::whiskers:
      return "with yerrorbars pt 7 ps 0.6 lw 1.5 " + ink;
  }
  return "";
}

const char* columns_of(const Series& s) {
  if (s.mark == Mark::band) return "1:3:4";
  return s.mark == Mark::whiskers ? "1:2:3:4" : "1:2";
}

std::string range(const char* axis, const std::optional<std::pair<double, double>>& r) {
  return r ? fmt::format("set {}range [{}:{}]\n", axis, number(r->first), number(r->second))
           : fmt::format("set {}range [*:*]\n", axis);
}

std::string tick_words(std::pair<double, double> shown, int pixels, int pixels_each) {
  const double distance = tick_distance(shown, pixels / pixels_each);
  return distance > 0 ? number(distance) : "autofreq";
}

std::string x_ticks(const Figure& f, const Panel& p) {
  constexpr int pixels_each = 56;
  if (p.x_ticks.empty())
    return "set xtics " + (p.log_x ? "autofreq" : tick_words(shown_x(p), axes_width(f, p), pixels_each)) + "\n";
  std::string out;
  for (const auto& [place, name] : p.x_ticks)
    out += (out.empty() ? "" : ", ") + tick_in_quotes(name) + " " + number(place);
  return "set xtics (" + out + ")\n";
}

std::string y_ticks(const Figure& f, const Panel& p) {
  constexpr int pixels_each = 26;
  return "set ytics " + (p.log_y ? "autofreq" : tick_words(shown_y(p), axes_height(f, p), pixels_each)) + "\n";
}

std::string axes(const Figure& f, const Panel& p) {
  const double title_rows = 0.9 + 1.35 * legend_rows(f, p);  // in heights of a letter
  std::string out = fmt::format("set label 1 {} at graph 0,1 left offset 0,{} textcolor rgb '#15191e'\n",
                                bold(p.title, 1.08), title_rows);
  out += "set xlabel " + in_quotes(p.x_label) + "\nset ylabel " + in_quotes(p.y_label) + "\n";
  out += range("x", p.x_range);
  out += range("y", p.y_range);
  out += x_ticks(f, p) + y_ticks(f, p) +
         (p.log_x ? "set logscale x\nset format x '10^{%L}'\n" : "unset logscale x\nset format x '%g'\n");
  out += p.log_y ? "set logscale y\nset format y '10^{%L}'\n" : "unset logscale y\nset format y '%g'\n";
  out += p.zero_line ? "set xzeroaxis lw 1 lc rgb '#9aa0a8'\n" : "unset xzeroaxis\n";
  return out + "set grid lt 1 lw 0.7 lc rgb '#dfe3e7'\n";
}

/// Where the panel's axes stand in the figure, pixels from its lower left.
struct Corner {
  double left, bottom, top;
};
Corner corner_of(const Figure& f, std::size_t index, int height) {
  const int columns = std::max(1, f.columns), row = static_cast<int>(index) / columns,
            column = static_cast<int>(index) % columns;
  const int head = f.title.empty() ? 0 : figure_title_height;
  const double top = height - head - row * f.panel_height;
  return {static_cast<double>(f.width) / columns * column + left_margin, top - f.panel_height + bottom_margin,
          top - top_margin(f, f.panels[index])};
}

/// The same as margins, fractions of the figure.
std::string place(const Figure& f, std::size_t index, int height) {
  const Corner corner = corner_of(f, index, height);
  const auto across = [&](double pixels) { return pixels / f.width; };
  const auto up = [&](double pixels) { return pixels / height; };
  return fmt::format(
      "set lmargin at screen {:.5f}\nset rmargin at screen {:.5f}\nset tmargin at screen {:.5f}\nset bmargin at screen "
      "{:.5f}\n",
      across(corner.left), across(corner.left + axes_width(f, f.panels[index])), up(corner.top), up(corner.bottom));
}

std::string plot_command(const Panel& p, std::size_t index) {
  std::vector<std::string> parts;
  if (p.mosaic && !p.mosaic->values.empty())
    parts.push_back(block_name(index, "tiles") + " using 1:2:(0):3 with pm3d notitle");
  for (std::size_t k = 0; k < p.series.size(); ++k) {
    const Series& s = p.series[k];
    const std::string legend = s.label.empty() ? "notitle" : "title " + in_quotes(s.label);
    parts.push_back(fmt::format("{} using {}{} {} {}", block_name(index, std::to_string(k)), columns_of(s),
                                p.mosaic ? ":(0)" : "", legend, style(s)));
  }
  if (parts.empty()) parts.push_back("NaN notitle");
  return fmt::format("{} {}\n", p.mosaic ? "splot" : "plot", fmt::join(parts, ", \\\n  "));
}

/// A surface of two by two points each tile: x, y, value.
std::string mosaic_data(const std::string& name, const Mosaic& m) {
  std::string out = name + " << END\n";
  for (std::size_t tile = 0; tile < m.values.size(); ++tile) {
    for (const std::size_t corner : {0, 1, 3, 2}) {
      const std::size_t at = 4 * tile + corner;
      out += fmt::format("{} {} {}\n{}", number(m.x[at]), number(m.y[at]), number(m.values[tile]),
                         corner == 1   ? "\n"
                         : corner == 2 ? "\n\n"
                                       : "");
    }
  }
  return out + "END\n";
}

/// Colours as those of pages (host/figures/page/raster.js), their scale to the right of the axes.
std::string mosaic_colours(const Figure& f, std::size_t index, int height) {
  const Mosaic& m = *f.panels[index].mosaic;
  const bool diverging = m.palette == Palette::diverging;
  const Corner corner = corner_of(f, index, height);
  const double right = corner.left + axes_width(f, f.panels[index]) + 10;
  return fmt::format(
      "set view map\nset pm3d map corners2color c1\nset palette defined ({})\nset cbrange [{}:{}]\nset cblabel {}\n"
      "set xtics offset 0,0.5\nset xlabel offset 0,0.9\nset key at screen {:.5f},{:.5f}\nset colorbox user origin "
      "screen {:.5f},{:.5f} size screen "
      "{:.5f},{:.5f}\nset cbtics {}\n",
      diverging ? "0 '#1b4b96', 1 '#6ba1d6', 2 '#f5f4f0', 3 '#e88f6c', 4 '#a11d22'"
                : "0 '#f8f5ee', 1 '#f1c573', 2 '#d76f3d', 3 '#8d2048', 4 '#360d3c'",
      number(diverging ? -m.most : 0), number(m.most), in_quotes(m.unit), corner.left / f.width,
      (corner.top + 4 + legend_row_height * legend_rows(f, f.panels[index])) / height, right / f.width,
      corner.bottom / height, 10.0 / f.width, (corner.top - corner.bottom) / height,
      number(tick_distance({diverging ? -m.most : 0, m.most}, 5)));
}

/// Size and letters; a bitmap gets two pixels for one, to stay sharp.
std::string terminal_size(const std::string& terminal, int width, int height) {
  if (terminal == "svg") return fmt::format("size {},{} font 'DejaVu Sans,Verdana,sans-serif,12'", width, height);
  return fmt::format("size {},{} font 'DejaVu Sans,9' fontscale 2 linewidth 2 pointscale 2", 2 * width, 2 * height);
}

std::string panel_script(const Figure& f, std::size_t index, int height) {
  const Panel& p = f.panels[index];
  std::string out;
  if (p.raster) throw PlotError("gnuplot draws no raster; a page does");
  for (std::size_t k = 0; k < p.series.size(); ++k)
    out += series_data(block_name(index, std::to_string(k)), p.series[k]);
  out += axes(f, p) + place(f, index, height);
  if (!p.mosaic) return out + plot_command(p, index);
  return out + mosaic_data(block_name(index, "tiles"), *p.mosaic) + mosaic_colours(f, index, height) +
         "set border 15\nunset grid\n" + plot_command(p, index) +
         "set border 3\nset xtics offset 0,0\nset xlabel offset 0,0.2\nset key at graph 0,1.03\n";
}

}  // namespace

std::string plain(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (std::string("_^{}@&~\\").find(c) != std::string::npos) out += '\\';
    out += c;
  }
  return out;
}

std::string gnuplot_script(const Figure& figure, const std::string& terminal, const std::string& output) {
  const int height = figure_height(figure);
  std::string out = fmt::format("set encoding utf8\nset terminal {} enhanced background '#ffffff' {}\nset output {}\n",
                                terminal, terminal_size(terminal, figure.width, height), in_quotes(output));
  out +=
      "set border 3 lw 1 lc rgb '#7b828c'\nset tics nomirror out scale 0.6 textcolor rgb '#3a4048'\n"
      "set xlabel offset 0,0.2 textcolor rgb '#3a4048'\n"
      "set ylabel textcolor rgb '#3a4048'\nset style fill solid\nset clip two\n"
      "set key at graph 0,1.03 left bottom horizontal Left reverse samplen 1.8 spacing 1.1 width 1 textcolor rgb "
      "'#3a4048'\n";
  out += fmt::format("set multiplot{}\n",
                     figure.title.empty() ? "" : " title " + bold(figure.title, 1.25) + " textcolor rgb '#15191e'");
  for (std::size_t i = 0; i < figure.panels.size(); ++i) out += panel_script(figure, i, height);
  return out + "unset multiplot\nunset output\n";
}

}  // namespace tactel::host
