// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "fem/gap/stress_field.h"
#include "host/figures/plot.h"

namespace tactel::host {

/// A field at the corners of a rectilinear grid.
struct GridField {
  std::vector<double> x, y;    ///< [columns], [rows] increasing, mm
  std::vector<double> values;  ///< [rows, columns]
  double at(std::size_t row, std::size_t column) const { return values[row * x.size() + column]; }
};

/// Returns the value at a point, bilinear in each cell; NaN outside.
double interpolate(const GridField& field, double x, double y);

/// Returns values [nodes] at the corners of the mesh's elements as a grid.
GridField corner_grid(const fem::Mesh& mesh, const Eigen::VectorXd& values);

/// Returns values [rows, columns] at evenly spaced points between two x and over the whole height, the ends included;
/// the first row is the base.
std::vector<double> resampled(const GridField& grid, std::pair<double, double> x_range, int rows, int columns);

/// Returns a panel of one quantity inside the block, coloured, with contour lines, for a page. `values` [nodes];
/// x from..to of the block, mm.
Panel field_panel(const fem::StressField& field, const Eigen::VectorXd& values, const std::string& title,
                  const std::string& unit, std::pair<double, double> x_range);

}  // namespace tactel::host
