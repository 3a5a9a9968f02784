// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <vector>

#include "fem/mesh/condensation.h"
#include "fem/numbers/cache_directory.h"
#include "fem/pad/pad_layer.h"
#include "fem/pad/pad_scene.h"

namespace tactel::fem {

/// Layers of any Poisson's ratio: their integrals are smooth in it, up to nu = 1/2. The polynomial through Chebyshev's
/// points over [0, 1/2] gives them (J.-P. Berrut, L. N. Trefethen, SIAM Review 46, 2004, 501-517). The samples at the
/// points take half a second; a file of the cache holds them.
class PadLayers {
 public:
  static constexpr int points = 18;  ///< leave 1e-10 of the integrals

  explicit PadLayers(const std::filesystem::path& cache_directory = default_cache_directory());

  /// 0 <= poisson <= 1/2.
  PadLayer layer(double poisson) const;

 private:
  std::vector<PadSamples> samples_;  ///< [points]
};

/// Numbers that are linear in the integrals are polynomials in Poisson's ratio, too: through these points they are
/// right to some 1e-7.
inline constexpr int poisson_points = 12;
double poisson_point(int k);
/// Returns the shares of the points at a Poisson's ratio; their sum is 1.
std::vector<double> poisson_shares(double poisson);

/// Returns how much farther an even traction shears the layers than as much of the uppermost; 1 without layers.
double softer_in_shear(const PadSensor& sensor);
/// Returns a layer of the PadLayers of this process; layers upon layers are made in a tenth of a second, and the last
/// few are kept.
PadLayer pad_layer(double poisson);
PadLayer pad_layer(const Rubber& rubber);

/// What an indenter is beside the rubber of a pad.
SoftObject soft_object(const PadSensor& sensor, const PadIndenter& indenter);
/// Returns the layer of a scene beside its object.
PadLayer pad_layer(const PadScene& scene);

}  // namespace tactel::fem
