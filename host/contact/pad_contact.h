// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "fem/pad/pad_solver.h"
#include "host/device/buffer.h"
#include "host/device/executor.h"

namespace tactel::host {

/// Options of the launcher of kernels/pad_contact.cl.
struct PadContactOptions {
  int cells = 12;           ///< along a side: 8, 12, 16 or 24; each number has its own program
  int increments = 0;       ///< to each pressing target, at least; 0: a third of the cells, two at least
  bool halve_turns = true;  ///< as fem::PadOptions
  bool ladder = true;       ///< cell sizes that scenes share (fem::pad_cells)
  double tolerance = 1e-3;  ///< largest change of a traction in the last sweep over the largest pressure
  double accept = 0;        ///< largest residual of a solved step; 0: fem::by_rule
  int most_sweeps = 2000;   ///< an increment that needs more is reported as unsolved
  int most_growths = 4;     ///< solve_pad_contact enlarges cells that are too small this many times
  int vectors = 0;          ///< of scenes in a work-item, 1 to 3; 0: by the size of the batch
};

/// Contact of scenes on pads, each on its own cells over what its indenter touches. Scenes whose cells have one size
/// over the thickness, and one Poisson's ratio, share a group. Tables and programs for one precision. Cheap to copy.
template <class Real>
class PadContact {
  struct State;

 public:
  /// Throws ValueError for a number of cells that has no program.
  PadContact(Executor& executor, const PadContactOptions& options = {});

  /// Scenes laid out in lanes, with their cells.
  class Batch {
   public:
    void run(const RunOptions& options = {});  ///< two launches: contact, then base stress
    std::size_t size() const;                  ///< scenes
    std::size_t steps_in_all() const;          ///< load steps of all scenes
    double filled() const;                     ///< scenes over lanes
    double seconds() const;                    ///< of the last run
    /// Leaves out the base stress and the forces of cells: benchmarks time the parts with it.
    void set_parts(bool base_stress);
    void fill_outputs(Real value);                          ///< tests put NaN there before a run
    double result(std::size_t i, int step, int row) const;  ///< one number of PadResultRow
    const fem::PadScene& scene(std::size_t i) const;        ///< as the cells see it (fem::lay_cells)
    const fem::PadCells& cells(std::size_t i) const;
    /// Returns the answer for scene `i`, in the order of prepare().
    fem::PadSolution solution(std::size_t i) const;

   private:
    friend class PadContact;
    struct State;
    std::shared_ptr<State> state_;
  };

  /// `cells`: [scenes], or empty: those of fem::lay_cells. The sensors of all scenes must have the
  /// same tactels. Throws std::invalid_argument otherwise.
  Batch prepare(std::span<const fem::PadScene> scenes, std::span<const fem::PadCells> cells = {}) const;

  const PadContactOptions& options() const;
  /// Returns the layer of a Poisson's ratio, made at its first use.
  std::shared_ptr<const fem::PadLayer> layer(double poisson) const;

 private:
  std::shared_ptr<State> state_;
};

/// What became of the scenes of a solve_pad_contact.
struct PadContactReport {
  std::size_t grown = 0;      ///< scenes whose cells the search laid too small
  std::size_t fell_back = 0;  ///< scenes that the twin solved in the kernel's place
  std::size_t unsolved = 0;   ///< scenes with a step that missed its tolerance all the same
};

/// Solves scenes in their order; `cells` as PadContact::prepare. Where the surface is penetrated beyond the cells, they
/// grow, and the scene is solved again. A scene with a step over tolerance after that is solved by the twin in fp64, to
/// a sweep tolerance of 1e-6.
template <class Real>
std::vector<fem::PadSolution> solve_pad_contact(const PadContact<Real>& contact, std::span<const fem::PadScene> scenes,
                                                std::span<const fem::PadCells> cells = {},
                                                PadContactReport* report = nullptr);

extern template class PadContact<float>;
extern template class PadContact<double>;

}  // namespace tactel::host
