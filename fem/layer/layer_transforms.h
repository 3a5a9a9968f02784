// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/rubber_layer.h>

#include <span>

namespace tactel::fem {

// An elastic layer of thickness h, bonded to a rigid base at y = 0, infinite along x, in plane strain. The force
// per area on its surface is f e^(iwx): f_y up, f_x to the right, on the rubber. So are all answers. Symbols:
//
//     a = |w| h,   k = 3 - 4 nu,   D = k cosh 2a + 2 a^2 + 1 + 4 (1 - nu) (1 - 2 nu),   p = 4 (1 - nu)
//
// Surface displacement over f, mm per MPa (E in MPa):
//     u_y by f_y   2 (1 - nu^2) / (E |w|) yy             yy = (k sinh 2a - 2a) / D
//     u_x by f_x   2 (1 - nu^2) / (E |w|) xx             xx = (k sinh 2a + 2a) / D
//     u_x by f_y   -i sgn(w) (1 + nu) / (E |w|) xy       xy = ((1 - 2 nu) k (cosh 2a - 1) - 2 a^2) / D
//     u_y by f_x   the negative of u_x by f_y
// Stress at the base over f, without unit and without E:
//     sigma_y by f_y             sigma_by_y              p (2 (1 - nu) cosh a + a sinh a) / D
//     tau_xy by f_x              tau_by_x                p (2 (1 - nu) cosh a - a sinh a) / D
//     tau_xy by f_y              i sgn(w) tau_by_y       p (a cosh a - (1 - 2 nu) sinh a) / D
//     sigma_y by f_x             i sgn(w) sigma_by_x     p (a cosh a + (1 - 2 nu) sinh a) / D
//
// Source: solution of the plane strain equations in exponentials (Papkovich and Neuber) with u = 0 at the base;
// K. L. Johnson, Contact Mechanics (1985), section 5.8 has the layer's normal part. As h grows yy and xx go to 1
// and xy to 1 - 2 nu: the half-plane. The formulas hold at nu = 1/2.

/// The layer's answer to one wavenumber, all without unit; the factors are above.
struct LayerTransforms {
  double yy, xx, xy;                                  ///< surface displacement
  double sigma_by_y, tau_by_x, tau_by_y, sigma_by_x;  ///< base stress
};

/// Returns the transforms at a = |w| h >= 0 for 0 <= poisson <= 1/2. Numerators and D are divided by exp(2a), so
/// that nothing overflows.
LayerTransforms layer_transforms(double poisson, double a);

// Layers upon layers. With f_y = i F, u_y = i V all of a wave is real: u = Y f of the surface and s = B f of the base
// have, for one layer of shear modulus G on a rigid base,
//
//     Y = [2 (1 - nu) xx, xy; xy, 2 (1 - nu) yy] / (2 G |w|)          B = [tau_by_x, -tau_by_y; sigma_by_x, sigma_by_y]
//
// and where the base moves by v below a free surface, u = B^T v (Betti) and s = -S v,
//
//     S = 2 G |w| / D [p (sinh 2a + 2a) / 2, q; q, p (sinh 2a - 2a) / 2]       q = (1 - 2 nu) (cosh 2a - 1) + 2 a^2
//
// On layers of Y' and B', whose surface is its base, v = Y' s: with X = (1 + S Y')^-1 B the stack has Y + B^T Y' X and
// B' X. No term grows with a (E. L. Tan, J. Acoust. Soc. Am. 119, 2006, 45-53, has such recursions). Across the wave
// the same holds of numbers, Y = tanh a / (G |w|), B = 1 / cosh a, S = G |w| tanh a.

/// The answer of layers in place of one, by the modulus and Poisson's ratio of the uppermost.
struct StackTransforms {
  LayerTransforms plane;
  double across, across_base;  ///< tanh a and 1 / cosh a of one layer
};

/// Returns the transforms of layers from the base up, at least one, at a = |w| times the sum of their thicknesses. The
/// stress is that on top of the first `below` layers: the product B begins there.
StackTransforms stack_transforms(std::span<const RubberLayer> layers, double a, int below = 0);

}  // namespace tactel::fem
