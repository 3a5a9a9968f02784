// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <span>

#include "fem/layer/layer_kernels.h"
#include "fem/scenes/rubber.h"

namespace tactel::fem {

/// The kernels of one Poisson's ratio, or of layers upon layers, as piecewise cubics over x / h, for E = 1 MPa. Hermite
/// interpolation of exact values and slopes: an integral is off by some 1e-8, a difference of two integrals over their
/// distance by some 1e-6.
class LayerTable {
 public:
  static constexpr int cells_a_thickness = 24;  ///< cells of width h / 24
  static constexpr int cells_a_top = 80;        ///< of layers: at x = 0 of their uppermost, farther off of x
  static constexpr double default_range = 44;   ///< h

  /// Functions of the table. Those of an odd kernel are even, and the other way round; the table holds x >= 0.
  enum Function {
    Ryy,  ///< int_0^x s_yy, odd
    Rxx,  ///< int_0^x s_xx, odd
    Rxy,  ///< int_0^x s_xy, even
    base_sigma_by_y,
    base_tau_by_x,
    base_tau_by_y,
    base_sigma_by_x,
    integral_sigma_by_y,  ///< integrals of the base stresses from 0 to x
    integral_tau_by_x,
    integral_tau_by_y,
    integral_sigma_by_x,
    functions
  };

  /// [cells, 4 functions]: with q in [0, 1] from the left end of a cell, a function is c0 + q (c1 + q (c2 + q c3));
  /// its four coefficients stand side by side.
  using Coefficients = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// Returns the cells of a table of this range, in units of h, where the uppermost of layers is `top`; 0: one layer.
  static Eigen::Index cells_over(double range, double top = 0);

  /// 0 <= poisson <= 1/2; `range` in units of h.
  explicit LayerTable(double poisson, double range = default_range);

  /// Of layers or of one.
  explicit LayerTable(const Rubber& rubber, double range = default_range);

  /// Of coefficients as coefficients() returned them.
  LayerTable(double poisson, Coefficients coefficients, double top = 0);

  /// Returns sum of weights[k] tables[k], all of one range: the table of `poisson` between theirs.
  static LayerTable blend(double poisson, std::span<const LayerTable* const> tables, std::span<const double> weights);

  double poisson() const { return poisson_; }
  double top() const { return top_; }  ///< h, the uppermost of layers; 0: one layer
  Eigen::Index cells() const { return coefficients_.rows(); }

  const Coefficients& coefficients() const { return coefficients_; }

  /// Returns R at any x, in units of h. Beyond the range the layer does not move (its kernels fall like
  /// e^(-0.75 x)), which gives R in closed form.
  SmoothParts smooth_integral(double x) const;

  /// Return the base stresses at any x, in units of h, and their integrals from 0 to x; 1/mm times h.
  BaseStress base(double x) const;
  BaseStress base_integral(double x) const;

 private:
  LayerTable() = default;
  double value(Function function, double x) const;
  double end(Eigen::Index cell) const;  ///< left end, in units of h
  double range() const { return end(cells()); }
  template <class At>
  void add_cells(const At& at);

  double poisson_ = 0, top_ = 0;
  Coefficients coefficients_;
};

}  // namespace tactel::fem
