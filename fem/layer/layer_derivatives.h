// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>

#include "fem/layer/layer_model.h"
#include "fem/layer/patch.h"

namespace tactel::fem {

/// A change of the rubber under a patch, by a parameter p: of Condensation::compliance [2 elements, 2 elements] and
/// tactel_stress [2 tactels, 2 elements], over the unit of p.
struct RubberChange {
  Eigen::MatrixXd compliance, tactel_stress;
};

/// Derivatives of patch_condensation by Poisson's ratio and thickness, the elements held in place, and by the place and
/// size of the patch. Those of the layer are exact: the transforms' derivatives by nu, and its scaling, C depending on
/// width / h alone. What the free sides change comes from finite elements; of it there are central differences, of
/// order 2, on blocks with the same mesh. Keeps a reference to the model.
class LayerDerivatives {
 public:
  static constexpr double poisson_step = 1e-3, thickness_step = 1e-3;  ///< of central differences; the second over h

  /// Poisson's ratios for which there is a derivative by it: the differences must stay within those of a block.
  static bool has_poisson(const LayerModel& model);

  /// Throws std::invalid_argument for a model of a SensorFamily.
  explicit LayerDerivatives(const LayerModel& model,
                            const std::filesystem::path& cache_directory = default_cache_directory());

  /// Returns the change by Poisson's ratio; has_poisson() is true. Makes a table, and two blocks through the cache,
  /// when it is first called.
  RubberChange by_poisson(const Patch& patch);

  /// Returns the change by the thickness, over mm. Makes two blocks through the cache when it is first called.
  RubberChange by_thickness(const Patch& patch);

  /// Returns the change where the ends of the patch move at the rates `left` and `right`, over mm. A table is linear
  /// between its rows: at a row the derivative is the mean of both sides.
  RubberChange by_ends(const Patch& patch, double left, double right) const;

 private:
  /// What the free sides change, of two neighbouring sensors, and their distance.
  struct Neighbours {
    FreeSides plus, minus;
    BaseStressTable stress_plus, stress_minus;
    double distance;
  };
  Neighbours neighbours(const Sensor& block_plus, const Sensor& block_minus, double distance) const;
  void add_sides(const Neighbours& neighbours, const Patch& patch, RubberChange& change) const;

  const LayerModel& model_;
  std::filesystem::path cache_directory_;
  std::optional<LayerTable> table_by_poisson_;
  std::optional<BaseStressTable> stress_by_poisson_, stress_by_thickness_;
  std::optional<Neighbours> by_poisson_, by_thickness_;
};

}  // namespace tactel::fem
