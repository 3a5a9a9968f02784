// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <vector>

#include "fem/layer/layer_transforms.h"

namespace tactel::fem {

// Displacement of the surface and stress at the base, at x to the right of a unit line force (1 N/mm) on the
// surface, from the transforms of layer_transforms.h. Lengths are in units of the thickness h, E = 1 MPa.
//
//     u_y by f_y   G_yy(x) = cy (-ln|x| + s_yy(x)),                      cy = 2 (1 - nu^2) / pi
//     u_x by f_x   G_xx(x) = cy (-ln|x| + s_xx(x))
//     u_x by f_y   G_xy(x) = cx ((1 - 2 nu) (pi/2) sgn x + s_xy(x)),     cx = (1 + nu) / pi
//     u_y by f_x   G_yx = -G_xy
//
// The singular part is the half-plane's; s is smooth. s_yy and s_xx are even in x, s_xy is odd:
//
//     s_yy = ln(1 + x^2) / 2 + int_0^inf (yy - 1 + e^-a) cos(a x) da / a              s_xx with xx
//     s_xy = -(1 - 2 nu) atan x + int_0^inf (xy - (1 - 2 nu) (1 - e^-a)) sin(a x) da / a
//
// Base stress, 1/mm times h:
//
//     sigma_y by f_y   (1/pi) int_0^inf sigma_by_y cos(a x) da           tau_xy by f_x with tau_by_x      (even)
//     tau_xy by f_y   -(1/pi) int_0^inf tau_by_y sin(a x) da             sigma_y by f_x with sigma_by_x   (odd)
//
// Layers upon layers have stack_transforms, and h is their sum, nu and E = 1 MPa are those of the uppermost.

/// One number for each of the smooth parts.
struct SmoothParts {
  double yy, xx, xy;
};

/// One number for each of the base stresses.
struct BaseStress {
  double sigma_by_y, tau_by_x, tau_by_y, sigma_by_x;
};

/// All kernels at one place, their integrals from 0 to there, and the slopes of the base stresses.
struct LayerKernelValues {
  SmoothParts smooth, smooth_integral;  ///< s, and R(x) = int_0^x s
  BaseStress base, base_integral, base_slope;
};

/// The kernels of one Poisson's ratio, or of layers upon layers, by Gauss quadrature over wavenumbers.
class LayerKernels {
 public:
  /// 0 <= poisson <= 1/2.
  explicit LayerKernels(double poisson);

  /// Of layers from the base up, for x from a half to the whole of `farthest`, in units of h, or from 0 where that is
  /// the uppermost layer. Waves beyond 100 / x leave what is smooth there as it is: they fade out.
  LayerKernels(std::span<const RubberLayer> layers, double farthest);

  /// Returns the kernels at x >= 0, in units of h. They hold to some 1e-11 for x up to 100.
  LayerKernelValues at(double x) const;

  /// Return G at x > 0, in units of h.
  double displacement_yy(double x) const;
  double displacement_xx(double x) const;
  double displacement_xy(double x) const;

 private:
  /// One point of the quadrature: a, and weight times the integrands without their cosine or sine.
  struct WaveNumber {
    double a;
    SmoothParts smooth;  ///< divided by a
    BaseStress base;
  };

  void add(const LayerTransforms& t, double a, double weight);

  double poisson_, compressible_;  ///< nu, 1 - 2 nu
  std::vector<WaveNumber> wave_;
  LayerKernelValues faded_{};  ///< of waves that fade out: the mean of their integrals
};

/// Factors of the kernels above.
double layer_cy(double poisson);
double layer_cx(double poisson);

}  // namespace tactel::fem
