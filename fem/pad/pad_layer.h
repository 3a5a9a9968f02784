// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/pad_scene.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <compare>
#include <functional>
#include <vector>

#include "fem/pad/pad_integrals.h"
#include "fem/scenes/rubber.h"

namespace tactel::fem {

// Displacements and base stresses of the layer by a uniform traction of 1 MPa on a cell hx x hy of its surface, at the
// offset (x, y) = place less the cell's middle; E = 1 MPa. The half-space's part is the integral over the cell in
// closed form; with [F] = F(X1, Y1) - F(X0, Y1) - F(X1, Y0) + F(X0, Y0), X1, X0 = x +- hx / 2, Y alike, R^2 = X^2 + Y^2
//
//     I_xx = [Y asinh(X / |Y|)]    I_yy = [X asinh(Y / |X|)]    I_xy = -[R]
//     I_x  = [Y ln R + X atan(Y / X)]                           I_y  = [X ln R + Y atan(X / Y)]
//     zz = (1 - nu^2) / pi (I_xx + I_yy)
//     xx = (1 + nu) / pi (I_xx + (1 - nu) I_yy)     yy = (1 + nu) / pi ((1 - nu) I_xx + I_yy)    xy = (1 + nu) nu / pi
//     I_xy xz = (1 + nu) (1 - 2 nu) / (2 pi) I_x         yz with I_y
//
// (A. E. H. Love, Phil. Trans. R. Soc. A 228, 1929, 377-420; K. L. Johnson, Contact Mechanics, 1985, chapter 3). The
// smooth rest and the base stress are averaged over the cell by Gauss's rule.
//
// A cell wider than H hardly moves at its middle under a uniform pressure where nu is near 1/2: the rubber gives way at
// its edges only. Along sides above narrow_cell its traction therefore passes over to a smooth one, about the middle,
//
//     phi = 5/4 B(r) - 1/8 (B(r - 1) + B(r + 1)),    r over the side,  B: the quadratic B-spline of unit area
//
// which reproduces cubic pressures at the middles of equal cells (I. J. Schoenberg, Q. Appl. Math. 4, 1946, 45-99).

/// u_z by f_z, u_x by f_x, u_y by f_y, u_x by f_y and u_y by f_x, u_x by f_z (u_z by f_x is its negative), u_y by f_z;
/// mm per MPa over E.
struct CellInfluence {
  double zz = 0, xx = 0, yy = 0, xy = 0, xz = 0, yz = 0;
  CellInfluence& operator+=(const CellInfluence& other);
};

/// An object that gives way, too: an elastic half-space, whose surface faces the other way. Between it and the rubber
/// lies what both move: to each influence of the layer it adds the half-space's part above with its own Poisson's
/// ratio, times `softness`; xz and yz it subtracts (K. L. Johnson, Contact Mechanics, 1985, section 5.4).
struct SoftObject {
  double softness = 0;  ///< Young's modulus of the layer over its own; 0: rigid
  double poisson = 0;
  auto operator<=>(const SoftObject&) const = default;

  // Compliances of its half-space where that of E = 1 has 1 - nu^2 and (1 + nu) (2 - nu).
  double normal() const { return softness * (1 - poisson * poisson); }
  double tangential() const { return softness * (1 + poisson) * (2 - poisson); }
  /// What it adds to PadLayer::influence, and to PadLayer::influences.
  CellInfluence influence(double hx, double hy, double x, double y) const;
  std::vector<CellInfluence> influences(double thickness, double hx, double hy, int n) const;
};

/// Stress at the base, MPa per MPa: rows sigma_z, tau_x, tau_y; columns by f_x, f_y, f_z.
using PadBaseStress = Eigen::Matrix3d;

/// The layer of one Poisson's ratio, or layers upon layers: the integrals as piecewise cubics over rho.
class PadLayer {
 public:
  static constexpr int steps_a_thickness = 80;                  ///< cells of width H / 80
  static constexpr double range = 24;                           ///< H; beyond, one layer does not move
  static constexpr double largest_error = 1e-9;                 ///< of the four integrals of displacements
  static constexpr double least_parted = 0.35;                  ///< H
  static constexpr int most_parts = 16;                         ///< of a side
  static constexpr double narrow_cell = 0.78, wide_cell = 1.1;  ///< H: sides whose traction is uniform, and smooth

  /// Coefficients of one function in one cell: c0 + q (c1 + q (c2 + q c3)), q in [0, 1] from its left end.
  using Cubic = std::array<double, 4>;

  /// 0 <= poisson <= 1/2. Takes a tenth of a second: pad_layer (pad_layers.h) is faster.
  explicit PadLayer(double poisson);

  /// `samples`: of this Poisson's ratio at places().
  PadLayer(double poisson, const PadSamples& samples);

  /// Layers from the base up. Near rho = 0 cells are as wide as the uppermost layer / 80, farther off as rho / 80. The
  /// base stress is that on top of the first `below`.
  explicit PadLayer(const std::vector<RubberLayer>& layers, int below = 0);

  /// Returns the ends of the cells, H.
  static Eigen::VectorXd places();

  double poisson() const { return poisson_; }
  /// H: beyond, the rubber does not move. A stiff cover carries shear far.
  double reach() const { return reach_; }
  /// H: thickness of rubber as soft as the surface, in place of H where sides of cells are narrow or wide.
  double soft_thickness() const { return soft_thickness_; }
  /// H: how deep the base stress is taken.
  double deep() const { return deep_; }
  /// The object whose influence is added to that of the layer: none. The base stress has nothing of it.
  const SoftObject& object() const { return object_; }
  /// Returns this layer beside an object.
  PadLayer beside(const SoftObject& object) const;

  /// [cells][pad_integrals]
  const std::vector<std::array<Cubic, pad_integrals>>& cells() const { return cells_; }

  /// Returns the integrals z0, A, B, Z at any rho >= 0.
  Eigen::Array4d displacements(double rho) const;

  /// Returns the integrals b0, bA, bB, bxz, bzx at any rho >= 0.
  Eigen::Array<double, 5, 1> stresses(double rho) const;

  /// A part of a side of a cell: its middle from the cell's over the side, and its share of the cell's force.
  struct Share {
    double place, share;
  };
  /// Returns the parts, narrower than H / 2, of a side over H (over soft_thickness() of layers): one where the traction
  /// is uniform, else an odd number over each of the five sides that it covers.
  static std::vector<Share> shares(double side);

  /// Returns the influence of a cell of uniform traction at an offset that is a multiple of its sides; all in mm.
  CellInfluence influence(double thickness, double hx, double hy, double x, double y) const;

  /// Returns the influence of a cell of shares() for offsets of 0 to n cells, [n + 1][n + 1] along x and y.
  std::vector<CellInfluence> influences(double thickness, double hx, double hy, int n) const;

  /// Returns zz of influence() alone for offsets of 0 to n - 1 cells, [n][n] mm. Its smooth rest is that of the cell's
  /// middle; along sides above least_parted H the mean over parts of H / 2, two Gauss points each. Good to 3e-3 of the
  /// largest. Of layers upon layers it is zz of influences().
  Eigen::MatrixXd normal_influence(double thickness, double hx, double hy, int n) const;

  /// Returns the base stress under a cell of shares() of unit mean traction at any offset, mm.
  PadBaseStress base_stress(double thickness, double hx, double hy, double x, double y) const;

  /// The same of n x n cells, i along x, j along y, [i n + j], with (x, y) from the middle of the first. Wide cells
  /// share the parts that they are summed from.
  std::vector<PadBaseStress> base_stresses(double thickness, double hx, double hy, int n, double x, double y) const;

  /// What uniform parts do, by their sides and the offset from their middles.
  using OfPart = std::function<PadBaseStress(double hx, double hy, double x, double y)>;
  /// Returns what n x n cells of shares() do, by that of their parts as far as `reach`; sides of parts are by `unit`.
  static std::vector<PadBaseStress> of_cells(double hx, double hy, double unit, int n, double x, double y, double reach,
                                             const OfPart& of_part);

  /// Returns the number of uniform parts of a side, over H.
  static int parts(double side) { return side <= narrow_cell ? 1 : 2 * static_cast<int>(std::ceil(side - 1e-9)) + 1; }

 private:
  double value(PadIntegral f, double rho) const;
  double value_of_layers(PadIntegral f, double rho) const;
  void add_cells(const Eigen::VectorXd& ends, const PadSamples& samples);
  template <class F>
  void over_cell(double hx, double hy, double x, double y, double near, F f) const;
  CellInfluence with_rest(double thickness, double hx, double hy, double x, double y,
                          const Eigen::Array<double, 5, 1>& half_space) const;
  std::vector<CellInfluence> uniform_influences(double thickness, double hx, double hy, int nx, int ny) const;

  double poisson_, reach_ = range, soft_thickness_ = 1;
  double near_ = 0;             ///< H: the uppermost of layers
  double deep_ = 1;             ///< H: of the base, or where its stress is, below the surface
  std::vector<double> ends_{};  ///< of the cells of layers upon layers, H
  SoftObject object_;
  std::vector<std::array<Cubic, pad_integrals>> cells_;
};

}  // namespace tactel::fem
