// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fem/gap/contact_laws.h"
#include "fem/scenes/scene.h"
#include "host/device/buffer.h"
#include "host/device/executor.h"
#include "kernels/shared/result_rows.h"

namespace tactel::host {

/// Common property of the scenes of a launch. Each kind has its own program, so that no scene pays for parts that
/// it lacks. A scene takes the program of its kind regardless of its neighbours.
struct ContactKind {
  bool force = false;    ///< driven by force, not by depth
  bool friction = true;  ///< mu > 0
  auto operator<=>(const ContactKind&) const = default;
};
ContactKind kind_of(const fem::Scene& scene);

/// Returns S of an increment in the kernel's precision, from mu, P and RESULT_S: none where mu P = 0,
/// 0 where friction is unlimited, as fem::slip_index.
inline std::optional<double> slip_index(double mu, double P, double kernel_index) {
  if (!fem::slip_index(mu, P, 0)) return std::nullopt;
  return mu < fem::largest_friction ? kernel_index : 0;
}

/// Returns true for the statuses of steps that met their tolerance.
inline bool solved(int status) { return status == LANE_SOLVED || status == LANE_SLIDING; }

/// Returns what steps of all kinds have from the rows of a result (kernels/shared/result_rows.h). `mu`: of the scene.
template <class Step>
Step step_of(const std::function<double(int row)>& row, double mu) {
  Step step;
  step.P = row(RESULT_P), step.indentation = row(RESULT_DEPTH), step.slip_distance = row(RESULT_SLIP_DISTANCE);
  step.slip_index = slip_index(mu, step.P, row(RESULT_S));
  step.iterations = static_cast<int>(row(RESULT_SWEEPS));
  step.converged = solved(static_cast<int>(row(RESULT_STATUS)));
  step.residual.penetration = row(RESULT_PENETRATION), step.residual.complementarity = row(RESULT_COMPLEMENTARITY);
  step.residual.cone = row(RESULT_CONE), step.residual.drift = row(RESULT_DRIFT);
  return step;
}
/// Returns the step of a line, without forces of nodes and stresses.
fem::ContactStep lane_step(const std::function<double(int row)>& row, double mu);

/// The numbers of a scene in the outputs of a launch, in place, in either precision.
class LaneAnswer {
 public:
  struct Numbers {
    const void* from = nullptr;
    std::size_t rows = 0;  ///< of a load step
    bool fp64 = false;
  };
  LaneAnswer() = default;
  /// Of numbers that lie together, [steps][rows].
  LaneAnswer(int steps, const Numbers& results, const Numbers& stresses)
      : steps(steps), results_(results), stresses_(stresses) {}

  int steps = 0;                        ///< of the scene's path
  int indentation_steps = 0;            ///< of these the first
  const fem::Sensor* sensor = nullptr;  ///< of a line's scene; of a launch on one sensor its own, but for E
  std::size_t stride = 1;               ///< from number to number

  /// Returns one number of LaneResultRow, of pads PadResultRow.
  double result(int step, int row) const { return number(results_, step, row); }
  /// Returns one number of PatchRow; 0 on a mesh.
  double patch(int row) const { return patch_.from ? number(patch_, 0, row) : 0; }
  /// Returns the width of an element of the surface, mm.
  double element() const;
  /// Returns true where every step that ran met its tolerance.
  bool solved() const;
  /// Asks the memory for the results, and for the stresses, some time before they are read: contacts lie in the order
  /// of lanes, which no processor foresees. Does nothing where lanes take turns: there for the share `part` of `parts`
  /// of a step's numbers.
  void fetch_results() const { fetch(results_); }
  void fetch_stresses() const { fetch(stresses_); }
  void fetch_step(int step, std::size_t part, std::size_t parts) const {
    fetch_step(results_, step, part, parts);
    fetch_step(stresses_, step, part, parts);
  }
  /// Returns the numbers of a step that tactels() gives: stresses, and behind them what the launch adds.
  std::size_t stresses() const { return stresses_.rows; }
  /// [2 tactels]: sigma_y of every tactel, then tau_xy, MPa. Of pads [3 tactels]: sigma_z, tau_x, tau_y; behind them
  /// [3 markers]: u_z of every marker, u_x, u_y, mm.
  template <class Number>
  void tactels(int step, std::span<Number> stress) const {
    if (stresses_.fp64)
      copy(static_cast<const double*>(stresses_.from), step, stress);
    else
      copy(static_cast<const float*>(stresses_.from), step, stress);
  }

 private:
  template <class Real>
  friend class LaneView;
  double number(const Numbers& all, int step, int row) const {
    const std::size_t at = (static_cast<std::size_t>(step) * all.rows + static_cast<std::size_t>(row)) * stride;
    return all.fp64 ? static_cast<const double*>(all.from)[at] : double{static_cast<const float*>(all.from)[at]};
  }
  template <class Real, class Number>
  void copy(const Real* from, int step, std::span<Number> to) const {
    from += static_cast<std::size_t>(step) * stresses_.rows * stride;
    if (stride == 1)
      for (std::size_t k = 0; k < to.size(); ++k) to[k] = static_cast<Number>(from[k]);
    else
      for (std::size_t k = 0; k < to.size(); ++k) to[k] = static_cast<Number>(from[k * stride]);
  }
  void fetch(const Numbers& all) const {
    constexpr std::size_t line = 64;
    const std::size_t bytes = static_cast<std::size_t>(steps) * all.rows * (all.fp64 ? sizeof(double) : sizeof(float));
    if (stride == 1)
      for (std::size_t k = 0; k < bytes; k += line) __builtin_prefetch(static_cast<const char*>(all.from) + k);
  }
  void fetch_step(const Numbers& all, int step, std::size_t part, std::size_t parts) const {
    if (stride == 1 || step >= steps) return;
    const std::size_t bytes = stride * (all.fp64 ? sizeof(double) : sizeof(float));
    for (std::size_t row = part; row < all.rows; row += parts)
      __builtin_prefetch(static_cast<const char*>(all.from) +
                         (static_cast<std::size_t>(step) * all.rows + row) * bytes);
  }

  Numbers results_, stresses_, patch_;
};

/// Returns numbers on the device, rounded to its type; one 0 where there are none, for kernels take no empty buffers.
template <class T>
Buffer<T> buffer_of(const Device& device, const auto& numbers) {
  std::vector<T> rounded(std::begin(numbers), std::end(numbers));
  if (rounded.empty()) rounded.resize(1);
  return Buffer<T>(device, std::span<const T>(rounded));
}

/// Numbers of lanes on a device, [lanes / tile][steps][rows][tile]: those of a tile's lanes lie side by side.
template <class Real>
struct LaneArray {
  LaneArray() = default;
  LaneArray(const Device& device, std::size_t lanes, std::size_t tile, std::size_t steps, std::size_t rows)
      : numbers(device, std::max<std::size_t>(lanes * steps * rows, 1)), tile(tile), steps(steps), rows(rows) {}
  std::size_t at(std::size_t lane, std::size_t step, std::size_t row) const {
    return ((lane / tile * steps + step) * rows + row) * tile + lane % tile;
  }
  /// Writes the first numbers of a lane.
  void put(std::span<Real> all, std::size_t lane, const auto& numbers_of_lane) const {
    Real* to = &all[at(lane, 0, 0)];
    for (const auto number : numbers_of_lane) *to = static_cast<Real>(number), to += tile;
  }
  const LaneArray& fill(Real number) const {
    std::ranges::fill(numbers.map(MapFor::writing).view(), number);
    return *this;
  }
  double read(std::size_t lane, std::size_t step, std::size_t row) const {
    Real value;
    numbers.read(std::span(&value, 1), at(lane, step, row));
    return value;
  }

  Buffer<Real> numbers;
  std::size_t tile = 1, steps = 0, rows = 0;
};

/// Scenes on their way into a batch: the numbers that a kernel takes of each.
template <class Real>
struct LaneScenes {
  struct One {
    int steps = 0, indentation_steps = 0;
    int increments = 0;  ///< targets of the kernel: the steps, and those between them
    double friction = 0, young = 0, position = 0;
    std::size_t targets_at = 0;
  };
  std::size_t size() const { return scenes.size(); }
  /// Adds a scene. Throws std::invalid_argument where the kind is not that of the first.
  void add(ContactKind scene_kind, One scene);

  ContactKind kind;
  std::vector<One> scenes;
  std::vector<Real> inputs;          ///< [scenes][input rows]
  std::vector<Real> targets;         ///< [increments of all][path rows]
  std::vector<fem::Sensor> sensors;  ///< of lines: one, or [scenes]
};

/// In place of a scene, where a lane has none.
inline constexpr std::size_t no_scene = -1;

template <class Real>
class LaneView;

/// What a launcher makes of its scenes: all members, and the launch.
template <class Real>
struct LaneState {
  /// Takes the scenes, and lays them out in the order of lanes, `lanes_of_group` a group and as many groups side by
  /// side as numbers are interleaved. `in_lane`: scene in a lane, or no_scene.
  void lay_out(Executor& on, LaneScenes<Real>&& from, std::span<const std::size_t> in_lane, std::size_t lanes_of_group,
               std::size_t interleaved, std::size_t input_rows, std::size_t path_rows);
  const Device& device() const { return executor->device(); }
  /// Returns numbers of lanes: of_scene(i) of the lane of scene i, then and elsewhere `other`.
  LaneArray<Real> array(std::size_t tile, std::size_t steps, std::size_t rows, Real other, const auto& of_scene) const {
    LaneArray<Real> made(device(), lanes, tile, steps, rows);
    const auto all = made.numbers.map(MapFor::writing);
    std::ranges::fill(all.view(), other);
    for (const std::size_t i : order) made.put(all.view(), place[i], of_scene(i));
    return made;
  }

  Executor* executor = nullptr;
  std::vector<typename LaneScenes<Real>::One> scenes;
  std::vector<fem::Sensor> sensors;       ///< of lines: one, or [scenes]
  std::vector<std::size_t> order, place;  ///< [scenes] scenes in the order of lanes, lane of a scene
  int steps = 0, increments = 0;          ///< of the longest path
  std::size_t groups = 0, lanes = 0;      ///< groups that run; lanes of all arrays
  std::size_t stresses_from = 0;          ///< row of outputs
  LaneArray<Real> path, input;
  std::vector<LaneArray<Real>> more_inputs;  ///< that lanes without a scene have, too
  LaneArray<Real> results, outputs, forces, patches;
  Buffer<Real> shapes;                   ///< numbers of shapes, where a kernel takes any
  std::vector<std::vector<Job>> rounds;  ///< one after another; the jobs of one side by side
  /// Gives the jobs what they need for a run alone, until the result ends; none: nothing.
  std::function<std::shared_ptr<const void>()> borrow{};
  /// Returns the answer of the kernel for scene `i` of a line.
  std::function<fem::ContactSolution(const LaneView<Real>& view, std::size_t i)> solution;
  double seconds = 0;
};

/// Scenes with their load paths laid out in lanes, all of one ContactKind. Copies share the scenes.
template <class Real>
class ContactBatch {
 public:
  using View = LaneView<Real>;
  explicit ContactBatch(std::shared_ptr<LaneState<Real>> state) : state_(std::move(state)) {}

  void run(const RunOptions& options = {});
  std::size_t size() const { return state_->scenes.size(); }
  int steps() const { return state_->steps; }         ///< of the longest path
  std::size_t steps_in_all() const;                   ///< load steps of all scenes
  double seconds() const { return state_->seconds; }  ///< of the last run
  void fill_outputs(Real value);                      ///< sets all outputs before a run; tests use NaN
  void fill_unused(Real value);  ///< the same for lanes without a scene and targets behind a path's end
  /// Returns the answer of the kernel for scene `i`, in the order of prepare(). For many scenes use a View.
  fem::ContactSolution solution(std::size_t i) const { return View(*this).solution(i); }
  /// Returns one number of LaneResultRow, of pads PadResultRow.
  double result(std::size_t i, int step, int row) const {
    return state_->results.read(state_->place[i], static_cast<std::size_t>(step), static_cast<std::size_t>(row));
  }
  /// Returns one number of PatchRow.
  double patch(std::size_t i, int row) const {
    return state_->patches.read(state_->place[i], 0, static_cast<std::size_t>(row));
  }
  const std::shared_ptr<LaneState<Real>>& state() const { return state_; }

 private:
  std::shared_ptr<LaneState<Real>> state_;
};

/// The outputs of a batch in place, without copies. The batch must not run during the life of a view.
template <class Real>
class LaneView {
 public:
  explicit LaneView(const ContactBatch<Real>& batch)
      : state_(batch.state()),
        results_(state_->results.numbers.map(MapFor::reading)),
        outputs_(state_->outputs.numbers.map(MapFor::reading)),
        forces_(state_->forces.numbers.map(MapFor::reading)),
        patches_(state_->patches.numbers.map(MapFor::reading)) {}
  /// Returns one number of LaneResultRow for a scene's step; LANE_NOT_RUN after the last that ran.
  Real result(std::size_t i, int step, int row) const { return number(state_->results, results_, i, step, row); }
  /// Returns one output row: of meshes base forces, then tactels.
  Real output(std::size_t i, int step, int row) const { return number(state_->outputs, outputs_, i, step, row); }
  /// Returns one number of the elements of the surface.
  Real force(std::size_t i, int step, int row) const { return number(state_->forces, forces_, i, step, row); }
  /// Returns one number of PatchRow.
  Real patch(std::size_t i, int row) const { return number(state_->patches, patches_, i, 0, row); }
  /// Returns the numbers of a scene, which are valid as long as the view.
  LaneAnswer answer(std::size_t i) const;
  /// Returns how many scenes share a place: their numbers take turns in memory. 1: those of a scene lie together.
  std::size_t interleaved() const { return state_->results.tile; }
  const typename LaneScenes<Real>::One& scene(std::size_t i) const { return state_->scenes[i]; }
  const fem::Sensor& sensor(std::size_t i) const { return state_->sensors[state_->sensors.size() == 1 ? 0 : i]; }
  int path_steps(std::size_t i) const { return state_->scenes[i].steps; }
  int indentation_steps(std::size_t i) const { return state_->scenes[i].indentation_steps; }  ///< of these the first
  /// Returns the scenes in the order of memory, in which reading many is fast.
  std::span<const std::size_t> by_lane() const { return state_->order; }
  /// Returns the answer of the kernel for scene `i`.
  fem::ContactSolution solution(std::size_t i) const { return state_->solution(*this, i); }

 private:
  using Mapping = typename Buffer<Real>::Mapping;
  Real number(const LaneArray<Real>& array, const Mapping& numbers, std::size_t i, int step, int row) const {
    return numbers[array.at(state_->place[i], static_cast<std::size_t>(step), static_cast<std::size_t>(row))];
  }
  std::shared_ptr<LaneState<Real>> state_;
  Mapping results_, outputs_, forces_, patches_;
};

extern template struct LaneScenes<float>;
extern template struct LaneScenes<double>;
extern template struct LaneState<float>;
extern template struct LaneState<double>;
extern template class ContactBatch<float>;
extern template class ContactBatch<double>;
extern template class LaneView<float>;
extern template class LaneView<double>;

}  // namespace tactel::host
