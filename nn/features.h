// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "nn/network.h"

namespace tactel::nn {

/// The fixed layer of networks with features; kernels/shared/features.h is its twin, operation by operation.
///
/// x: [scaling.inputs(numbers)], which begins with scaled frames [shown], the newest first: of each the normal stresses
/// of its tactels, x fastest, then those along x, then of a pad those along y. `peak`: the newest frame's largest
/// |normal stress|, MPa. On return x holds
///
/// - the frames' image, [frames][axes][tactels]: mirrored so that the newest frame's Q points to +x (of a pad to +x and
///   +y, and closer to x than to y where it is square). The contact of a mirrored frame has the mirrored forces, so all
///   images of an input have one answer;
/// - the sums of each frame, [frames][sums]: with pressures p = -normal stress, shear t, places x from the middle in
///   tactels, P = sum p, Q = sum t, T = sum |t|, the centre c of the pressures and d = x - c
///
///       P, Qx, Qy, |Q| / P, Qx / P, Qy / P, M / P about c, cx, cy, second moments of p / P: dx dx, dy dy, dx dy,
///       T / P, second moments of |t| / T: dx dx, dy dy, sum of t along Q times dx and dy
///
///   Of a line: P, Q, Q / P, c, second moment of p / P, T / P, that of |t| / T, sum t d. Divisors are at least 0.2;
/// - peak / (peak + usual_stress), but not of ScalingKind::rest.
///
/// The last one alone depends on E and on a common factor of all stresses. Of `rest` the frames are differences to it:
/// P and Q above are their changes.
template <class Real>
void add_features(const InputScaling& scaling, int numbers, Real peak, Real* x) noexcept;

/// Puts into x the differences of an input's finite frames, [numbers], to its last one, the rest, over the rest's P,
/// and their features; as kernels/forward.cl does. Returns false, and leaves x, where the rest has no P.
template <class Real>
bool take_differences_to_rest(const InputScaling& scaling, int numbers, const float* frames, Real* x) noexcept;

inline constexpr float least_divisor = 0.2f, usual_friction = 0.5f, usual_spread = 0.1f;

/// Puts what is told of friction, mu and its relative deviation, into two inputs: mu / (mu + usual_friction) and
/// spread / (spread + usual_spread), the logistic functions of their logarithms; 1/2 and 1 where mu is not above 0: it
/// is not told.
template <class Real>
void tell_friction(Real mu, Real spread, Real* x) noexcept {
  x[0] = mu > 0 ? mu / (mu + Real(usual_friction)) : Real(0.5f);
  x[1] = mu > 0 ? spread / (spread + Real(usual_spread)) : Real(1);
}

extern template void add_features(const InputScaling&, int, float, float*) noexcept;
extern template void add_features(const InputScaling&, int, double, double*) noexcept;
extern template bool take_differences_to_rest(const InputScaling&, int, const float*, float*) noexcept;
extern template bool take_differences_to_rest(const InputScaling&, int, const float*, double*) noexcept;

}  // namespace tactel::nn
