#pragma once
#include <vector>

namespace tactel::host {

/// A field at the corners of a rectilinear grid.
struct GridField {
  std::vector<double> x, y;    ///< [columns], [rows] increasing, mm
  std::vector<double> values;  ///< [rows, columns]
  double at(std::size_t row, std::size_t column) const { return values[row * x.size() + column]; }
};

/// Returns the value at a point, bilinear in each cell; NaN outside.
double interpolate(const GridField& field, double x, double y);

/// Straight segments of the line on which the field equals `level`. Points in pairs; a NaN point ends each pair.
struct ContourLine {
  std::vector<double> x, y;
};
/// Returns a contour line by marching squares. A saddle is cut by the mean of its corners.
ContourLine contour_line(const GridField& field, double level);

}  // namespace tactel::host
