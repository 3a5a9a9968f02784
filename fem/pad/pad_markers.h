// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "fem/pad/pad_cells.h"
#include "fem/pad/pad_scene.h"
#include "fem/pad/pad_solver.h"

namespace tactel::fem {

// Displacement at any depth of a layer of thickness H, bonded to a rigid base at z = 0, by tractions on its surface.
// With a = |k| H, s = a z / H, d = a - s, K = 3 - 4 nu and
//
//     D = 2 (K cosh^2 a + a^2 + (1 - 2 nu)^2)
//     W = p (K sinh s - s cosh s) - q s sinh s       U = -[p s sinh s + q (K sinh s + s cosh s)]
//     f_z = 1:  p = [2 (1 - nu) cosh a + a sinh a] / D        q = [(1 - 2 nu) sinh a - a cosh a] / D
//     f_x = 1:  p = -[(1 - 2 nu) sinh a + a cosh a] / D       q = -[2 (1 - nu) cosh a - a sinh a] / D
//     across the wave: sinh s / cosh a
//
// u_z = W / (G k) and u_k = i U / (G k) are the transforms; of a half-space at depth d, times e^d,
//
//     W by f_z: 1 - nu + d / 2    U by f_z: -(1 - 2 nu - d) / 2    W by f_x: -(1 - 2 nu + d) / 2
//     U by f_x: 1 - nu - d / 2    across: 1
//
// The half-space's part is summed over the corners of a cell in closed form (Boussinesq, Cerruti; K. L. Johnson,
// Contact Mechanics, 1985, chapter 3), the rest, smooth over H + z, comes from Hankel transforms as in pad_integrals.h.

/// The layer at one depth; lengths over H, E = 1.
class LayerAtDepth {
 public:
  /// 0 <= poisson <= 1/2, 0 <= depth < 1; displacements are asked for no farther than `farthest` from a cell.
  /// `between` is called often and may throw, which ends it.
  LayerAtDepth(
      double poisson, double depth, double farthest, const std::function<void()>& between = [] {});

  /// Returns the displacements x, y, z (rows) by unit tractions x, y, z (columns) on a cell, at an offset from its
  /// middle. z points up.
  Eigen::Matrix3d displacement(double hx, double hy, double x, double y) const;

 private:
  enum { zz, xz, zx, A, B, parts };
  using Rest = Eigen::Array<double, parts, 1>;
  Rest rest(double rho) const;

  double poisson_, depth_;
  std::vector<Rest> value_, slope_;  ///< at steps of rho
};

/// Returns the places of markers on the pad, mm, x fastest.
std::vector<std::array<double, 2>> marker_places(const Markers& markers);

std::size_t marker_count(const std::optional<Markers>& markers);

/// Throws ValueError, key "markers.<member>" or "camera.<member>".
void validate(const Markers& markers, const PadSensor& sensor);
void validate(const Camera& camera);

/// Returns the displacements of markers, rows x, y, z of each, mm, in the frame of the pad, by tractions of 1 MPa on
/// cells in the same frame, columns [3 cells]: n (which presses), t_x, t_y. `between` is called for every marker and
/// may throw, which ends it.
Eigen::MatrixXd marker_rows(
    const Markers& markers, const PadScene& scene, const PadCells& cells, const std::function<void()>& between = [] {});

/// Returns where a camera sees markers that are displaced, pixels, [markers]. What lies nearer to the pinhole by -u_z
/// is seen so much farther out: first order in u, as all of the mechanics.
Eigen::MatrixX2d pixels_of(const Camera& camera, const Markers& markers, const Eigen::MatrixX3d& displacements);

/// Puts displacements of markers, and pixels, into the steps of a solution, where the scene has them. `between` as in
/// marker_rows.
void see_markers(
    const PadScene& scene, PadSolution& solution, const std::function<void()>& between = [] {});

}  // namespace tactel::fem
