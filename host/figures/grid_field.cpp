// SPDX-License-Identifier: Apache-2.0
#include "host/figures/grid_field.h"

#include <algorithm>
#include <limits>

namespace tactel::host {
namespace {

/// Index of the interval of `places` that holds `at`.
std::size_t interval(const std::vector<double>& places, double at) {
  const auto above = std::upper_bound(places.begin() + 1, places.end() - 1, at);
  return static_cast<std::size_t>(above - places.begin()) - 1;
}

/// Point `i` of `count` between two ends, which it never passes by rounding.
double point_of(double from, double to, int i, int count) {
  return std::clamp(from + (to - from) * i / (count - 1), from, to);
}

}  // namespace

double interpolate(const GridField& f, double x, double y) {
  if (!(x >= f.x.front() && x <= f.x.back() && y >= f.y.front() && y <= f.y.back()))
    return std::numeric_limits<double>::quiet_NaN();
  const std::size_t i = interval(f.x, x), j = interval(f.y, y);
  const double s = (x - f.x[i]) / (f.x[i + 1] - f.x[i]), t = (y - f.y[j]) / (f.y[j + 1] - f.y[j]);
  return (1 - t) * ((1 - s) * f.at(j, i) + s * f.at(j, i + 1)) +
         t * ((1 - s) * f.at(j + 1, i) + s * f.at(j + 1, i + 1));
}

GridField corner_grid(const fem::Mesh& mesh, const Eigen::VectorXd& values) {
  const std::size_t columns = mesh.surface.size(), cells = columns - 1,
                    rows = static_cast<std::size_t>(mesh.cell.rows()) / cells + 1;
  GridField grid;
  grid.values.resize(rows * columns);
  const auto corner = [&](std::size_t j,
                          std::size_t i) {  // a cell lists its corners counter-clockwise from the lower left
    const std::size_t row = std::min(j, rows - 2), column = std::min(i, cells - 1);
    const int which = (j == row) ? (i == column ? 0 : 1) : (i == column ? 3 : 2);
    return mesh.cell(static_cast<Eigen::Index>(row * cells + column), which);
  };
  for (std::size_t i = 0; i < columns; ++i) grid.x.push_back(mesh.node(0, corner(0, i)));
  for (std::size_t j = 0; j < rows; ++j) grid.y.push_back(mesh.node(1, corner(j, 0)));
  for (std::size_t j = 0; j < rows; ++j) {
    for (std::size_t i = 0; i < columns; ++i) grid.values[j * columns + i] = values[corner(j, i)];
  }
  return grid;
}

std::vector<double> resampled(const GridField& grid, std::pair<double, double> x_range, int rows, int columns) {
  std::vector<double> out;
  out.reserve(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns));
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      out.push_back(interpolate(grid, point_of(x_range.first, x_range.second, i, columns),
                                point_of(grid.y.front(), grid.y.back(), j, rows)));
  return out;
}

Panel field_panel(const fem::StressField& field, const Eigen::VectorXd& values, const std::string& title,
                  const std::string& unit, std::pair<double, double> x_range) {
  constexpr int rows = 21, columns = 161;
  const GridField grid = corner_grid(field.mesh, values);
  // The picture's cells have the samples in their middles.
  const double half_x = 0.5 * (x_range.second - x_range.first) / (columns - 1),
               half_y = 0.5 * (grid.y.back() - grid.y.front()) / (rows - 1);
  Panel panel{.title = title,
              .x_label = "x (mm)",
              .y_label = "y (mm)",
              .x_range = x_range,
              .y_range = std::pair{grid.y.front(), grid.y.back()}};
  panel.raster = Raster{.rows = rows,
                        .columns = columns,
                        .values = resampled(grid, x_range, rows, columns),
                        .x_range = {x_range.first - half_x, x_range.second + half_x},
                        .y_range = {grid.y.front() - half_y, grid.y.back() + half_y},
                        .unit = unit,
                        .palette = std::ranges::min(grid.values) < 0 ? Palette::diverging : Palette::sequential,
                        .isolines = 12};
  return panel;
}

}  // namespace tactel::host
