#pragma once
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace tactel::host {

/// Figures drawn by gnuplot, in one style. A figure is panels in rows. A panel is series over a pair of axes, on
/// top of an optional raster.

enum class Mark { line, thin, dashed, dots, circles, triangles, crosses, line_dots, bars, band, whiskers };

/// Colours of series, distinguishable by the colour-blind.
enum class Ink { blue, orange, green, purple, red, brown, grey, black };

struct Series {
  std::string label{};           ///< empty: not in the legend
  std::vector<double> x{}, y{};  ///< NaN in y breaks a line
  Mark mark = Mark::line;
  Ink ink = Ink::blue;
  std::vector<double> low{}, high{};  ///< for band (between them) and whiskers (about y)
};

enum class Palette { sequential, diverging, status };  ///< status: 0 open, 1 stick, 2 slip

/// Values on a regular grid, drawn as an image with a colour scale: maps and heat strips.
struct Raster {
  int rows = 0, columns = 0;
  std::vector<double> values{};                    ///< [rows, columns], first row at y_range.first; NaN is left blank
  std::pair<double, double> x_range{}, y_range{};  ///< outer edges of the image, in axis units
  std::string unit{};                              ///< beside the colour scale
  Palette palette = Palette::sequential;
  std::optional<std::pair<double, double>> limits{};  ///< of the colour scale; diverging: symmetric about 0 by default
};

struct Panel {
  std::string title{}, x_label{}, y_label{};
  std::vector<Series> series{};
  std::optional<Raster> raster{};
  std::optional<std::pair<double, double>> x_range{}, y_range{};
  std::vector<std::pair<double, std::string>> x_ticks{};  ///< labelled positions instead of numbers
  bool log_x = false, log_y = false;
  bool equal_axes = false;  ///< equal scales along x and y
  bool zero_line = false;   ///< a thin line at y = 0
};

struct Figure {
  std::string title{};
  std::vector<Panel> panels{};
  int columns = 1;         ///< panels side by side
  int width = 820;         ///< pixels, of the whole figure
  int panel_height = 300;  ///< pixels
};

/// Returns the figure as text of an SVG file. Throws PlotError.
std::string render_svg(const Figure& figure);

/// Writes FILE.svg or FILE.png, by the extension. `option` is its name in errors, such as --plot. Throws
/// ConfigError, PlotError.
void write_figure(const std::string& option, const std::filesystem::path& path, const Figure& figure);

/// Throws ConfigError where write_figure could not draw to this name: gnuplot is missing, or the extension is
/// unknown.
void check_figure_path(const std::string& option, const std::filesystem::path& path);

/// gnuplot failed; the message contains its output.
class PlotError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace tactel::host
