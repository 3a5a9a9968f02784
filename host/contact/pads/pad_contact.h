// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "fem/pad/pad_solver.h"
#include "host/contact/contact_batch.h"
#include "host/contact/pads/pad_lanes.h"
#include "host/contact/pads/pad_sums.h"
#include "host/device/executor.h"
#include "kernels/shared/pad_layout.h"

namespace tactel::host {

/// What a load asks for, in order.
struct PadPath {
  std::vector<fem::PadTarget> steps;
};

/// What tactels of one launch have in common: numbers along x and y, pitch, size, how many points make one, and their
/// depth over the thickness.
using PadTactels = std::tuple<std::array<int, 2>, std::array<double, 2>, double, int, double>;
PadTactels tactels_of(const fem::PadSensor& sensor);

/// What scenes of one launch have in common where sides are free: length, width, thickness (mm), Poisson's ratio; else
/// 0.
std::array<double, 4> free_block(const fem::PadSensor& sensor);

/// Returns the sides -x, +x, -y, +y of its own frame beyond which the surface is penetrated: there its cells must grow.
std::array<bool, 4> penetrated_sides(const LaneAnswer& answer);

/// Returns the step of a scene with friction mu (fem::mean_friction) from its PadResultRow numbers, without forces of
/// cells and stresses.
fem::PadStep pad_step(const std::function<double(int row)>& row, const fem::PadTarget& target, double mu);

/// Contact of scenes on pads, each on its own cells over what its indenter touches; a scene whose cells are not
/// fem::solvable, or that reaches_beyond_block (limits.h), gets LANE_INVALID. Sensors may differ in thickness,
/// E and Poisson's ratio, not in their tactels, and markers over the thickness; with free sides in E alone. Scenes
/// whose cells have one size over the thickness, and one Poisson's ratio, share a group; others have tables of their
/// own, and all with free sides. Tables and programs for one precision. Cheap to copy.
template <class Real>
class PadContact {
  struct State;
  /// What a batch has besides the lanes' arrays.
  struct Laid : LaneState<Real> {
    std::shared_ptr<State> contact;
    std::vector<PadOnCells> on_cells;  ///< [scenes]
    bool mapped = false;               ///< some scene has a map of friction
    std::size_t creep_terms = 0;       ///< most of a rubber that creeps
    std::size_t path_rows() const { return PAD_PATH_ROWS + (creep_terms > 0 ? 1 + CREEP_NUMBERS * creep_terms : 0); }
    int force_parts() const { return creep_terms > 0 ? 6 : 3; }        ///< of a cell
    std::size_t memory_rows() const { return 6 * (1 + creep_terms); }  ///< numbers of a cell that creep
    PadSums<Real> stress, markers;                                     ///< one behind the other in the outputs
    Buffer<Real> tables, own_tables;
    Buffer<std::int32_t> table_of_group;
    LaneArray<Real> cell_forces;
    // With free sides:
    Buffer<Real> between, responses;
    Buffer<std::int32_t> response_of;
    LaneArray<Real> softs;
    std::array<int, 2> nodes{};
    std::array<double, 2> sides{};  ///< of the block over H
  };

 public:
  /// Throws ValueError for a number of cells that has no program.
  PadContact(Executor& executor, const fem::PadOptions& options = {});

  /// Scenes on their way into a batch.
  class Scenes {
   public:
    explicit Scenes(const PadContact&) {}
    /// `path`: that of the scene's load. Without `cells` those of fem::lay_cells. Throws std::invalid_argument where
    /// the tactels are not those of the first.
    void push_back(const fem::PadScene& scene, PadPath path, const std::optional<fem::PadCells>& cells = {});

   private:
    friend class PadContact;
    struct One {
      fem::PadScene scene;
      PadPath path;
      std::optional<fem::PadCells> cells;
    };
    std::vector<One> all_;
  };

  /// Scenes laid out in lanes, with their cells.
  class Batch : public ContactBatch<Real> {
   public:
    /// Returns the answer for scene `i`, in the order of prepare().
    fem::PadSolution solution(const LaneView<Real>& view, std::size_t i) const;
    fem::PadSolution solution(std::size_t i) const { return solution(LaneView<Real>(*this), i); }
    /// As the cells see it (fem::lay_cells).
    const fem::PadScene& scene(std::size_t i) const { return laid_->on_cells.at(i).scene; }
    const fem::PadCells& cells(std::size_t i) const { return laid_->on_cells.at(i).cells; }
    /// Scenes over lanes.
    double filled() const { return static_cast<double>(this->size()) / static_cast<double>(laid_->lanes); }
    /// Leaves out the base stress and the forces of cells: benchmarks time the parts with it.
    void set_parts(bool base_stress);

   private:
    friend class PadContact;
    explicit Batch(std::shared_ptr<Laid> laid) : ContactBatch<Real>(laid), laid_(std::move(laid)) {}
    std::shared_ptr<Laid> laid_;
  };

  /// `cells`: [scenes], or empty: those of fem::lay_cells.
  Batch prepare(std::span<const fem::PadScene> scenes, std::span<const fem::PadCells> cells = {}) const;
  /// Without `forces` the batch has no solution().
  Batch prepare(Scenes scenes, bool forces = true) const;

  const fem::PadOptions& options() const;
  Executor& executor() const;
  /// Returns the layer of a rubber.
  std::shared_ptr<const fem::PadLayer> layer(const fem::Rubber& rubber) const;
  /// Load steps of a launch of such scenes, at most: some 67 MB of forces, and of displacements of markers.
  std::size_t most_lane_steps(const Scenes& scenes) const;
  /// Returns the same with fewer load steps a launch, for pads whose block is not the same everywhere: each scene has
  /// its own responses, some 0.3 MB.
  PadContact for_long_pads() const;

 private:
  std::shared_ptr<State> state_;
  bool long_pads_ = false;
};

extern template class PadContact<float>;
extern template class PadContact<double>;

}  // namespace tactel::host
