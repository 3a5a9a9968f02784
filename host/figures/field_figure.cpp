// SPDX-License-Identifier: Apache-2.0
#include "host/figures/field_figure.h"

#include <algorithm>

#include "host/figures/grid_field.h"

namespace tactel::host {

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
