// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <compare>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "fem/numbers/last_used.h"
#include "fem/pad/creep.h"
#include "fem/pad/pad_cells.h"
#include "fem/pad/pad_layer.h"
#include "fem/pad/pad_scene.h"
#include "kernels/shared/pad_layout.h"

namespace tactel::host {

/// Sides of a cell over H, rounded to ten digits at least: scenes of one size share a table, whatever their thickness.
struct PadCellSize {
  double hx = 0, hy = 0;
  auto operator<=>(const PadCellSize&) const = default;
};
PadCellSize cell_size(const fem::PadCells& cells, double thickness);

using PadNumbers = std::shared_ptr<const std::vector<double>>;

/// Tables of the pad kernel for one rubber. Threads may use them at once.
class PadTables {
 public:
  /// Rows of the base stress for each H, and of all: beyond 12 H it is below 2e-4 of a unit stress.
  static constexpr int stress_rows_a_thickness = 32, stress_rows = 12 * stress_rows_a_thickness + 1;
  /// The same where the stress is taken so deep, over H; and in all of a rubber, for layers may carry shear farther.
  static int stress_rows_at(double deep);
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
  PadNumbers influence(const PadCellSize& size, const fem::SoftObject& object = {}) const;
  /// The same as a group shares it, of a grid of nx x ny cells, at most `cells` along a side: [PAD_TABLE_HEAD], then
  /// [2 nx + 1][2 ny + 1][PAD_INFLUENCE].
  std::vector<double> shared_influence(const PadCellSize& size, const fem::SoftObject& object, int nx, int ny) const;
  /// [stress_rows, or stress_rows_of layers upon layers][PAD_BLOCK]
  std::vector<double> stress() const;

 private:
  PadNumbers of_layer(const PadCellSize& size) const;
  PadNumbers make_influence(const fem::PadLayer& layer, const PadCellSize& size) const;
  /// The influence of cells with both sides on rungs, which is kept.
  PadNumbers on_rungs(const PadCellSize& size) const;

  fem::Rubber rubber_;
  int cells_;
  bool exact_, means_ = false;
  std::vector<std::shared_ptr<const PadTables>> points_;
  std::shared_ptr<const fem::PadLayer> layer_;
  std::vector<double> stress_;
  mutable std::mutex making_;                            ///< of the next
  mutable std::map<PadCellSize, PadNumbers> influence_;  ///< of the ladder
};

/// PadCreepNumber of a term.
inline std::array<double, CREEP_NUMBERS> creep_numbers(const fem::CreepStep::Term& term) {
  const auto& [c, e, b] = term;
  return {c, 1 - e, b - e, 1 - b};
}

/// Rows of a table of displacements at a depth over H, for each H, and of all: some six within the depth.
int marker_rows_a_thickness(double depth);
int marker_rows(double depth);
/// Returns displacements below the surface of a layer by forces on it, E = H = 1, as PadTables::stress has base
/// stresses: u_z in place of sigma_z, u_x, u_y in place of tau_x, tau_y. [marker_rows][PAD_BLOCK]
std::vector<double> displacement_table(double poisson, double depth);
/// Depth of a scene's markers over H; 0: none.
double marker_depth(const fem::PadScene& scene);

/// The tables of rubbers, `cells` and `exact` as PadTables. Those used last are kept. Threads may use it at once.
class PadRubbers {
 public:
  /// `any_poisson`: rubbers of one layer have polynomials in Poisson's ratio.
  PadRubbers(int cells, bool exact, bool any_poisson) : cells_(cells), exact_(exact), any_poisson_(any_poisson) {}
  std::shared_ptr<const PadTables> tables(const fem::Rubber& rubber, bool means = false);
  std::vector<double> markers(double poisson, double depth);  ///< displacement_table

 private:
  int cells_;
  bool exact_, any_poisson_;
  std::once_flag once_;  ///< of the next
  std::vector<std::shared_ptr<const PadTables>> points_{};
  fem::LastUsed<std::pair<fem::Rubber, bool>, std::shared_ptr<const PadTables>> tables_{64};
  fem::LastUsed<std::pair<double, double>, std::vector<double>> markers_{64};  ///< by Poisson's ratio and depth over H
};

/// Numbers of distinct keys one after another.
template <class Real, class Key>
struct Distinct {
  struct Part {
    std::size_t first = 0, count = 0;
  };
  /// Returns where the numbers of a key lie; make() where it is new.
  Part take(const Key& key, const auto& make) {
    const auto [part, is_new] = parts.try_emplace(key);
    if (!is_new) return part->second;
    const auto& made = make();
    part->second = {numbers.size(), made.size()};
    for (const auto number : made) numbers.push_back(static_cast<Real>(number));
    return part->second;
  }
  std::map<Key, Part> parts{};
  std::vector<Real> numbers{};
};

}  // namespace tactel::host
