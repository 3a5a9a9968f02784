// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "fem/stress_field.h"
#include "host/commands/solve_request.h"
#include "host/contact/derivatives.h"
#include "host/contact/scene_json.h"
#include "host/contact/solution_table.h"
#include "host/contact/solve_page.h"
#include "host/figures/contact_figure.h"
#include "host/figures/vtu.h"
#include "host/scenes/scene_file.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/json_text.h"
#include "host/support/progress_line.h"
#include "host/support/terminal.h"

namespace tactel::host {

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

namespace {

/// Everything that could make the results unwritable, before the work and not after it.
void check_solve_outputs(const SolveRequest& request) {
  if (!request.json.empty() && request.json != "-") check_writable("--json", request.json);
  if (!request.plot.empty()) check_figure_path("--plot", request.plot);
  if (!request.html.empty()) check_writable("--html", request.html);
  if (request.derivatives && request.json.empty())
    throw ConfigError("command line", "--derivatives", "", "given with --json FILE, which takes them");
  if (request.field.empty()) return;
  check_writable("--field", request.field);
  const SolveOptions& solve = request.shared.solve;
  if (solve.accuracy || (!solve.rung.empty() && rung_named(solve.rung).patch()))
    throw ConfigError("command line", "--field", request.field,
                      "left out, or given with a mesh, such as --rung mesh-161: a patch has no nodes in the block");
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

void write_results(const SolveRequest& request, const fem::Scene& scene, const SolveOutcome& outcome) {
  const std::size_t step = chosen_step(request, outcome.solution.steps.size());
  if (request.json == "-") {
    fmt::print("{}", json_text(to_json(scene, outcome)));
  } else {
    if (!request.json.empty()) write_file("--json", request.json, json_text(to_json(scene, outcome)));
    fmt::print("{}", solution_table(scene, outcome));
  }
  if (!request.plot.empty()) write_figure("--plot", request.plot, contact_figure(scene, outcome.solution, step));
  if (!request.html.empty()) {
    const std::size_t shown = request.step ? step : telling_step(outcome.solution);
    write_file("--html", request.html, solve_page(outcome, shown).html());
  }
  if (request.field.empty()) return;
  const fem::StressField field = fem::stress_field(scene.sensor, outcome.solution.steps[step]);
  write_file("--field", request.field, to_vtu(field));
  warn_of_strain(request, field);
}

int run_solve_line(const SolveRequest& request, const fem::Scene& asked) {
  check_solve_outputs(request);
  SolveOutcome outcome = [&] {
    const StageLine stage("solving " + request.scene, request.shared.quiet);
    SolveOptions options = request.shared.solve;
    if (!request.field.empty()) options.model = fem::SurfaceModel::mesh;  // a patch has no nodes in the block
    const bool on_own_mesh =
        options.rung.empty() && !options.accuracy && options.model.value_or(asked.model) == fem::SurfaceModel::mesh;
    FinerAnswer finer = on_own_mesh ? begin_finer(asked) : FinerAnswer{};
    SolveOutcome solved = solve(asked, options);
    solved.mesh_error = mesh_error(solved, std::move(finer));
    if (!solved.mesh_error) solved.no_estimate = why_no_estimate(solved);
    if (request.derivatives)
      solved.derivatives = std::make_shared<const ContactDerivatives>(derivatives(asked, solved));
    return solved;
  }();
  judge(request, outcome);
  const fem::Scene& scene = outcome.scene;
  if (outcome.plan && !request.shared.quiet) fmt::print(stderr, "{}\n", outcome.plan->why());
  for (const std::string& warning : warnings(outcome)) warn(request, warning);
  write_results(request, scene, outcome);
  const bool converged = std::ranges::all_of(outcome.solution.steps, &fem::ContactStep::converged);
  if (!converged) warn(request, "some steps missed their tolerance: see the column `met`");
  const bool accurate = !outcome.plan || outcome.plan->kept;
  if (!accurate) warn(request, "no rung is known to keep this accuracy on this scene: the finest was taken");
  return converged && accurate && !never_slid(scene, outcome.solution) ? done : not_converged;
}

int run_solve(const SolveRequest& request) {
  const AnyScene scene = read_any_scene(request.scene);
  if (const auto* pad = std::get_if<fem::PadScene>(&scene)) return run_solve_pad(request, *pad);
  return run_solve_line(request, std::get<fem::Scene>(scene));
}

}  // namespace

void add_solve_command(CLI::App& app, Action& action) {
  auto request = std::make_shared<SolveRequest>();
  CLI::App* command = app.add_subcommand("solve", "solve one contact: a line per load step, or the whole answer");
  command->group("Simulate");
  command->add_option("scene", request->scene, "scene file (TOML; mm, MPa, N/mm, degrees)")
      ->type_name("SCENE.toml")
      ->required();
  command
      ->add_option("--json", request->json,
                   "write the whole answer as JSON; - for standard output, instead of the table")
      ->type_name("FILE");
  command
      ->add_option(
          "--plot", request->plot,
          "draw tractions on the surface (MPa), stress at the tactels (MPa) and S, over x (mm); of a pad from above")
      ->type_name("FILE.svg|png|pdf");
  command
      ->add_option("--field", request->field,
                   "write displacement (mm) and stress (MPa) in the block, for ParaView; of a pad the cells of its "
                   "surface with tractions (MPa) and status: 0 open, 1 stick, 2 slip")
      ->type_name("FILE.vtu");
  command
      ->add_option("--html", request->html,
                   "write a page: the contact over its load steps, with rubber, tractions, stress and tactels")
      ->type_name("FILE.html");
  command
      ->add_option(
          "--step", request->step,
          "load step of --plot and --field, from 1 (default: the last), the first of --html, that of --converge")
      ->type_name("K");
  command->add_flag("--derivatives", request->derivatives,
                    "add the derivatives of forces, S and stresses by the scene's numbers to --json");
  command->add_flag("--converge", request->converge,
                    "solve also on ever smaller cells: order, limit and its uncertainty, error of this answer");
  add_shared_options(*command, request->shared);
  command->callback([request, &action] { action = [request] { return run_solve(*request); }; });
}

}  // namespace tactel::host
