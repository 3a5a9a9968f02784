// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/solve_options.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fem/gap/contact_solution.h"
#include "fem/pad/pad_solver.h"
#include "fem/scenes/scene.h"
#include "host/answers/mesh_error.h"
#include "host/answers/pad_error.h"
#include "host/answers/planner.h"

namespace tactel::host {

/// Returns the solvers of this build: "full-mesh" is of lines, "twin" of pads, which needs no device.
std::vector<std::string> solver_names();

using tactel::SolveOptions;
struct Convergence;

/// An answer with its solver, precision and device.
struct SolveOutcome {
  fem::ContactSolution solution;
  std::string solver, precision, device;
  fem::Scene scene{};                                ///< as it was modelled
  std::string rung{};                                ///< empty: the scene's own model
  std::optional<RungChoice> plan{};                  ///< reason for the rung, where an accuracy was requested
  std::string model_reason{};                        ///< why this model, patch or mesh, answered
  std::optional<ExpectedError> error{};              ///< of solve's command; none: not estimated
  std::string no_estimate{};                         ///< why there is none, where one was wanted
  std::shared_ptr<const Convergence> convergence{};  ///< none: not asked for

  bool on_patch() const { return solution.surface_width.size() > 0; }
  bool kept() const { return !plan || plan->kept; }  ///< the accuracy that was requested
};

/// An answer on a pad.
struct PadOutcome {
  fem::PadSolution solution;
  std::string solver, precision, device;  ///< solver: "batched", "twin" or "reference"
  fem::PadScene scene{};
  PadRung rung{};
  std::optional<ExpectedError> error{};              ///< to expect; none where nothing is touched
  std::optional<double> accuracy{};                  ///< that was asked for and decided the rung
  std::shared_ptr<const Convergence> convergence{};  ///< none: not asked for

  bool kept() const { return !accuracy || !error || error->expected.S <= *accuracy; }
};

/// Throws ConfigError where an accuracy is requested together with an option that it decides, and where it or the
/// tolerance is not a number above 0.
void check_modelling(const SolveOptions& options);

/// Solves one scene, with `on_mesh` on its own mesh where no rung decides. Throws ConfigError for contradictory
/// options; of a pad ValueError, key "indenter.position", for a contact nearer than its thickness to an edge.
SolveOutcome solve(const fem::Scene& scene, const SolveOptions& options, bool on_mesh = false);
PadOutcome solve(const fem::PadScene& scene, const SolveOptions& options);

/// Returns the error to expect of an answer: the planner's, where it chose the rung, else that of the mesh.
/// `finer`: of begin_finer.
std::optional<ExpectedError> mesh_error(const SolveOutcome& outcome, FinerAnswer finer = {});
/// Estimates it as `outcome.error`, or says in `outcome.no_estimate` why there is none.
void estimate_error(SolveOutcome& outcome, FinerAnswer finer = {});

/// Returns "patch of 12 elements, 0.105 mm wide" or "mesh 41 x 11 bbar"; of a pad "12 x 12 cells of 0.21 x 0.21 mm".
std::string model_name(const SolveOutcome& outcome);
std::string model_name(const PadOutcome& outcome);

}  // namespace tactel::host
