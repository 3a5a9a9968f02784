// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "fem/gap/stress_field.h"
#include "fem/pad/side_kernel.h"
#include "host/answers/answer_forms.h"
#include "host/answers/convergence.h"
#include "host/answers/warnings.h"
#include "host/commands/add_option.h"
#include "host/commands/shared_options.h"
#include "host/figures/contact_figure.h"
#include "host/figures/contact_view.h"
#include "host/figures/vtu.h"
#include "host/scenes/scene_file.h"
#include "host/scenes/toml_table.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/json_text.h"
#include "host/support/progress_line.h"
#include "host/support/terminal.h"

namespace tactel::host {
namespace {

struct SolveRequest {
  SharedOptions shared;
  std::string scene, json, plot, field, html;
  std::optional<int> step;
  bool converge = false;
};

/// The index of the step that --step names, from 1; the last by default.
std::size_t chosen_step(const SolveRequest& request, std::size_t steps) {
  const int count = static_cast<int>(steps);
  const int step = request.step.value_or(count);
  if (step < 1 || step > count) {
    throw ConfigError("command line", "--step", std::to_string(step),
                      fmt::format("a load step of this scene, 1 to {}", count));
  }
  return static_cast<std::size_t>(step - 1);
}

void warn(const SolveRequest& request, const std::string& text) {
  if (!request.shared.quiet) print_warning(text);
}

/// The step of --step, or a telling one.
std::size_t shown_step(const SolveRequest& request, const auto& solution) {
  const std::size_t chosen = chosen_step(request, solution.steps.size());
  return request.step ? chosen : telling_step(solution);
}

/// Judges that step beside ever smaller cells where --converge asks for it.
void judge(const SolveRequest& request, auto& outcome) {
  if (!request.converge) return;
  std::unique_ptr<StageLine> stage;
  const std::size_t step = shown_step(request, outcome.solution);
  outcome.convergence = std::make_shared<const Convergence>(converge(outcome, step, [&](const std::string& rung) {
    stage.reset();
    stage = std::make_unique<StageLine>("solving " + rung, request.shared.quiet);
  }));
}

/// Everything that could make the results unwritable, before the work and not after it.
void check_solve_outputs(const SolveRequest& request) {
  if (!request.json.empty() && request.json != "-") check_writable("--json", request.json);
  if (!request.plot.empty()) check_figure_path("--plot", request.plot);
  if (!request.html.empty()) check_writable("--html", request.html);
}

void warn_of_strain(const SolveRequest& request, const fem::StressField& field) {
  Eigen::Index node = 0;
  const double most = field.strain.maxCoeff(&node);
  if (most <= fem::linear_strain_limit) return;
  warn(request,
       fmt::format("the strain reaches {:.0f} % at x = {:.3g} mm, y = {:.3g} mm; rubber was measured to be "
                   "linear up to {:.0f} %",
                   100 * most, field.mesh.node(0, node), field.mesh.node(1, node), 100 * fem::linear_strain_limit));
}

void write_field(const SolveRequest& request, const SolveOutcome& outcome, std::size_t step) {
  const fem::StressField field = fem::stress_field(outcome.scene.sensor, outcome.solution.steps[step]);
  write_file("--field", request.field, to_vtu(field));
  warn_of_strain(request, field);
}
void write_field(const SolveRequest& request, const PadOutcome& outcome, std::size_t step) {
  write_file("--field", request.field, field_of(request.field, outcome.scene, outcome.solution, step));
}

SolveOutcome solve_file(const SolveRequest& request, const fem::Scene& asked) {
  SolveOptions options = request.shared.solve;
  options.estimate_error = true;
  const bool on_mesh = !request.field.empty();
  if (on_mesh) {
    check_writable("--field", request.field);
    if (!asked.sensor.layers.empty())
      throw ConfigError("command line", "--field", request.field,
                        "left out with sensor.layers: strains have two values at interfaces");
    if (options.accuracy || (!options.rung.empty() && rung_named(options.rung).patch()))
      throw ConfigError("command line", "--field", request.field,
                        "left out, or given with a mesh, such as --rung mesh-161: a patch has no nodes in the block");
  }
  const StageLine stage("solving " + request.scene, request.shared.quiet);
  return solve(asked, options, on_mesh);
}

/// " (tables of its free sides first: about 3 s)" where that takes a second or more.
std::string first_tables(const fem::PadSensor& sensor) {
  const double seconds = fem::seconds_for_sides(sensor, fem::SideBricks::finer);
  return seconds < 1 ? "" : fmt::format(" (tables of its free sides first: about {})", duration_text(seconds));
}

/// Errors that the answer alone shows get the line of the scene's file.
PadOutcome solve_file(const SolveRequest& request, const fem::PadScene& scene) try {
  if (!request.field.empty()) check_writable("--field", request.field);
  if (request.field.ends_with(".vts") && !fem::side_rules(scene.sensor).knows_inside)
    throw ConfigError("command line", "--field", request.field,
                      "a .vtu, of cells: the field in the rubber is that of a pad with held sides");
  if (request.field.ends_with(".vts") && !scene.sensor.layers.empty())
    throw ConfigError("command line", "--field", request.field,
                      "a .vtu, of cells: the field in the rubber is that of "
                      "one layer, without sensor.layers");
  const StageLine stage("solving " + request.scene + first_tables(scene.sensor), request.shared.quiet);
  return solve(scene, request.shared.solve);
} catch (const ValueError& error) {
  throw TomlFile(request.scene).error(error);
}

/// The line about the rung that an accuracy took; empty: none was asked for.
std::string choice(const SolveOutcome& outcome) { return outcome.plan ? outcome.plan->why() : ""; }
std::string choice(const PadOutcome& outcome) {
  if (!outcome.accuracy) return "";
  return fmt::format("rung {} ({}): expected error in S {:.2g}, requested {:g}", outcome.rung.name,
                     description(outcome.rung), outcome.error ? outcome.error->expected.S : 0, *outcome.accuracy);
}

int solve_scene(const SolveRequest& request, const auto& asked) {
  check_solve_outputs(request);
  auto outcome = solve_file(request, asked);
  judge(request, outcome);
  const auto& [scene, solution] = std::tie(outcome.scene, outcome.solution);
  if (const std::string line = choice(outcome); !line.empty() && !request.shared.quiet)
    fmt::print(stderr, "{}\n", line);
  for (const std::string& warning : warnings(outcome)) warn(request, warning);
  const std::size_t step = chosen_step(request, solution.steps.size());
  if (!request.json.empty() && request.json != "-") write_file("--json", request.json, json_text(to_json(outcome)));
  fmt::print("{}", request.json == "-" ? json_text(to_json(outcome)) : answer_table(outcome));
  if (!request.plot.empty()) write_figure("--plot", request.plot, contact_figure(scene, solution, step));
  if (!request.html.empty())
    write_file("--html", request.html, answer_page(outcome, shown_step(request, solution)).html());
  if (!request.field.empty()) write_field(request, outcome, step);
  const bool converged = std::ranges::all_of(solution.steps, [](const auto& s) { return s.converged; });
  constexpr bool of_line = std::is_same_v<decltype(outcome), SolveOutcome>;
  if (!converged)
    warn(request,
         of_line ? "some steps missed their tolerance: see the column `met`" : "some steps missed their tolerance");
  if (!outcome.kept()) warn(request, "no rung is known to keep this accuracy on this scene: the finest was taken");
  if (of_line && never_slid(scene, solution)) return not_converged;
  return converged && outcome.kept() ? done : not_converged;
}

int run_solve(const SolveRequest& request) {
  return std::visit([&](const auto& scene) { return solve_scene(request, scene); }, read_any_scene(request.scene));
}

}  // namespace

void add_solve_command(CLI::App& app, Action& action) {
  const auto [command, request] = add_command(
      app, action, "Simulate", "solve", "solve one contact: a line per load step, or the whole answer", run_solve);
  add_option(command, "scene", request.scene, "scene file (TOML; mm, MPa, N/mm, degrees)", {.type = "SCENE.toml"})
      ->required();
  add_option(command, "--json", request.json,
             "write the whole answer as JSON; - for standard output, instead of the table", {.type = "FILE"});
  add_option(command, "--plot", request.plot,
             "draw tractions on the surface (MPa), stress at the tactels (MPa) and S, over x (mm); of a pad from above",
             {.type = "FILE.svg|png|pdf"});
  add_option(command, "--field", request.field,
             "write displacement (mm) and stress (MPa) in the block, for ParaView; of a pad in .vts, in .vtu the cells "
             "of its surface with tractions (MPa) and status: 0 open, 1 stick, 2 slip",
             {.type = "FILE.vtu|vts"});
  add_option(command, "--html", request.html,
             "write a page: the contact over its load steps, with rubber, tractions, stress and tactels",
             {.type = "FILE.html"});
  add_option(command, "--step", request.step,
             "load step of --plot and --field, from 1 (default: the last), the first of --html, that of --converge",
             {.type = "K"});
  add_option(command, "--converge", request.converge,
             "solve also on ever smaller cells: order, limit and its uncertainty, error of this answer");
  add_shared_options(command, request.shared);
}

}  // namespace tactel::host
