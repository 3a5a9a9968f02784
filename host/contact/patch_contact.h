// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "fem/contact_solution.h"
#include "fem/layer/layer_model.h"
#include "fem/layer/sensor_family.h"
#include "fem/scene.h"
#include "host/contact/gap_sweep.h"
#include "host/contact/patch_contact_lanes.h"
#include "host/device/buffer.h"
#include "host/device/executor.h"

namespace tactel::host {

/// Options of the launcher of kernels/patch_contact.cl.
struct PatchContactOptions {
  int elements = 12;        ///< of a patch: 8, 12, 16 or 24; each number has its own program
  int increments = 0;       ///< to each pressing target, at least; 0: a third of the elements
  bool sides = true;        ///< solve_patch_contact: with the sensor's free sides
  double tolerance = 1e-3;  ///< largest change of a force in the last sweep over the largest pressure force
  double accept = 0;        ///< largest residual of a solved step; 0: fem::by_rule
  int most_sweeps = 400;    ///< an increment that needs more is reported as unsolved
  int most_growths = 4;     ///< solve_patch_contact enlarges a patch that is too small this many times
  bool fallback = true;     ///< solve_patch_contact solves the remaining ones exactly, or by the twin with more sweeps
};

/// Contact of scenes that share a sensor, or whose sensors are of one family, each on its own patch of equal elements
/// over what its indenter touches (kernels/patch_contact.cl). Tables and programs for one precision. Cheap to copy.
template <class Real>
class PatchContact {
  struct State;

 public:
  /// Throws ValueError for a number of elements that has no program.
  PatchContact(Executor& executor, const fem::LayerModel& model, const PatchContactOptions& options = {});
  /// The same for scenes each with its own sensor of this family.
  PatchContact(Executor& executor, const fem::SensorFamily& family, const PatchContactOptions& options = {});

  /// The contact that the patch of a scene must cover; none: the kernel searches it.
  using Given = std::optional<PatchContactExtent>;

  /// Scenes of this sensor (E may differ), or of sensors of the family, on their way into a batch: the numbers that the
  /// kernel takes of each.
  class Scenes {
   public:
    explicit Scenes(const PatchContact& contact) : contact_(contact.state_) {}
    /// `path`: load_path(scene.load). Throws std::invalid_argument where the ContactKind is not that of the first,
    /// ValueError for a sensor outside the family.
    void push_back(const fem::Scene& scene, const fem::LoadPath& path, const Given& given = {});
    std::size_t size() const { return scenes_.size(); }

   private:
    friend class PatchContact;
    struct One {
      int slots = 0, indentation_slots = 0, increments = 0;
      double friction = 0, young = 0, position = 0;
      std::int64_t kin = 0;  ///< scenes with the same number cost alike
      double width = 0;      ///< mm, of the rigid profile at the largest depth
      std::size_t targets_at = 0, shape_at = 0, shape_size = 0;
    };
    std::shared_ptr<State> contact_;
    ContactKind kind_;
    std::vector<One> scenes_;
    std::vector<Real> inputs_;   ///< [scenes][PATCH_INPUT_ROWS]
    std::vector<Real> targets_;  ///< [increments of all][PATCH_PATH_ROWS]
    std::vector<Real> shapes_;
    std::vector<fem::Sensor> sensors_;  ///< [scenes] of a family
  };

  /// Scenes with their load paths, laid out in lanes; all of one ContactKind.
  class Batch {
    struct State;

   public:
    void run(const RunOptions& options = {});  ///< one launch
    /// What runs from now on compute: with `path` the load path, with `base_stress` also the stresses at the tactels.
    /// The patch and its compliance are always computed. Benchmarks time the parts with it.
    void set_parts(bool path, bool base_stress);
    std::size_t size() const;          ///< scenes
    int steps() const;                 ///< load steps of the longest path
    std::size_t steps_in_all() const;  ///< load steps of all scenes
    double seconds() const;            ///< of the last run
    void fill_outputs(Real value);     ///< what the outputs hold before a run: tests put NaN there
    void fill_unused(Real value);      ///< the same for lanes without a scene and targets behind a path's end
    /// Returns the answer of the kernel for scene `i`, in the order of prepare(); for many scenes use a View. Node
    /// forces are those of the elements of its patch, surface_x their middles; base forces are not known.
    fem::ContactSolution solution(std::size_t i) const;
    double result(std::size_t i, int step, int row) const;  ///< one number of LaneResultRow
    double patch(std::size_t i, int row) const;             ///< one number of PatchRow

    /// The outputs in place, without copies. The batch must not run during the life of a view.
    class View {
     public:
      explicit View(const Batch& batch);
      Real result(std::size_t i, int step, int row) const;  ///< one number of LaneResultRow
      Real patch(std::size_t i, int row) const;             ///< one number of PatchRow
      /// Returns the numbers of a scene, which are valid as long as the view.
      LaneAnswer<Real> answer(std::size_t i) const;
      /// Returns how many scenes share a place: their numbers take turns in memory. 1: those of a scene lie together.
      std::size_t interleaved() const;
      int path_steps(std::size_t i) const;
      int indentation_steps(std::size_t i) const;  ///< of these the first
      /// Returns the scenes in the order of memory, in which reading many is fast.
      std::span<const std::size_t> by_lane() const;
      /// Returns the answer of the kernel for scene `i`.
      fem::ContactSolution solution(std::size_t i) const;

     private:
      std::shared_ptr<State> state_;
      typename Buffer<Real>::Mapping results_, forces_, stresses_, patches_;
    };

   private:
    friend class PatchContact;
    std::shared_ptr<State> state_;
  };

  /// `given`: [scenes], or empty for none. Throws std::invalid_argument where scenes differ in kind, ValueError for a
  /// sensor outside the family.
  Batch prepare(std::span<const fem::Scene> scenes, std::span<const Given> given = {}) const;
  /// Without `forces` the kernel writes no forces of elements, and the batch has no solution().
  Batch prepare(Scenes scenes, bool forces = true) const;
  /// Returns the tables of this sensor: those of all scenes, or made from the family's.
  std::shared_ptr<const fem::LayerModel> model_of(const fem::Sensor& sensor) const;
  const PatchContactOptions& options() const;

 private:
  std::shared_ptr<State> state_;
};

extern template class PatchContact<float>;
extern template class PatchContact<double>;

/// Returns true where every step of a solution has converged.
bool every_step_converged(const fem::ContactSolution& solution);

/// What became of the scenes of a solve_patch_contact.
struct PatchContactReport {
  std::size_t grown = 0;      ///< scenes whose patch the search found too small
  std::size_t fell_back = 0;  ///< scenes that sweeps of the kernel did not solve, or that need linear elements
  std::size_t unsolved = 0;   ///< scenes with a step that missed its tolerance all the same
};

/// Returns the contact that the patch of scene `i` must cover next, where the kernel found its patch too small; none
/// where it was large enough (fem::grown).
template <class Real>
std::optional<PatchContactExtent> grown_contact(const typename PatchContact<Real>::Batch::View& view, std::size_t i,
                                                int elements);

/// Sensors that differ in more than E and their mesh: patches on one of them share its tables.
struct SharedLayers {
  std::vector<fem::Sensor> sensors;  ///< E = 1, in the order of their first scene
  std::vector<std::size_t> of;       ///< [scenes] index in sensors
};
SharedLayers shared_layers(std::span<const fem::Scene> scenes);

/// Solves scenes that a launcher takes, of any kinds, in their order. A patch that is too small grows, and its
/// scene is solved again. A scene with a step over tolerance after that is solved in fp64, exactly on the same elements
/// (fem/layer/patch_exact.h) or by the twin with more sweeps, and has fell_back = true. So has a scene whose elements
/// are too wide for its rubber: linear elements solve it (fem/layer/linear_elements.h). Steps that still miss their
/// tolerance have converged = false. Throws ValueError for an invalid scene.
template <class Real>
std::vector<fem::ContactSolution> solve_patch_contact(const PatchContact<Real>& contact,
                                                      std::span<const fem::Scene> scenes,
                                                      PatchContactReport* report = nullptr);

/// The same for scenes on any sensors, with free sides, in either precision.
std::vector<fem::ContactSolution> solve_patch_contact(Executor& executor, std::span<const fem::Scene> scenes,
                                                      Precision precision, const PatchContactOptions& options = {});

}  // namespace tactel::host
