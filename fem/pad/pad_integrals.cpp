// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_integrals.h"

#include <cmath>

#include "fem/layer/layer_transforms.h"
#include "fem/layer/legendre_points.h"

namespace tactel::fem {
namespace {

// Wavenumbers beyond carry nothing: the integrands fall like a^2 e^-a at the base, like e^-2a at the surface.
constexpr double last_wavenumber = 48;
constexpr double panel = 0.8;
constexpr int points_a_panel = 16;
// Near nu = 1/2 the integrands change at a of sqrt(1 - 2 nu): panels double from here on.
constexpr double first_panel = 1e-5;

/// J0, J1, J2 and their slopes.
struct Bessel {
  explicit Bessel(double x) {
    value[0] = ::j0(x);
    value[1] = ::j1(x);
    const double half = x / 2, q = half * half;
    const double J1_by_x = x < 1e-8 ? 0.5 : value[1] / x;
    // The recurrence cancels where x is small; there the series has six terms at most.
    double J2_by_x = x < 1 ? x / 8 * (1 - q / 3 * (1 - q / 8 * (1 - q / 15 * (1 - q / 24 * (1 - q / 35)))))
                           : (2 * J1_by_x - value[0]) / x;
    value[2] = J2_by_x * x;
    slope[0] = -value[1];
    slope[1] = value[0] - J1_by_x;
    slope[2] = value[1] - 2 * J2_by_x;
  }
  double value[3], slope[3];
};

constexpr int order[pad_integrals] = {0, 0, 2, 1, 0, 0, 2, 1, 1};

}  // namespace

PadIntegrals::PadIntegrals(double poisson) {
  for (const auto& [a, weight] : points_on_doubling_panels(first_panel, panel, last_wavenumber, points_a_panel)) {
    const LayerTransforms t = layer_transforms(poisson, a);
    const double along = (1 - poisson) * (t.xx - 1), across = -2 / (std::exp(2 * a) + 1);  // tanh a - 1
    const double base = 1 / std::cosh(a);
    WaveNumber w{a, {}};
    w.weight << t.yy - 1, along + across, along - across, t.xy - (1 - 2 * poisson), a * t.sigma_by_y,
        a * (t.tau_by_x + base) / 2, a * (t.tau_by_x - base) / 2, a * t.tau_by_y, a * t.sigma_by_x;
    w.weight *= weight;
    wave_.push_back(w);
  }
}

PadIntegrals::At PadIntegrals::at(double rho) const {
  At sum{PadValues::Zero(), PadValues::Zero()};
  for (const WaveNumber& w : wave_) {
    const Bessel J(w.a * rho);
    for (int f = 0; f < pad_integrals; ++f) {
      sum.value[f] += w.weight[f] * J.value[order[f]];
      sum.slope[f] += w.weight[f] * w.a * J.slope[order[f]];
    }
  }
  return sum;
}

}  // namespace tactel::fem
