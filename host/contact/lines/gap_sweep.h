// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "fem/gap/contact_solution.h"
#include "fem/mesh/condensation.h"
#include "fem/numbers/cache_directory.h"
#include "fem/scenes/scene.h"
#include "host/contact/contact_batch.h"
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

/// A sensor on a device: condensation, maps and programs for one precision. Cheap to copy.
template <class Real>
class GapSweep {
  struct State;

 public:
  using Batch = ContactBatch<Real>;
  GapSweep(Executor& executor, const fem::Sensor& sensor, const GapSweepOptions& options = {},
           const std::filesystem::path& cache_directory = fem::default_cache_directory());

  /// Scenes of this sensor (E may differ) on their way into a batch.
  class Scenes : public LaneScenes<Real> {
   public:
    explicit Scenes(const GapSweep& sweep) : sweep_(sweep.state_) {}
    /// `path`: load_path(scene.load). Throws std::invalid_argument where the ContactKind is not that of the first.
    void push_back(const fem::Scene& scene, const fem::LoadPath& path);

   private:
    friend class GapSweep;
    struct Cost {
      int nodes = 0;                 ///< that the rigid profile reaches at the deepest indentation
      double overlap = 0, grip = 0;  ///< how deep they are on the whole; when the contact begins to slide, about
    };
    std::vector<std::size_t> by_cost() const;  ///< scene in a lane
    std::shared_ptr<State> sweep_;
    std::vector<Cost> costs_;    ///< [scenes]
    std::vector<Real> heights_;  ///< [scenes][columns] mm
  };

  Batch prepare(Scenes scenes) const;
  /// Throws std::invalid_argument where scenes differ in kind.
  Batch prepare(std::span<const fem::Scene> scenes) const;
  const fem::Condensation& condensation() const;
  const GapSweepOptions& options() const;

 private:
  std::shared_ptr<State> state_;
};

extern template class GapSweep<float>;
extern template class GapSweep<double>;

}  // namespace tactel::host
