// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "fem/layer/end_modes.h"
#include "fem/layer/layer_model.h"
#include "fem/numbers/cache_directory.h"

namespace tactel::fem {

/// Sensors that a SensorFamily serves: every E, every thickness.
struct SensorRange {
  double poisson_low = 0.45, poisson_high = 0.45;
  double longest = 14;  ///< largest length / thickness
  int tactels = 21;
  bool operator==(const SensorRange&) const = default;
};

/// Shortest sensor of a family, in thicknesses: its ends must not feel each other.
inline constexpr double shortest_of_family = 6;

/// Tables of one Poisson's ratio, from which a family is made.
struct FamilyNode {
  LayerTable table;
  std::optional<SideDifference> sides;
};

/// Tables that give contact on patches of any sensor in a range, without a condensation for each. In two steps: at
/// `nodes` Poisson's ratios (Chebyshev points of the range) everything is exact; a polynomial through them fills rows
/// of the tables, and between these rows all is linear in Poisson's ratio. Lengths are in thicknesses. Errors:
/// docs/claims.md.
class SensorFamily {
 public:
  static constexpr int nodes = 8;
  static constexpr int stress_cells_a_thickness = 48;
  static constexpr double widest_poisson_cell = 0.004;
  static constexpr double stress_reach = 20;  ///< h; farther away a force changes no stress at the base (e^-15)

  /// Poisson's ratios at which the range wants its FamilyNode: `nodes`, or one where the range is a point.
  static std::vector<double> node_poissons(const SensorRange& range);

  /// One condensation of a block, through the cache, unless `sides` is false.
  static FamilyNode node(const SensorRange& range, double poisson, bool sides,
                         const std::filesystem::path& cache_directory = default_cache_directory());

  /// `made`: [nodes] in the order of node_poissons. Throws ValueError for a range that has no tables.
  SensorFamily(const SensorRange& range, const std::vector<FamilyNode>& made);

  /// The same, making the nodes one after the other.
  explicit SensorFamily(const SensorRange& range, bool sides = true);

  const SensorRange& range() const;
  bool sides() const;

  /// Throws ValueError where the sensor is invalid or outside the range, or its tactels have a width: for the kernel
  /// they are points.
  void require(const Sensor& sensor) const;

  /// The twin of the kernel's way through the tables: all that contact of this sensor wants. Its tactels may have a
  /// width. Throws as require().
  LayerModel model(const Sensor& sensor) const;

  /// Where a Poisson's ratio lies among the rows: 0 at the lowest.
  double place(double poisson) const;
  int poisson_rows() const;  ///< at least 2

  /// One row of Poisson's ratios.
  const LayerTable& table(int row) const;
  const EndModes& ends() const;                     ///< where sides() is true
  const EndModes::Core& compliance(int row) const;  ///< C of EndModes
  const EndModes::Core& base_stress(int row) const;

 private:
  struct Tables;
  std::shared_ptr<const Tables> tables_;
};

}  // namespace tactel::fem
