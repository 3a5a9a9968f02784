// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/commands/solve_request.h"
#include "host/contact/pad_json.h"
#include "host/contact/pad_table.h"
#include "host/contact/solve_page.h"
#include "host/figures/pad_figure.h"
#include "host/figures/pad_view.h"
#include "host/figures/vtu.h"
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
  if (!request.plot.empty()) check_figure_path("--plot", request.plot);
  if (!request.html.empty()) check_writable("--html", request.html);
  if (!request.field.empty()) check_writable("--field", request.field);
  if (request.derivatives)
    throw ConfigError("command line", "--derivatives", "", "left out of a pad: only answers of a line have them");
}

void write_pad_results(const SolveRequest& request, const PadOutcome& outcome) {
  const fem::PadScene& scene = outcome.scene;
  const std::size_t step = chosen_step(request, outcome.solution.steps.size());
  if (request.json == "-") {
    fmt::print("{}", json_text(to_json(outcome)));
  } else {
    if (!request.json.empty()) write_file("--json", request.json, json_text(to_json(outcome)));
    fmt::print("{}", pad_table(outcome));
  }
  if (!request.plot.empty()) write_figure("--plot", request.plot, contact_figure(scene, outcome.solution, step));
  if (!request.html.empty()) {
    const std::size_t shown = request.step ? step : telling_step(outcome.solution);
    write_file("--html", request.html, solve_page(outcome, shown).html());
  }
  if (!request.field.empty()) write_file("--field", request.field, to_vtu(scene, outcome.solution, step));
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
  PadOutcome outcome = solve_file(request, scene);
  judge(request, outcome);
  if (outcome.accuracy && !request.shared.quiet)
    fmt::print(stderr, "rung {} ({}): expected error in S {:.2g}, requested {:g}\n", outcome.rung.name,
               description(outcome.rung), outcome.error ? outcome.error->most95.slip_index : 0, *outcome.accuracy);
  for (const std::string& warning : warnings(outcome)) warn(request, warning);
  write_pad_results(request, outcome);
  const bool converged = std::ranges::all_of(outcome.solution.steps, &fem::PadStep::converged);
  if (!converged) warn(request, "some steps missed their tolerance");
  if (!outcome.kept()) warn(request, "no rung is known to keep this accuracy on this scene: the finest was taken");
  return converged && outcome.kept() ? done : not_converged;
}

}  // namespace tactel::host
