#pragma once
#include <optional>
#include <string>
#include <vector>

#include "fem/contact_solution.h"
#include "fem/scene.h"
#include "host/planner.h"

namespace tactel::host {

/// The solvers of this build.
std::vector<std::string> solver_names();

/// Who solves a contact, and how well: what --solver, --precision, --device and --tolerance say.
struct SolveOptions {
  std::string solver = "batched";   ///< one of solver_names()
  std::string precision;            ///< "fp32", "fp64"; empty: fp64 where there is
  std::string device;               ///< name or index of an OpenCL device; empty: the best there is
  std::string rung;                 ///< one of rung_names(): how finely to model; empty: as the scene says
  std::optional<double> accuracy;   ///< largest error in S: the planner chooses the rung
  std::optional<double> tolerance;  ///< largest relative residual that counts as converged; none: the solver's own
};

/// An answer and who gave it.
struct SolveOutcome {
  fem::ContactSolution solution;
  std::string solver, precision, device;
  fem::Scene scene{};          ///< as it was modelled
  std::string rung{};          ///< empty: as the scene says
  std::optional<Plan> plan{};  ///< why that rung, where an accuracy was asked for
};

/// Throws ConfigError where an accuracy is asked for together with what it decides.
void check_modelling(const SolveOptions& options);

/// Solves one scene. Throws ConfigError for options that do not go together.
SolveOutcome solve(const fem::Scene& scene, const SolveOptions& options);

/// Whether an indentation, mm, is beyond the share of the thickness to which rubber is linear.
bool too_deep(const fem::Sensor& sensor, double indentation);
/// What to say of an indentation that is too deep; none of others.
std::optional<std::string> depth_warning(const fem::Scene& scene, const fem::ContactSolution& solution);

}  // namespace tactel::host
