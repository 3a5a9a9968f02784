// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_layers.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "fem/numbers/array_cache.h"
#include "fem/numbers/last_used.h"
#include "fem/numbers/processor.h"

namespace tactel::fem {
namespace {

double point(int k, int points = PadLayers::points) {
  return 0.25 * (1 - std::cos(std::numbers::pi * k / (points - 1)));
}

/// Where a ratio lies so near a point that a weight could overflow.
bool at_point(double from) { return std::abs(from) < 1e-290; }

}  // namespace

PadLayers::PadLayers(const std::filesystem::path& cache_directory) {
  const Eigen::VectorXd places = PadLayer::places();
  samples_.assign(points, PadSamples(2 * pad_integrals, places.size()));
  const CacheFile file = cache_file(cache_directory, "pad", "tables",
                                    "tactel pad\nbuild " TACTEL_PAD_FINGERPRINT "\nprocessor " + processor_text());
  const auto arrays = [&]<class Span>(std::vector<Span> all) {
    for (PadSamples& of : samples_) all.emplace_back(of.data(), static_cast<std::size_t>(of.size()));
    return all;
  };
  if (read_arrays(file, arrays(std::vector<std::span<double>>()))) return;
  std::vector<PadIntegrals> integrals;
  integrals.reserve(points);
  for (int k = 0; k < points; ++k) integrals.emplace_back(point(k));
  samples_ = PadIntegrals::sampled(integrals, places);
  write_arrays(file, arrays(std::vector<std::span<const double>>()));
}

PadLayer PadLayers::layer(double poisson) const {
  PadSamples sum = PadSamples::Zero(2 * pad_integrals, samples_.front().cols());
  double weights = 0;
  for (int k = 0; k < points; ++k) {
    const double from = poisson - point(k);
    if (at_point(from)) return {poisson, samples_[static_cast<std::size_t>(k)]};
    const double weight = (k % 2 ? -1 : 1) * (k == 0 || k == points - 1 ? 0.5 : 1) / from;
    sum += weight * samples_[static_cast<std::size_t>(k)];
    weights += weight;
  }
  return {poisson, sum / weights};
}

double poisson_point(int k) { return point(k, poisson_points); }

std::vector<double> poisson_shares(double poisson) {
  std::vector<double> shares(poisson_points, 0);
  double sum = 0;
  for (int k = 0; k < poisson_points; ++k) {
    const double from = poisson - poisson_point(k);
    if (at_point(from)) {
      shares.assign(poisson_points, 0);
      shares[static_cast<std::size_t>(k)] = 1;
      return shares;
    }
    sum += shares[static_cast<std::size_t>(k)] =
        (k % 2 ? -1 : 1) * (k == 0 || k == poisson_points - 1 ? 0.5 : 1) / from;
  }
  for (double& share : shares) share /= sum;
  return shares;
}

PadLayer pad_layer(double poisson) {
  static const PadLayers layers;
  return layers.layer(poisson);
}

SoftObject soft_object(const PadSensor& sensor, const PadIndenter& indenter) {
  return indenter.young ? SoftObject{sensor.young / *indenter.young, indenter.poisson} : SoftObject{};
}

double softer_in_shear(const PadSensor& sensor) {
  if (sensor.layers.empty()) return 1;
  double sheared = 0;
  for (const auto& [thickness, young, poisson] : sensor.layers) sheared += thickness * (1 + poisson) / young;
  return sheared * sensor.young / (sensor.thickness * (1 + sensor.poisson));
}

PadLayer pad_layer(const Rubber& rubber) {
  if (rubber.layers.empty()) return pad_layer(rubber.poisson);
  static LastUsed<Rubber, PadLayer> kept(8);
  return kept.get(rubber, [&] { return PadLayer(rubber.layers, rubber.below); });
}

PadLayer pad_layer(const PadScene& scene) {
  return pad_layer(rubber(scene.sensor)).beside(soft_object(scene.sensor, scene.indenter));
}

}  // namespace tactel::fem
