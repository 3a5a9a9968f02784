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
#include "host/answers/line_error.h"
#include "host/answers/pad_error.h"
#include "host/answers/planner.h"

namespace tactel::host {

/// Returns the solvers of this build: "full-mesh" is of lines, "twin" of pads, which needs no device.
std::vector<std::string> solver_names();

using tactel::SolveOptions;
struct Convergence;

/// An answer with its solver, precision and device: "batched", "full-mesh", "twin" or "reference".
template <class Scene, class Solution, class AnyRung>
struct Outcome {
  Solution solution;
  std::string solver, precision, device;
  Scene scene{};                                     ///< as it was modelled
  AnyRung rung{};                                    ///< without a name: the scene's own model
  std::optional<double> accuracy{};                  ///< that was asked for and decided the rung
  std::optional<RungChoice> plan{};                  ///< of lines: reason for the rung, where an accuracy decided it
  std::string model_reason{};                        ///< of lines: why this model, patch or mesh, answered
  std::optional<ExpectedError> error{};              ///< none: not estimated, or nothing is touched
  std::string no_estimate{};                         ///< of lines: why there is none, where one was wanted
  std::shared_ptr<const Convergence> convergence{};  ///< none: not asked for

  bool on_patch() const { return solution.surface_width.size() > 0; }  ///< of lines
  /// The accuracy that was requested.
  bool kept() const { return plan ? plan->kept : !accuracy || !error || error->expected.S <= *accuracy; }
};
using SolveOutcome = Outcome<fem::Scene, fem::ContactSolution, Rung>;
using PadOutcome = Outcome<fem::PadScene, fem::PadSolution, PadRung>;

/// Throws ConfigError where an accuracy is requested together with an option that it decides, and where it or the
/// tolerance is not a number above 0.
void check_modelling(const SolveOptions& options);

/// Throws ConfigError for what only a device takes. `solver`: that uses none, "--solver twin".
void refuse_device_options(const SolveOptions& options, const std::string& solver);

/// Solves one scene, with `on_mesh` on its own mesh where no rung decides, and states its error: of lines where
/// options.estimate_error asks for it. Throws ConfigError for contradictory options; of a pad ValueError, key
/// "indenter.position", for a contact nearer than its thickness to an edge.
SolveOutcome solve(const fem::Scene& scene, const SolveOptions& options, bool on_mesh = false);
PadOutcome solve(const fem::PadScene& scene, const SolveOptions& options);

/// Returns the error to expect of an answer: the planner's, where it chose the rung, else that of the mesh.
/// `finer`: of begin_finer.
std::optional<ExpectedError> mesh_error(const SolveOutcome& outcome, FinerAnswer finer = {});

/// Returns "patch of 12 elements, 0.105 mm wide" or "mesh 41 x 11 bbar"; of a pad "12 x 12 cells of 0.21 x 0.21 mm".
std::string model_name(const SolveOutcome& outcome);
std::string model_name(const PadOutcome& outcome);

}  // namespace tactel::host
