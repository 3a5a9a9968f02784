// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/commands/solve_request.h"
#include "host/contact/pad_json.h"
#include "host/contact/pad_table.h"
#include "host/scenes/toml_table.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/json_text.h"
#include "host/support/progress_line.h"

namespace tactel::host {
namespace {

/// Everything that could make the results unwritable, before the work and not after it.
void check_pad_outputs(const SolveRequest& request) {
  if (!request.json.empty() && request.json != "-") check_writable("--json", request.json);
  const auto refuse = [](const char* option, const std::string& value, const char* why) {
    throw ConfigError("command line", option, value, std::string("left out of a pad: ") + why);
  };
  if (!request.field.empty()) refuse("--field", request.field, "it has no mesh in the block");
  if (request.derivatives) refuse("--derivatives", "", "only answers of a line have them");
  if (!request.html.empty()) refuse("--html", request.html, "only answers of a line have a page");
  if (!request.plot.empty()) refuse("--plot", request.plot, "only answers of a line have a plot");
}

void write_pad_results(const SolveRequest& request, const PadOutcome& outcome) {
  chosen_step(request, outcome.solution.steps.size());
  if (request.json == "-") {
    fmt::print("{}", json_text(to_json(outcome)));
    return;
  }
  if (!request.json.empty()) write_file("--json", request.json, json_text(to_json(outcome)));
  fmt::print("{}", pad_table(outcome));
}

/// Errors that the answer alone shows, with the line of the scene's file.
PadOutcome solve_file(const SolveRequest& request, const fem::PadScene& scene) try {
  const StageLine stage("solving " + request.scene, request.shared.quiet);
  return solve(scene, request.shared.solve);
} catch (const ValueError& error) {
  throw TomlFile(request.scene).error(error);
}

}  // namespace

int run_solve_pad(const SolveRequest& request, const fem::PadScene& scene) {
  check_pad_outputs(request);
  const PadOutcome outcome = solve_file(request, scene);
  if (outcome.accuracy && !request.shared.quiet)
    fmt::print(stderr, "rung {} ({}): expected error in S {:.2g}, requested {:g}\n", outcome.rung.name,
               description(outcome.rung), outcome.error ? outcome.error->S : 0, *outcome.accuracy);
  for (const std::string& warning : warnings(outcome)) warn(request, warning);
  write_pad_results(request, outcome);
  const bool converged = std::ranges::all_of(outcome.solution.steps, &fem::PadStep::converged);
  if (!converged) warn(request, "some steps missed their tolerance");
  if (!outcome.kept()) warn(request, "no rung is known to keep this accuracy on this scene: the finest was taken");
  return converged && outcome.kept() ? done : not_converged;
}

}  // namespace tactel::host
