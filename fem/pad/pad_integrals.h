// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <span>
#include <vector>

#include "fem/layer/layer_transforms.h"

namespace tactel::fem {

// A layer of thickness H, bonded to a rigid base at z = 0, endless along x and y: displacement of its surface and
// stress at its base under a point force (f_x, f_y, f_z) on the surface. Along a wave vector k the layer is in plane
// strain, across it in antiplane shear. With a = |k| H and the transforms of fem/layer/layer_transforms.h,
//
//     along:   yy, xx, xy of u_z by f_z, u_k by f_k, u_k by f_z       across:   tanh a  of u,  1 / cosh a  of the base
//     stress
//
// (u = sinh k z / (G k cosh k H) across), Hankel transforms turn them back. Lengths are in units of H, rho the
// distance and th the angle from the force to the place, E = 1 MPa. Displacement, each the half-space's closed form
// (Boussinesq, Cerruti) and a smooth rest:
//
//     u_z by f_z    (1 - nu^2) / pi (1 / rho + z0)
//     u_x by f_x    (1 + nu) / (pi rho) (1 - nu + nu cos^2 th) + (1 + nu) / (2 pi) (A - B cos 2th);    y: sin^2, + B
//     u_x by f_y    (1 + nu) nu / (pi rho) sin th cos th - (1 + nu) / (2 pi) B sin 2th                 and u_y by f_x
//     u_x by f_z    (1 + nu) / (2 pi) cos th ((1 - 2 nu) / rho + Z);   u_z by f_x its negative;        y: sin th
//
//     z0 = int (yy - 1) J0(a rho) da                    A = int ((1 - nu) (xx - 1) + (tanh a - 1)) J0 da
//     Z  = int (xy - (1 - 2 nu)) J1 da                  B = int ((1 - nu) (xx - 1) - (tanh a - 1)) J2 da
//
// Stress that the rubber transmits to the base, times 2 pi:
//
//     sigma_z by f_z   b0              sigma_z by f_x  -cos th bzx        tau_x by f_z  -cos th bxz    y: sin th
//     tau_x by f_x     bA - bB cos 2th        tau_y by f_y  bA + bB cos 2th        tau_x by f_y, tau_y by f_x  -bB sin
//     2th
//
//     b0  = int a sigma_by_y J0       bA = int a (tau_by_x + 1 / cosh a) / 2 J0      bzx = int a sigma_by_x J1
//     bxz = int a tau_by_y J1         bB = int a (tau_by_x - 1 / cosh a) / 2 J2
//
// Layers upon layers have stack_transforms, and 1 - nu, 1 + nu and E = 1 are those of the uppermost. The stress may be
// that on top of some of them, in place of the base.
//
// Derived from the layer's transforms with the angular integrals of J0, J1, J2; as H grows z0, A, B and Z vanish. All
// hold at nu = 1/2. Far away displacements and stresses fall like exp(-0.739 rho) or faster.

/// The nine integrals; the first four belong to displacements.
enum PadIntegral { pad_z0, pad_A, pad_B, pad_Z, pad_b0, pad_bA, pad_bB, pad_bxz, pad_bzx, pad_integrals };

using PadValues = Eigen::Array<double, pad_integrals, 1>;

/// The integrals at some rho, then their slopes by rho: [2 pad_integrals][rho].
using PadSamples = Eigen::Matrix<double, 2 * pad_integrals, Eigen::Dynamic>;

/// The integrals of a rubber, by Gauss quadrature over wavenumbers: the reference of PadLayer's tables.
class PadIntegrals {
 public:
  struct At {
    PadValues value, slope;  ///< slope: by rho
  };

  /// 0 <= poisson <= 1/2.
  explicit PadIntegrals(double poisson);

  /// Of layers from the base up, for rho from a half to the whole of `farthest`, or from 0 where that is the uppermost
  /// layer over H. Waves beyond 100 / rho leave the smooth integrals there as they are: they fade out.
  PadIntegrals(std::span<const RubberLayer> layers, double farthest, int below = 0);

  /// Returns the integrals and their slopes at rho >= 0. They hold to some 1e-13 for rho up to 24.
  At at(double rho) const;

  /// Returns the samples of several Poisson's ratios, which share the Bessel functions: these take most of the time.
  static std::vector<PadSamples> sampled(std::span<const PadIntegrals> of, const Eigen::VectorXd& rho);

 private:
  void add(double nu, const LayerTransforms& t, double across, double base, double a, double weight);

  std::vector<double> a_;  ///< wavenumbers, the same for all Poisson's ratios
  /// [integrals][wavenumbers]: of the quadrature times the integrands without their Bessel functions.
  Eigen::Matrix<double, pad_integrals, Eigen::Dynamic> weight_;
};

}  // namespace tactel::fem
