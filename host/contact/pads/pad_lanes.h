// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <tuple>
#include <vector>

#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_solver.h"
#include "host/contact/pads/pad_contact_tables.h"

namespace tactel::host {

/// A scene on its cells.
struct PadOnCells {
  /// What scenes share a table by.
  using Table = std::tuple<fem::Rubber, PadCellSize, fem::SoftObject>;
  Table table() const { return {fem::rubber(scene.sensor), size, object()}; }
  fem::SoftObject object() const { return fem::soft_object(scene.sensor, scene.indenter); }
  double frame() const;  ///< of the cells on the pad, rad

  fem::PadScene scene{};
  fem::PadCells cells{};
  PadCellSize size{};
  bool solvable = true;  ///< else some cells stand for those that the scene would need
  std::vector<fem::PadIncrement> path{};
  Eigen::VectorXd heights{};  ///< fem::heights_on_pad over H, y fastest
  // With free sides:
  fem::PadSides sides{};
  Eigen::VectorXd softs{};  ///< fem::shared_compliances over H
  PadNumbers influence{};   ///< of the layer: PadTables::influence
};

/// Scenes in lanes. First groups of `vectors` vectors that share a table, then groups of a vector whose lanes have
/// their own.
struct PadLanes {
  /// Scenes of one table side by side, those of like cost together, so that the lanes of a group finish together. What
  /// would not fill most of a group goes to groups where every lane has its own table; the bits are the same. Scenes
  /// with free sides: each is a group. `vectors`: 0: two where `two_fit` into registers. `width`: lanes of a vector.
  PadLanes(const std::vector<PadOnCells>& scenes, int vectors, std::size_t width, bool two_fit);

  std::vector<std::size_t> in_lane;
  std::vector<std::size_t> first_of_group;  ///< [groups that share a table] a scene that has it
  int vectors;
  std::size_t width, groups = 0, own_groups = 0;
};

}  // namespace tactel::host
