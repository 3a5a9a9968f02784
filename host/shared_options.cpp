#include "host/command.h"

namespace tactel::host {

void add_shared_options(CLI::App& command, SharedOptions& options) {
  SolveOptions& solve = options.solve;
  command.add_option("--solver", solve.solver, "who solves: reference (full mesh, fp64)")
      ->check(CLI::IsMember(solver_names()))
      ->capture_default_str();
  command.add_option("--precision", solve.precision, "fp32 or fp64 (default: fp64)")
      ->check(CLI::IsMember({"fp32", "fp64"}));
  command.add_option("--device", solve.device, "OpenCL device, its index or a part of its name")
      ->type_name("NAME|INDEX");
  command
      .add_option("--tolerance", solve.tolerance,
                  "largest relative residual that counts as converged, no unit (default: the solver's own)")
      ->check(CLI::PositiveNumber);
  command.add_flag("--quiet", options.quiet, "no progress and no warnings on stderr");
}

}  // namespace tactel::host
