#include "host/solve.h"

#include "fem/gap_reference.h"
#include "host/errors.h"

namespace tactel::host {

std::vector<std::string> solver_names() { return {"reference"}; }

SolveOutcome solve(const fem::Scene& scene, const SolveOptions& options) {
  if (options.precision == "fp32")
    throw ConfigError("command line", "--precision", "fp32", "fp64 with --solver reference");
  if (!options.device.empty())
    throw ConfigError("command line", "--device", options.device,
                      "left out with --solver reference, which uses no device");
  fem::GapReferenceOptions reference;
  if (options.tolerance) reference.tolerance = *options.tolerance;
  return {fem::solve_gap_reference(scene, reference), "reference", "fp64", "host"};
}

}  // namespace tactel::host
