#include "host/figures/field_figure.h"

#include <algorithm>

#include "fem/stress_field.h"
#include "host/figures/contour.h"

namespace tactel::host {
namespace {

/// Corner values of a structured mesh as a grid.
GridField grid_of(const fem::Mesh& mesh, const Eigen::VectorXd& values) {
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

/// [rows, columns] pixels between two x, the full height of the grid.
Raster resample(const GridField& grid, std::pair<double, double> x_range, int rows, int columns) {
  Raster raster{.rows = rows,
                .columns = columns,
                .x_range = x_range,
                .y_range = {grid.y.front(), grid.y.back()},
                .palette = Palette::diverging};
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const double x = x_range.first + (i + 0.5) * (x_range.second - x_range.first) / columns;
      const double y = grid.y.front() + (j + 0.5) * (grid.y.back() - grid.y.front()) / rows;
      raster.values.push_back(interpolate(grid, x, y));
    }
  }
  return raster;
}

}  // namespace

Panel field_panel(const fem::StressField& field, const Eigen::VectorXd& values, const std::string& title,
                  const std::string& unit, std::pair<double, double> x_range) {
  constexpr int lines = 12, pixel_rows = 150, pixel_columns = 600;
  const GridField grid = grid_of(field.mesh, values);
  Panel panel{.title = title, .x_label = "x (mm)", .y_label = "y (mm)"};
  panel.raster = resample(grid, x_range, pixel_rows, pixel_columns);
  panel.raster->unit = unit;
  const auto [low, high] = std::minmax_element(grid.values.begin(), grid.values.end());
  if (*low >= 0) panel.raster->palette = Palette::sequential;
  for (int k = 1; k < lines; ++k) {
    const ContourLine line = contour_line(grid, *low + (*high - *low) * k / lines);
    panel.series.push_back({.label = "", .x = line.x, .y = line.y, .mark = Mark::thin, .ink = Ink::black});
  }
  return panel;
}

}  // namespace tactel::host
