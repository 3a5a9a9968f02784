// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_integrals.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "fem/layer/layer_transforms.h"
#include "fem/layer/legendre_points.h"
#include "fem/pad/bessel.h"
#include "fem/scenes/rubber.h"

namespace tactel::fem {
namespace {

// Wavenumbers beyond carry nothing: the integrands fall like a^2 e^-a at the base, like e^-2a at the surface.
constexpr double last_wavenumber = 48;
constexpr double panel = 0.8;
constexpr double last_panel_phase = 19.2;  ///< of the Bessel functions in a panel
constexpr int points_a_panel = 16;
// Near nu = 1/2 the integrands change at a of sqrt(1 - 2 nu): panels double from here on.
constexpr double first_panel = 1e-5;

constexpr int order[pad_integrals] = {0, 0, 2, 1, 0, 0, 2, 1, 1};

}  // namespace

PadIntegrals::PadIntegrals(double poisson) {
  const auto points = points_on_doubling_panels(first_panel, panel, last_wavenumber, points_a_panel);
  weight_.resize(pad_integrals, static_cast<Eigen::Index>(points.size()));
  for (const auto& [a, weight] : points)
    add(poisson, layer_transforms(poisson, a), -2 / (std::exp(2 * a) + 1), 1 / std::cosh(a), a, weight);
}

PadIntegrals::PadIntegrals(std::span<const RubberLayer> layers, double farthest, int below) {
  constexpr double first = 1e-7, fades = 100;
  double H = 0;
  for (const RubberLayer& layer : layers) H += layer.thickness;
  const double top = layers.back().thickness / H, fade = 2 * fades / farthest;
  const double last = std::max(last_wavenumber / height_above(layers, below), last_wavenumber / 2 / top);
  const auto points =
      points_on_doubling_panels(first, last_panel_phase / farthest, std::min(last, 1.6 * fade), points_a_panel);
  weight_.resize(pad_integrals, static_cast<Eigen::Index>(points.size()));
  for (const auto& [a, weight] : points) {
    const StackTransforms t = stack_transforms(layers, a, below);
    add(layers.back().poisson, t.plane, t.across - 1, t.across_base, a,
        farthest > top ? weight * std::exp(-std::pow(a / fade, 8)) : weight);
  }
}

/// A wavenumber with its transforms; `across` is less that of the half-space, 1.
void PadIntegrals::add(double nu, const LayerTransforms& t, double across, double base, double a, double weight) {
  const double along = (1 - nu) * (t.xx - 1);
  PadValues w;
  w << t.yy - 1, along + across, along - across, t.xy - (1 - 2 * nu), a * t.sigma_by_y, a * (t.tau_by_x + base) / 2,
      a * (t.tau_by_x - base) / 2, a * t.tau_by_y, a * t.sigma_by_x;
  weight_.col(static_cast<Eigen::Index>(a_.size())) = weight * w;
  a_.push_back(a);
}

PadIntegrals::At PadIntegrals::at(double rho) const {
  At sum{PadValues::Zero(), PadValues::Zero()};
  for (std::size_t w = 0; w < a_.size(); ++w) {
    const Bessel J(a_[w] * rho);
    for (int f = 0; f < pad_integrals; ++f) {
      const double weight = weight_(f, static_cast<Eigen::Index>(w));
      sum.value[f] += weight * J.value[order[f]];
      sum.slope[f] += weight * a_[w] * J.slope[order[f]];
    }
  }
  return sum;
}

std::vector<PadSamples> PadIntegrals::sampled(std::span<const PadIntegrals> of, const Eigen::VectorXd& rho) {
  constexpr Eigen::Index most_together = 32;
  const std::vector<double>& a = of.front().a_;
  const auto waves = static_cast<Eigen::Index>(a.size());
  std::vector<PadSamples> samples(of.size(), PadSamples(2 * pad_integrals, rho.size()));
  for (Eigen::Index first = 0; first < rho.size(); first += most_together) {
    const Eigen::Index count = std::min(most_together, rho.size() - first);
    std::array<Eigen::MatrixXd, 3> value, slope;  // by order, [waves][rho]
    for (int k = 0; k < 3; ++k) value[k].resize(waves, count), slope[k].resize(waves, count);
    for (Eigen::Index c = 0; c < count; ++c)
      for (Eigen::Index w = 0; w < waves; ++w) {
        const double wave = a[static_cast<std::size_t>(w)];
        const Bessel J(wave * rho[first + c]);
        for (int k = 0; k < 3; ++k) value[k](w, c) = J.value[k], slope[k](w, c) = wave * J.slope[k];
      }
    for (std::size_t k = 0; k < of.size(); ++k)
      for (int f = 0; f < pad_integrals; ++f) {
        samples[k].row(f).segment(first, count).noalias() = of[k].weight_.row(f) * value[order[f]];
        samples[k].row(pad_integrals + f).segment(first, count).noalias() = of[k].weight_.row(f) * slope[order[f]];
      }
  }
  return samples;
}

}  // namespace tactel::fem
