// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <optional>

#include "fem/pad/pad_layer.h"
#include "fem/pad/pad_scene.h"

namespace tactel::fem {

/// The edge of a flat whose rounding, of radius R, is about as small as a cell. With E' = E / (1 - nu^2), the pressure
/// within the edge is E' strength / sqrt(s) at a distance s from it, as below a sharp one. That touches
///
///     reach = (3 pi R strength / 2)^(2/3)
///
/// of the rounding, and seen from afar it ends at 0.6 reach (plane strain near the edge; K. L. Johnson, Contact
/// Mechanics, 1985, section 5.3 and appendix).
struct PadRim {
  double strength = 0;    ///< mm^(1/2), where the flat lies as deep as on average; 0: the rounding counts as it is
  double depth = 0;       ///< mm, of the indenter
  double mean_depth = 0;  ///< mm, of the flat where it touches; less than depth where that is tilted

  /// The strength where the edge of the flat lies `height` above the indenter's lowest point.
  double at(double height) const {
    return strength > 0 ? strength * std::max(0.0, 2 * (depth - height) / mean_depth - 1) : 0;
  }
};

/// Where a rounded edge ends to a load far from it, in reaches.
inline constexpr double rim_end = 0.6;

/// A rounding that is touched over less than so many cells counts as a rim: along straight edges the cells are fitted
/// to it; round ones pass through cells anywhere.
inline constexpr double straight_rim = 3, round_rim = 0.5;

/// Returns how far a rounding of radius `edge` is touched, mm; `strength` as in PadRim.
double rim_reach(double strength, double edge);

/// Returns how far beyond the flat cells of side h should end for the right force, mm: straight_overhang where the
/// reach is far below h, and somewhat within the contact where cells resolve it.
double rim_outline(double reach, double h);

/// n x n equal cells on the part of the surface that an indenter touches, in the indenter's own frame. Cell (i, j), i
/// along x, j along y, has index i n + j.
struct PadCells {
  int n = 0;
  double hx = 0, hy = 0;              ///< mm, sides of a cell
  double x_middle = 0, y_middle = 0;  ///< mm, of the grid
  bool round = false;          ///< only cells whose middles lie in the disc of n / 2 cells: below a sharp round edge
  std::array<bool, 4> edge{};  ///< sides -x, +x, -y, +y end at sharp edges of the indenter
  PadRim rim{};                ///< below a flat with a rounding

  int count() const { return n * n; }
  double x(int i) const { return x_middle + (i - (n - 1) / 2.0) * hx; }
  double y(int j) const { return y_middle + (j - (n - 1) / 2.0) * hy; }
  double area() const { return hx * hy; }
  double half_size() const { return n * std::max(hx, hy) / 2; }  ///< mm: the lever that turns a twist into a path
  PadBox box() const {
    return {{x_middle - n * hx / 2, x_middle + n * hx / 2}, {y_middle - n * hy / 2, y_middle + n * hy / 2}};
  }
  bool allowed(int i, int j) const;  ///< the indenter may touch the cell; i and j from -1 to n
};

/// Part of a cell by which the grid reaches beyond a sharp edge. Pressure is singular there: with 0 the force of a
/// punch is 3 to 5 % low at 12 cells, with these 0.3 and 0.6 %.
inline constexpr double straight_overhang = 0.15, round_overhang = 0.125;

/// Steps of the ladder of cell sizes in an octave.
inline constexpr int rungs_an_octave = 4;

/// Returns n x n cells over a contact, clipped to the indenter's edges. Along a side between sharp edges they reach
/// straight_overhang beyond; below a sharp round edge N of them have N h^2 = pi (radius + round_overhang h)^2. Other
/// sides are H 2^(k/4), the least that cover the contact, so that scenes share their influence; the k of both sides
/// differ by an even number. Without `ladder` they just cover it.
PadCells pad_cells(const PadBox& contact, const PadIndenter& indenter, int n, double thickness, bool ladder);

/// Returns the profile at the middles of the cells and of one ring around them, [n + 2][n + 2] mm, index (i + 1, j +
/// 1); +infinity where the indenter may not touch. Beside a rim with its outline u cells within the far side of a cell,
/// that counts as part of the indenter from u = 0.5 on. Up to u = 1.5 it lies (1 - u) pi strength sqrt(h) higher, which
/// leaves the force what it were if cells ended at the outline: the energy of what is added or lacks, pi E' strength^2
/// an area, over the cell's share of the force.
Eigen::MatrixXd cell_heights(const PadCells& cells, const PadIndenter& indenter);

/// The influence of cells on each other, for E = 1: six planes [2 n + 1][2 n + 1] over source less place, -n to n. The
/// entry of a source at (jx, jy) on a place at (ix, iy) is at(jx - ix, jy - iy): sources of one jx lie side by side.
struct PadInfluence {
  PadInfluence(const PadLayer& layer, double thickness, double hx, double hy, int n);

  Eigen::Index at(int dx, int dy) const { return (dx + n) * (2 * n + 1) + dy + n; }

  int n;
  Eigen::ArrayXd zz, xx, yy, xy, xz, yz;
  double own_normal, own_tangential;  ///< zz and the larger of xx and yy of a cell on itself
};

}  // namespace tactel::fem
