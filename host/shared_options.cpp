#include "host/command.h"

namespace tactel::host {
namespace {

void add_device_option(CLI::App& command, std::string& device) {
  command.add_option("--device", device, "OpenCL device: a part of its name or its index, see `tactel devices`")
      ->type_name("NAME|INDEX");
}

}  // namespace

void add_shared_options(CLI::App& command, SharedOptions& options) {
  SolveOptions& solve = options.solve;
  command
      .add_option("--solver", solve.solver, "who solves: batched (OpenCL) or reference (full mesh, no OpenCL, slow)")
      ->check(CLI::IsMember(solver_names()))
      ->capture_default_str();
  command
      .add_option("--precision", solve.precision, "of the arithmetic (default: fp64, or fp32 on a device without it)")
      ->check(CLI::IsMember({"fp32", "fp64"}));
  add_device_option(command, solve.device);
  command
      .add_option("--tolerance", solve.tolerance,
                  "largest relative residual that counts as converged, no unit (default: the solver's own)")
      ->check(CLI::PositiveNumber);
  command
      .add_option(
          "--rung", solve.rung,
          "how finely to model: a rung of the ladder sets mesh, load steps, precision and tolerance, whatever the "
          "file says (docs/accuracy.md; default: as the file says)")
      ->check(CLI::IsMember(rung_names()));
  command
      .add_option("--accuracy", solve.accuracy,
                  "largest error to expect in S: takes the cheapest rung that keeps it, and says which and why")
      ->type_name("E")
      ->check(CLI::PositiveNumber);
  command.add_flag("--quiet", options.quiet, "no progress and no warnings on stderr");
}

void add_network_options(CLI::App& command, NetworkOptions& options) {
  command.add_option("--precision", options.precision, "of the arithmetic; network files hold fp32")
      ->check(CLI::IsMember({"fp32", "fp64"}))
      ->capture_default_str();
  add_device_option(command, options.device);
  command.add_flag("--quiet", options.quiet, "no progress and no warnings; from train no summary either");
}

}  // namespace tactel::host
