#include "host/contact/solve_on_rung.h"

#include "host/contact/gap_sweep.h"

namespace tactel::host {

std::vector<fem::ContactSolution> solve_on_rung(Executor& executor, std::span<const fem::Scene> scenes,
                                                const Rung& rung, bool nodes) {
  std::vector<fem::Scene> modelled;
  for (const fem::Scene& scene : scenes) modelled.push_back(on_rung(scene, rung));
  GapSweepOptions options;
  options.tolerance = rung.tolerance;
  options.spread = rung.spread;
  options.nodes = nodes;
  options.fallback = rung.spread == 1;  // which solves the block's own gap elements
  return solve_gap_sweep(executor, modelled, rung.precision, options);
}

}  // namespace tactel::host
