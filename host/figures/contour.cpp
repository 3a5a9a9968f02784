#include "host/figures/contour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tactel::host {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Index of the interval of `places` that holds `at`.
std::size_t interval(const std::vector<double>& places, double at) {
  const auto above = std::upper_bound(places.begin() + 1, places.end() - 1, at);
  return static_cast<std::size_t>(above - places.begin()) - 1;
}

struct Point {
  double x, y, value;
};

Point crossing(const Point& a, const Point& b, double level) {
  const double part = (level - a.value) / (b.value - a.value);
  return {a.x + part * (b.x - a.x), a.y + part * (b.y - a.y), level};
}

void add_piece(ContourLine& line, const Point& a, const Point& b) {
  line.x.insert(line.x.end(), {a.x, b.x, nan});
  line.y.insert(line.y.end(), {a.y, b.y, nan});
}

/// The pieces inside one cell, corners counter-clockwise. Two crossed edges are joined; with four, the mean tells which
/// corners the line cuts off.
void add_cell(ContourLine& line, const std::array<Point, 4>& corner, double level) {
  std::array<Point, 4> crossed;
  std::size_t count = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const Point &a = corner[k], &b = corner[(k + 1) % 4];
    if ((a.value < level) != (b.value < level)) crossed[count++] = crossing(a, b, level);
  }
  if (count == 2) add_piece(line, crossed[0], crossed[1]);
  if (count != 4) return;
  const double mean = (corner[0].value + corner[1].value + corner[2].value + corner[3].value) / 4;
  const bool cut_corner_1 = (mean < level) == (corner[0].value < level);
  add_piece(line, crossed[0], crossed[cut_corner_1 ? 1 : 3]);
  add_piece(line, crossed[2], crossed[cut_corner_1 ? 3 : 1]);
}

}  // namespace

double interpolate(const GridField& f, double x, double y) {
  if (!(x >= f.x.front() && x <= f.x.back() && y >= f.y.front() && y <= f.y.back())) return nan;
  const std::size_t i = interval(f.x, x), j = interval(f.y, y);
  const double s = (x - f.x[i]) / (f.x[i + 1] - f.x[i]), t = (y - f.y[j]) / (f.y[j + 1] - f.y[j]);
  return (1 - t) * ((1 - s) * f.at(j, i) + s * f.at(j, i + 1)) +
         t * ((1 - s) * f.at(j + 1, i) + s * f.at(j + 1, i + 1));
}

ContourLine contour_line(const GridField& f, double level) {
  ContourLine line;
  for (std::size_t j = 0; j + 1 < f.y.size(); ++j) {
    for (std::size_t i = 0; i + 1 < f.x.size(); ++i) {
      const auto corner = [&](std::size_t row, std::size_t column) {
        return Point{f.x[column], f.y[row], f.at(row, column)};
      };
      add_cell(line, {corner(j, i), corner(j, i + 1), corner(j + 1, i + 1), corner(j + 1, i)}, level);
    }
  }
  return line;
}

}  // namespace tactel::host
