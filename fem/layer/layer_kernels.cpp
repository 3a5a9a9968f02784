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
  for (const auto& [a, weight] : points_on_doubling_panels(first_panel, panel, last_wavenumber, points_a_panel))
    add(layer_transforms(poisson, a), a, weight);
}

LayerKernels::LayerKernels(std::span<const RubberLayer> layers, double farthest)
    : poisson_(layers.back().poisson), compressible_(1 - 2 * poisson_) {
  // The integrals of odd kernels have a mean over x, which no fading may take: so the waves that fade keep theirs.
  constexpr double first = 1e-7, last_phase = 19.2;  // of cosine and sine in a panel
  constexpr int points_of_faded = 48;
  double h = 0;
  for (const RubberLayer& layer : layers) h += layer.thickness;
  const double top = layers.back().thickness / h, fade = 200 / farthest;
  const double last = std::max(last_wavenumber, last_wavenumber / 2 / top);
  const bool fades = farthest > 1.5 * top;
  const auto share = [&](double a) { return fades ? std::exp(-std::pow(a / fade, 8)) : 1; };
  for (const auto& [a, weight] :
       points_on_doubling_panels(first, last_phase / farthest, std::min(last, 1.6 * fade), points_a_panel))
    add(stack_transforms(layers, a).plane, a, weight * share(a));
  const std::size_t count = wave_.size();
  if (fades)
    for (const auto& [a, weight] : points_on_doubling_panels(fade / 8, last, last, points_of_faded))
      add(stack_transforms(layers, a).plane, a, weight * (1 - share(a)));
  for (std::size_t k = count; k < wave_.size(); ++k) {
    faded_.smooth_integral.xy += wave_[k].smooth.xy / wave_[k].a;
    faded_.base_integral.tau_by_y += wave_[k].base.tau_by_y / wave_[k].a;
    faded_.base_integral.sigma_by_x += wave_[k].base.sigma_by_x / wave_[k].a;
  }
  wave_.resize(count);
}

/// A wavenumber with its transforms.
void LayerKernels::add(const LayerTransforms& t, double a, double weight) {
  const double falling = std::expm1(-a), smooth = weight / a, base = weight / pi;
  wave_.push_back({a,
                   {smooth * (t.yy + falling), smooth * (t.xx + falling), smooth * (t.xy + compressible_ * falling)},
                   {base * t.sigma_by_y, base * t.tau_by_x, -base * t.tau_by_y, -base * t.sigma_by_x}});
}

LayerKernelValues LayerKernels::at(double x) const {
  const double log = std::log1p(x * x) / 2, angle = std::atan(x), log_integral = x * log - x + angle;
  LayerKernelValues sum{{log, log, -compressible_ * angle},
                        {log_integral, log_integral, -compressible_ * (x * angle - log)},
                        {0, 0, 0, 0},
                        faded_.base_integral,
                        {0, 0, 0, 0}};
  sum.smooth_integral.xy += faded_.smooth_integral.xy;
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
