// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/layer_table.h"

#include <cmath>
#include <numbers>

namespace tactel::fem {
namespace {

using Row = Eigen::Array<double, 1, LayerTable::functions>;

/// The functions of the table at one place.
Row values(const LayerKernelValues& k) {
  Row row;
  row << k.smooth_integral.yy, k.smooth_integral.xx, k.smooth_integral.xy, k.base.sigma_by_y, k.base.tau_by_x,
      k.base.tau_by_y, k.base.sigma_by_x, k.base_integral.sigma_by_y, k.base_integral.tau_by_x,
      k.base_integral.tau_by_y, k.base_integral.sigma_by_x;
  return row;
}

/// Their slopes along x / h.
Row slopes(const LayerKernelValues& k) {
  Row row;
  row << k.smooth.yy, k.smooth.xx, k.smooth.xy, k.base_slope.sigma_by_y, k.base_slope.tau_by_x, k.base_slope.tau_by_y,
      k.base_slope.sigma_by_x, k.base.sigma_by_y, k.base.tau_by_x, k.base.tau_by_y, k.base.sigma_by_x;
  return row;
}

/// int_X^x ln y dy, X the table's range.
double log_integral(double from, double to) { return to * std::log(to) - to - (from * std::log(from) - from); }

}  // namespace

Eigen::Index LayerTable::cells_over(double range, double top) {
  return static_cast<Eigen::Index>(
      std::ceil(top > 0 ? cells_a_top * std::asinh(range / top) : range * cells_a_thickness));
}

double LayerTable::end(Eigen::Index cell) const {
  const auto number = static_cast<double>(cell);
  return top_ > 0 ? top_ * std::sinh(number / cells_a_top) : number / cells_a_thickness;
}

LayerTable::LayerTable(double poisson, Coefficients coefficients, double top)
    : poisson_(poisson), top_(top), coefficients_(std::move(coefficients)) {}

LayerTable::LayerTable(double poisson, double range) : LayerTable(Rubber{poisson}, range) {}

LayerTable::LayerTable(const Rubber& rubber, double range)
    : poisson_(rubber.poisson), top_(rubber.layers.empty() ? 0 : rubber.layers.back().thickness) {
  coefficients_.resize(cells_over(range, top_), 4 * functions);
  double farthest = top_;
  LayerKernels kernels = top_ > 0 ? LayerKernels(rubber.layers, farthest) : LayerKernels(poisson_);
  add_cells([&](double x) {
    while (top_ > 0 && x > farthest) kernels = LayerKernels(rubber.layers, farthest *= 2);
    return kernels.at(x);
  });
}

/// at(x): the kernels at ends of cells, left to right.
template <class At>
void LayerTable::add_cells(const At& at) {
  LayerKernelValues left = at(0);
  for (Eigen::Index cell = 0; cell < cells(); ++cell) {
    const LayerKernelValues right = at(end(cell + 1));
    const double per = top_ > 0 ? 1 / (end(cell + 1) - end(cell)) : cells_a_thickness;
    const Row from = values(left), rise = values(right) - from;
    const Row slope = slopes(left) / per, end_slope = slopes(right) / per;
    const Row c2 = 3 * rise - 2 * slope - end_slope, c3 = slope + end_slope - 2 * rise;
    for (int f = 0; f < functions; ++f) coefficients_.row(cell).segment<4>(4 * f) << from[f], slope[f], c2[f], c3[f];
    left = right;
  }
}

LayerTable LayerTable::blend(double poisson, std::span<const LayerTable* const> tables,
                             std::span<const double> weights) {
  LayerTable sum;
  sum.poisson_ = poisson;
  sum.coefficients_ = weights[0] * tables[0]->coefficients_;
  for (std::size_t k = 1; k < tables.size(); ++k) sum.coefficients_ += weights[k] * tables[k]->coefficients_;
  return sum;
}

double LayerTable::value(Function function, double x) const {
  const double place =
      std::min(top_ > 0 ? cells_a_top * std::asinh(x / top_) : x * cells_a_thickness, static_cast<double>(cells()));
  const Eigen::Index cell = std::min(static_cast<Eigen::Index>(place), cells() - 1);
  const double q =
      top_ > 0 ? (std::min(x, range()) - end(cell)) / (end(cell + 1) - end(cell)) : place - static_cast<double>(cell);
  const double* c = &coefficients_(cell, 4 * function);
  return c[0] + q * (c[1] + q * (c[2] + q * c[3]));
}

SmoothParts LayerTable::smooth_integral(double x) const {
  const double distance = std::abs(x), sign = x < 0 ? -1 : 1;
  SmoothParts R{value(Ryy, distance), value(Rxx, distance), value(Rxy, distance)};
  if (distance > range()) {
    const double log = log_integral(range(), distance);
    R.yy += log;
    R.xx += log;
    R.xy -= (1 - 2 * poisson_) * std::numbers::pi / 2 * (distance - range());
  }
  return {sign * R.yy, sign * R.xx, R.xy};
}

BaseStress LayerTable::base(double x) const {
  const double distance = std::abs(x), sign = x < 0 ? -1 : 1;
  if (distance > range()) return {0, 0, 0, 0};
  return {value(base_sigma_by_y, distance), value(base_tau_by_x, distance), sign * value(base_tau_by_y, distance),
          sign * value(base_sigma_by_x, distance)};
}

BaseStress LayerTable::base_integral(double x) const {
  const double distance = std::abs(x), sign = x < 0 ? -1 : 1;
  return {sign * value(integral_sigma_by_y, distance), sign * value(integral_tau_by_x, distance),
          value(integral_tau_by_y, distance), value(integral_sigma_by_x, distance)};
}

}  // namespace tactel::fem
