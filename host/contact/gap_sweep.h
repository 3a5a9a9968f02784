// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fem/condensation.h"
#include "fem/contact_laws.h"
#include "fem/contact_solution.h"
#include "fem/scene.h"
#include "host/device/buffer.h"
#include "host/device/executor.h"

namespace tactel::host {

/// Options of the launcher of kernels/gap_sweep.cl.
struct GapSweepOptions {
  double tolerance = 0;  ///< largest change of a force in the last sweep over the largest pressure force; 0: 1e-11 in
                         ///< fp64, 1e-5 in fp32
  double accept = 0;     ///< largest residual of a solved step; 0: fem::by_rule, and twice the condensation's lost
                         ///< share of a load at least (fem::lost_force: 3e-9 for q8 at nu = 0.49999)
  int most_sweeps = 20000;  ///< an increment that needs more is reported as unsolved
  double reach = 1.25;      ///< first active set: gap elements where the rigid profile is up to this many indentations
                            ///< above its lowest point. Missed nodes are activated later; a larger set costs time
                            ///< and gains nothing
  bool base_forces = true;  ///< write base nodal forces; without them or their sums the certificate has no balance
  bool base_sums = false;   ///< instead of base_forces: write only their sums in x and y
  bool tactels = true;      ///< write stresses at the tactels
  bool nodes = true;        ///< write forces and statuses of the surface nodes
  bool fallback = true;     ///< solve_gap_sweep solves contacts exactly where the sweeps did not converge
  bool audit = true;        ///< solve_gap_sweep recomputes certificates in fp64; requires nodes and base_forces
  bool force_error = true;  ///< with audit: solve_gap_sweep estimates the fp32 error of base forces (base_force_error)
  bool second_opinion = false;  ///< solve_gap_sweep solves contacts with mu >= several_solutions_from exactly, too
};

/// Returns S of an increment in the kernel's precision, from mu, P (N/mm) and LANE_SLIP_INDEX: none where mu P = 0,
/// 0 where friction is unlimited, as fem::slip_index.
inline std::optional<double> slip_index(double mu, double P, double kernel_index) {
  if (!fem::slip_index(mu, P, 0)) return std::nullopt;
  return mu < fem::largest_friction ? kernel_index : 0;
}

/// Returns the step of a scene with friction mu from a lane's LaneResultRow numbers, without forces of nodes and
/// stresses.
fem::ContactStep lane_step(const std::function<double(int row)>& row, double mu);

/// The numbers of a scene in the outputs of a launch, in place.
template <class Real>
struct LaneAnswer {
  int steps = 0;  ///< of the scene's path
  const Real* results = nullptr;
  std::size_t result_rows = 0;  ///< numbers of a load step
  const Real* stresses = nullptr;
  std::size_t stress_rows = 0;
  std::size_t stride = 1;  ///< from number to number

  /// Returns one number of LaneResultRow.
  Real result(int step, int row) const {
    return results[(static_cast<std::size_t>(step) * result_rows + static_cast<std::size_t>(row)) * stride];
  }
  /// Asks the memory for the results, and for the stresses, some time before they are read: contacts lie in the order
  /// of lanes, which no processor foresees. Does nothing where lanes take turns.
  void fetch_results() const { fetch(results, result_rows); }
  void fetch_stresses() const { fetch(stresses, stress_rows); }
  /// [2 tactels]: sigma_y of every tactel, then tau_xy, MPa.
  template <class Number>
  void tactels(int step, std::span<Number> stress) const {
    const Real* from = stresses + static_cast<std::size_t>(step) * stress_rows * stride;
    if (stride == 1)
      for (std::size_t k = 0; k < stress.size(); ++k) stress[k] = static_cast<Number>(from[k]);
    else
      for (std::size_t k = 0; k < stress.size(); ++k) stress[k] = static_cast<Number>(from[k * stride]);
  }

 private:
  void fetch(const Real* from, std::size_t rows) const {
    constexpr std::size_t line = 64 / sizeof(Real);
    if (stride == 1)
      for (std::size_t k = 0; k < static_cast<std::size_t>(steps) * rows; k += line) __builtin_prefetch(from + k);
  }
};

/// Common property of the scenes of a launch. Each kind has its own program, so that no scene pays for parts that
/// it lacks. A scene takes the program of its kind regardless of its neighbours.
struct ContactKind {
  bool force = false;    ///< driven by force, not by depth
  bool friction = true;  ///< mu > 0
  bool operator==(const ContactKind&) const = default;
};
ContactKind kind_of(const fem::Scene& scene);

/// A sensor on a device: condensation, maps and programs for one precision. Cheap to copy.
template <class Real>
class GapSweep {
 public:
  GapSweep(Executor& executor, const fem::Sensor& sensor, const GapSweepOptions& options = {},
           const std::filesystem::path& cache_directory = fem::default_cache_directory());

  /// Scenes of this sensor (E may differ) with their load paths, laid out in lanes: [group][..][lane]; all of one
  /// ContactKind.
  class Batch {
    struct State;

   public:
    void run(const RunOptions& options = {});  ///< one launch
    std::size_t size() const;                  ///< scenes
    int steps() const;                         ///< of the longest path
    std::size_t steps_in_all() const;          ///< load increments of all scenes
    double seconds() const;                    ///< of the last run
    void fill_outputs(Real value);             ///< sets all outputs before a run; tests use NaN
    void fill_unused(Real value);              ///< the same for lanes without a scene and targets behind a path's end
    /// Returns the answer of the kernel for scene `i`, in the order of prepare(). For many scenes use a View.
    fem::ContactSolution solution(std::size_t i) const;
    /// Returns one number of LaneResultRow for a scene's increment.
    double result(std::size_t i, int step, int row) const;
    /// Returns one output row (base forces, then tactels) for a scene's increment.
    double output(std::size_t i, int step, int row) const;

    /// The outputs in place, without copies. The batch must not run during the life of a view.
    class View {
     public:
      explicit View(const Batch& batch);
      /// Returns one number of LaneResultRow for a scene's increment; LANE_NOT_RUN after the last that ran.
      Real result(std::size_t i, int step, int row) const;
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
      typename Buffer<Real>::Mapping results_, rows_, nodes_;
    };

   private:
    friend class GapSweep;
    std::shared_ptr<State> state_;
  };

  /// Throws std::invalid_argument where scenes differ in kind.
  Batch prepare(std::span<const fem::Scene> scenes) const;
  const fem::Condensation& condensation() const;
  const GapSweepOptions& options() const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

extern template class GapSweep<float>;
extern template class GapSweep<double>;

/// Friction from which on a contact is known to have several solutions: wide flats at nu >= 0.499, driven by force.
inline constexpr double several_solutions_from = 1.4;

/// Solves any scenes on any sensors. Keeps the launcher of every sensor that it has met, E aside. Threads may use one
/// at once. Cheap to copy.
class GapSweepSolver {
 public:
  GapSweepSolver(Executor& executor, Precision precision, const GapSweepOptions& options = {});

  /// Groups the scenes by sensor and kind, and runs a launch for each group. A contact with a step over tolerance is
  /// solved again from its first step, exactly, on the host (fem/gap_condensed.h, fp64), and has fell_back = true.
  /// Steps that still miss their tolerance have converged = false. With second_opinion, contacts for which the exact
  /// solver certifies other forces have several = true; of "bonded" contacts its answer is returned, which is the
  /// reference's. Throws ValueError for an invalid scene.
  std::vector<fem::ContactSolution> solve(std::span<const fem::Scene> scenes) const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

/// The same for scenes that are solved once.
std::vector<fem::ContactSolution> solve_gap_sweep(Executor& executor, std::span<const fem::Scene> scenes,
                                                  Precision precision, const GapSweepOptions& options = {});

}  // namespace tactel::host
