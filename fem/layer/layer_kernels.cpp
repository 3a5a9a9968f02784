// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/layer_kernels.h"

#include <cmath>
#include <numbers>

#include "fem/layer/legendre_points.h"

namespace tactel::fem {
namespace {

constexpr double pi = std::numbers::pi;

// Wavenumbers beyond carry nothing: the integrands fall like a^2 e^-a.
constexpr double last_wavenumber = 52;
constexpr double panel = 0.25;
constexpr int points_a_panel = 16;
// Near nu = 1/2 the integrands change at a of sqrt(1 - 2 nu): panels double from here on.
constexpr double first_panel = 1e-4;

}  // namespace

double layer_cy(double poisson) { return 2 * (1 - poisson * poisson) / pi; }
double layer_cx(double poisson) { return (1 + poisson) / pi; }

LayerKernels::LayerKernels(double poisson) : poisson_(poisson), compressible_(1 - 2 * poisson) {
  for (const auto& [a, weight] : points_on_doubling_panels(first_panel, panel, last_wavenumber, points_a_panel)) {
    const double falling = std::expm1(-a), smooth = weight / a, base = weight / pi;
    const LayerTransforms t = layer_transforms(poisson, a);
    wave_.push_back({a,
                     {smooth * (t.yy + falling), smooth * (t.xx + falling), smooth * (t.xy + compressible_ * falling)},
                     {base * t.sigma_by_y, base * t.tau_by_x, -base * t.tau_by_y, -base * t.sigma_by_x}});
  }
}

LayerKernelValues LayerKernels::at(double x) const {
  const double log = std::log1p(x * x) / 2, angle = std::atan(x), log_integral = x * log - x + angle;
  LayerKernelValues sum{{log, log, -compressible_ * angle},
                        {log_integral, log_integral, -compressible_ * (x * angle - log)},
                        {0, 0, 0, 0},
                        {0, 0, 0, 0},
                        {0, 0, 0, 0}};
  for (const WaveNumber& w : wave_) {
    const double cosine = std::cos(w.a * x), sine = std::sin(w.a * x), half = std::sin(w.a * x / 2);
    const double even = sine / w.a, odd = 2 * half * half / w.a;  // integrals of cosine and sine
    sum.smooth.yy += w.smooth.yy * cosine;
    sum.smooth.xx += w.smooth.xx * cosine;
    sum.smooth.xy += w.smooth.xy * sine;
    sum.smooth_integral.yy += w.smooth.yy * even;
    sum.smooth_integral.xx += w.smooth.xx * even;
    sum.smooth_integral.xy += w.smooth.xy * odd;
    sum.base.sigma_by_y += w.base.sigma_by_y * cosine;
    sum.base.tau_by_x += w.base.tau_by_x * cosine;
    sum.base.tau_by_y += w.base.tau_by_y * sine;
    sum.base.sigma_by_x += w.base.sigma_by_x * sine;
    sum.base_integral.sigma_by_y += w.base.sigma_by_y * even;
    sum.base_integral.tau_by_x += w.base.tau_by_x * even;
    sum.base_integral.tau_by_y += w.base.tau_by_y * odd;
    sum.base_integral.sigma_by_x += w.base.sigma_by_x * odd;
    sum.base_slope.sigma_by_y -= w.a * w.base.sigma_by_y * sine;
    sum.base_slope.tau_by_x -= w.a * w.base.tau_by_x * sine;
    sum.base_slope.tau_by_y += w.a * w.base.tau_by_y * cosine;
    sum.base_slope.sigma_by_x += w.a * w.base.sigma_by_x * cosine;
  }
  return sum;
}

double LayerKernels::displacement_yy(double x) const { return layer_cy(poisson_) * (at(x).smooth.yy - std::log(x)); }
double LayerKernels::displacement_xx(double x) const { return layer_cy(poisson_) * (at(x).smooth.xx - std::log(x)); }
double LayerKernels::displacement_xy(double x) const {
  return layer_cx(poisson_) * ((1 - 2 * poisson_) * pi / 2 + at(x).smooth.xy);
}

}  // namespace tactel::fem
