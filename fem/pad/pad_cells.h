// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <array>
#include <optional>

#include "fem/pad/pad_layer.h"
#include "fem/pad/pad_scene.h"

namespace tactel::fem {

/// n x n equal cells on the part of the surface that an indenter touches, in the indenter's own frame. Cell (i, j), i
/// along x, j along y, has index i ny() + j.
struct PadCells {
  int n = 0;
  double hx = 0, hy = 0;              ///< mm, sides of a cell
  double x_middle = 0, y_middle = 0;  ///< mm, of the grid
  bool round = false;          ///< only cells whose middles lie in the disc of n / 2 cells: below a sharp round edge
  std::array<bool, 4> edge{};  ///< sides -x, +x, -y, +y end at sharp edges of the indenter, or where the rubber ends
  // On a pad with free sides alone:
  double turn = 0;      ///< degrees: the frame of the cells, from the indenter's own
  bool shared = false;  ///< sharp edges of the indenter run through cells, which touch by the share that is covered
  // Of cells fixed to the pad alone:
  int along_y = 0;  ///< their number along y; 0: n, as along x

  int ny() const { return along_y > 0 ? along_y : n; }
  int count() const { return n * ny(); }
  double x(int i) const { return x_middle + (i - (n - 1) / 2.0) * hx; }
  double y(int j) const { return y_middle + (j - (ny() - 1) / 2.0) * hy; }
  /// Degrees: the frame of the cells on the pad.
  double frame(const PadIndenter& indenter) const { return indenter.yaw + turn; }
  double area() const { return hx * hy; }
  double half_size() const { return std::max(n * hx, ny() * hy) / 2; }  ///< mm: the lever of twists
  PadBox box() const {
    return {{x_middle - n * hx / 2, x_middle + n * hx / 2}, {y_middle - ny() * hy / 2, y_middle + ny() * hy / 2}};
  }
  bool allowed(int i, int j) const;  ///< the indenter may touch the cell; i and j from -1 to n
};

/// Part of a cell by which the grid reaches beyond a sharp edge. Pressure is singular there: with 0 the force of a
/// punch is 3 to 5 % low at 12 cells, with these 0.3 and 0.6 %.
inline constexpr double straight_overhang = 0.15, round_overhang = 0.125;
/// The same where influence is a mean over the cell, as on pads with free sides: 8 to 32 cells give the same force.
inline constexpr double straight_overhang_of_means = 0.09, round_overhang_of_means = 0.05;

/// Returns the range of sides of cells, mm, on which a contact of this depth is solved: at wider ones it is a plain to
/// the rubber, at narrower ones a needle.
inline Interval solvable_sides(double thickness, double depth) {
  return {std::min(1e-5 * thickness, 1e-3 * depth), 50 * thickness};
}
bool solvable(const PadCells& cells, double thickness, double depth);

/// Steps of the ladder of cell sizes in an octave.
inline constexpr int rungs_an_octave = 4;

/// Returns n x n cells over a contact, clipped to the indenter's edges. Along a side between sharp edges they reach
/// straight_overhang beyond; below a sharp round edge N of them have N h^2 = pi (radius + round_overhang h)^2. Other
/// sides are H 2^(k/4), the least that cover the contact, so that scenes share their influence; the k of both sides
/// differ by an even number. Without `ladder` they just cover it.
PadCells pad_cells(const PadBox& contact, const PadIndenter& indenter, int n, double thickness, bool ladder);

/// Returns n x n cells that just cover a contact on a pad with free sides. Nothing lies beyond `rubber`, in the frame
/// of the cells: they end there, and reach beyond a sharp edge only as far as it goes. Where `turn` (PadCells) is not
/// 0, or the rubber ends below a sharp punch, cells are shared.
PadCells pad_cells(const PadBox& contact, const PadIndenter& indenter, int n, const PadBox& rubber, double turn);

/// Part of each cell that lies below the indenter, [n + 2][n + 2] as the heights, by 16 x 16 points.
Eigen::MatrixXd covered_shares(const PadCells& cells, const PadIndenter& indenter);

/// Returns the compliance, mm for E = 1, that a cell of which this share is covered has beside the rubber's: with
///
///     g = 0.68 (1 / share - 1) / (1 + 0.07 / share) sqrt(h_x h_y) (1 - nu^2) / (1 - 0.48^2)
///
/// P below a box is right wherever its edges run (fitted on 8 to 24 cells, nu 0.3 to 0.4999).
double share_compliance(double share, const PadCells& cells, double poisson);

/// Returns the profile at the middles of the cells and of one ring around them, [n + 2][n + 2] mm, index (i + 1, j +
/// 1); +infinity where the indenter may not touch. Of a shared cell it is the mean over what is covered.
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
