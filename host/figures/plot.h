// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace tactel::host {

/// Figures: panels in rows. A panel is series over a pair of axes, on top of an optional map. This header draws a
/// figure as a file, a page draws it in the browser (page.h).

/// `diamonds` are the numbers of the paper. Shear has long dashes, and triangles at tactels: its colour alone is too
/// near to that of pressure for some eyes. Pages alone draw thin lines, dots, crosses, bars and whiskers.
enum class Mark {
  line,
  thin,
  dashed,
  long_dashes,
  dots,
  circles,
  triangles,
  crosses,
  diamonds,
  line_dots,
  dash_triangles,
  bars,
  band,
  whiskers
};

/// Colours of series, distinguishable by the colour-blind.
enum class Ink { blue, orange, green, purple, red, brown, grey, black };

struct Series {
  std::string label{};           ///< empty: not in the legend
  std::vector<double> x{}, y{};  ///< NaN in y breaks a line
  Mark mark = Mark::line;
  Ink ink = Ink::blue;
  std::vector<double> low{}, high{};  ///< for band (between them) and whiskers (about y)
  std::vector<std::string> names{};   ///< [x] beside the points, or empty; pages alone show them
};

enum class Palette { sequential, diverging };

/// Values on a regular grid, drawn as an image with a colour scale. Pages alone draw it.
struct Raster {
  int rows = 0, columns = 0;
  std::vector<double> values{};                    ///< [rows, columns], first row at y_range.first; NaN is left blank
  std::pair<double, double> x_range{}, y_range{};  ///< outer edges of the image, in axis units
  std::string unit{};                              ///< beside the colour scale
  Palette palette = Palette::sequential;
  std::optional<std::pair<double, double>> limits{};  ///< of the colour scale; diverging: symmetric about 0 by default
  int isolines = 0;                                   ///< lines of equal value over a smooth image; 0: plain cells
};

/// Quadrangles coloured by their values, below the series. Files alone show them.
struct Mosaic {
  std::vector<double> x{}, y{};  ///< [tiles, 4] corners in their order around, in axis units
  std::vector<double> values{};  ///< [tiles]
  std::string unit{};            ///< beside the colour scale
  Palette palette = Palette::sequential;
  double most = 1;  ///< end of the colour scale; it begins at 0, a diverging one at -most
};

struct Panel {
  std::string title{}, x_label{}, y_label{};
  std::vector<Series> series{};
  std::optional<Raster> raster{};
  std::optional<Mosaic> mosaic{};
  std::optional<std::pair<double, double>> x_range{}, y_range{};
  std::vector<std::pair<double, std::string>> x_ticks{};  ///< labelled positions instead of numbers
  bool log_x = false, log_y = false;
  bool zero_line = false;  ///< a thin line at y = 0
};

struct Figure {
  std::string title{};
  std::vector<Panel> panels{};
  int columns = 1;         ///< panels side by side
  int width = 820;         ///< pixels, of the whole figure in a file; a page uses its own
  int panel_height = 300;  ///< pixels
};

/// Returns text with the characters of markup ( _ ^ { } @ & ~ \ ) escaped.
std::string plain(const std::string& text);

/// Returns the distance of ticks, 1, 2 or 5 times a power of ten, at which at most `most` intervals fit; 0 for an empty
/// range.
double tick_distance(std::pair<double, double> range, int most);

/// Returns width and height of the axes of a panel of the figure in a file, pixels.
std::pair<double, double> axes_size(const Figure& figure, const Panel& panel);

/// Returns the figure as text of an SVG file. Throws PlotError for what pages alone draw.
std::string render_svg(const Figure& figure);

/// Writes FILE.svg, FILE.png or FILE.pdf, by the extension. `option` is its name in errors, such as --plot. Throws
/// ConfigError, PlotError.
void write_figure(const std::string& option, const std::filesystem::path& path, const Figure& figure);

/// Throws ConfigError where write_figure could not draw to this name: the extension is unknown, or needs rsvg-convert,
/// which is missing.
void check_figure_path(const std::string& option, const std::filesystem::path& path);

/// A figure could not be drawn; of rsvg-convert the message contains its output.
class PlotError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace tactel::host
