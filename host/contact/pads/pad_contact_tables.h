// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <compare>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "fem/pad/pad_cells.h"
#include "fem/pad/pad_layer.h"
#include "fem/pad/pad_scene.h"

namespace tactel::host {

/// Sides of a cell over H, rounded to ten digits at least: scenes of one size share a table, whatever their thickness.
struct PadCellSize {
  double hx = 0, hy = 0;
  auto operator<=>(const PadCellSize&) const = default;
};
PadCellSize cell_size(const fem::PadCells& cells, double thickness);

/// Tables of the pad kernel for one rubber. Threads may use them at once.
class PadTables {
 public:
  /// Rows of the base stress for each H, and of all: beyond 12 H it is below 2e-4 of a unit stress.
  static constexpr int stress_rows_a_thickness = 32, stress_rows = 12 * stress_rows_a_thickness + 1;
  /// The same of a rubber: layers upon layers may carry shear farther.
  static int stress_rows_of(const fem::PadLayer& layer);

  /// `means`: displacements are means over cells (fem/pad/layer_means.h), as free sides need them, not values at their
  /// middles. Not `exact`: the influence of cells whose sides are not on the ladder lies between those of rungs, right
  /// to 1e-4 of a cell's on itself, to 4e-3 for wide ones (fem::PadLayer::shares).
  PadTables(const fem::Rubber& rubber, int cells, bool exact, bool means = false);
  /// `points`: tables of fem::poisson_point, [fem::poisson_points], whose polynomial gives these.
  PadTables(double poisson, std::vector<std::shared_ptr<const PadTables>> points);

  const fem::Rubber& rubber() const { return rubber_; }
  /// None where a polynomial gives the tables.
  const std::shared_ptr<const fem::PadLayer>& layer() const { return layer_; }
  /// Influence of cells on each other, of offsets from 0 to `cells`, as every lane has its own:
  /// [PAD_TABLE_HEAD], then [cells + 1][cells + 1][PAD_OWN_INFLUENCE]. That of an object is added to the layer's.
  std::shared_ptr<const std::vector<double>> influence(const PadCellSize& size,
                                                       const fem::SoftObject& object = {}) const;
  /// The same as a group shares it: [PAD_TABLE_HEAD], then [2 cells + 1][2 cells + 1][PAD_INFLUENCE].
  std::vector<double> shared_influence(const PadCellSize& size, const fem::SoftObject& object = {}) const;
  /// [stress_rows, or stress_rows_of layers upon layers][PAD_BLOCK]
  std::vector<double> stress() const;

 private:
  std::shared_ptr<const std::vector<double>> of_layer(const PadCellSize& size) const;
  std::vector<double> make_influence(const PadCellSize& size) const;
  std::vector<double> table_of(const std::vector<fem::CellInfluence>& all, const PadCellSize& size) const;
  std::vector<double> turned(const std::vector<double>& of) const;
  std::vector<double> between_rungs(const PadCellSize& size) const;
  /// The influence of cells with both sides on rungs, which is kept.
  std::shared_ptr<const std::vector<double>> on_rungs(const PadCellSize& size) const;
  /// A table, and its weight.
  using Weighted = std::pair<double, std::shared_ptr<const std::vector<double>>>;
  std::vector<double> sum(const std::vector<Weighted>& tables, const PadCellSize& size) const;

  fem::Rubber rubber_;
  int cells_;
  bool exact_, means_ = false;
  std::vector<std::shared_ptr<const PadTables>> points_;
  std::shared_ptr<const fem::PadLayer> layer_;
  std::vector<double> stress_;
  mutable std::mutex making_;                                                            ///< of the next
  mutable std::map<PadCellSize, std::shared_ptr<const std::vector<double>>> influence_;  ///< of the ladder
};

/// Rows of a table of displacements at a depth over H, for each H, and of all: some six within the depth.
int marker_rows_a_thickness(double depth);
int marker_rows(double depth);
/// Returns displacements below the surface of a layer by forces on it, E = H = 1, as PadTables::stress has base
/// stresses: u_z in place of sigma_z, u_x, u_y in place of tau_x, tau_y. [marker_rows][PAD_BLOCK]
std::vector<double> displacement_table(double poisson, double depth);

/// Points at which the base stress is computed.
struct TactelPoints {
  explicit TactelPoints(const fem::PadSensor& sensor);
  /// Points along the side of a tactel.
  static int along(const fem::PadSensor& sensor);

  Eigen::MatrixX2d places;      ///< [tactels][points of a tactel] mm
  std::vector<double> weights;  ///< [points of a tactel]; their sum is 1
};

}  // namespace tactel::host
