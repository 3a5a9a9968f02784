// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fem/contact_solution.h"
#include "fem/scene.h"
#include "host/contact/mesh_error.h"
#include "host/contact/planner.h"

namespace tactel::host {

/// Returns the solvers of this build.
std::vector<std::string> solver_names();

struct ContactDerivatives;
struct Convergence;

/// Solver, precision, device and tolerance: the options --solver, --precision, --device and --tolerance.
struct SolveOptions {
  std::string solver = "batched";            ///< one of solver_names()
  std::string precision;                     ///< "fp32", "fp64"; empty: fp64 where the device has it
  std::string device;                        ///< name or index of an OpenCL device; empty: the default device
  std::optional<fem::SurfaceModel> model{};  ///< where no rung decides; none: the scene's own
  std::string rung;                          ///< one of rung_names(); empty: the scene's own model
  std::optional<double> accuracy;            ///< largest error in S: the planner chooses the rung
  std::optional<double> tolerance;  ///< largest relative residual that counts as converged; none: the solver's own
};

/// An answer with its solver, precision and device.
struct SolveOutcome {
  fem::ContactSolution solution;
  std::string solver, precision, device;
  fem::Scene scene{};                                       ///< as it was modelled
  std::string rung{};                                       ///< empty: the scene's own model
  std::optional<RungChoice> plan{};                         ///< reason for the rung, where an accuracy was requested
  std::string model_reason{};                               ///< why this model, patch or mesh, answered
  std::optional<MeshError> mesh_error{};                    ///< of solve's command; none: not estimated
  std::string no_estimate{};                                ///< why there is none, where one was wanted
  std::shared_ptr<const ContactDerivatives> derivatives{};  ///< none: not asked for
  std::shared_ptr<const Convergence> convergence{};         ///< none: not asked for

  bool on_patch() const { return solution.surface_width.size() > 0; }
};

/// Throws ConfigError where an accuracy is requested together with an option that it decides, and where it or the
/// tolerance is not a number above 0.
void check_modelling(const SolveOptions& options);

/// Solves one scene. Throws ConfigError for contradictory options.
SolveOutcome solve(const fem::Scene& scene, const SolveOptions& options);

/// Returns the error to expect of an answer: the planner's, where it chose the rung, else that of the mesh.
/// `finer`: of begin_finer.
std::optional<MeshError> mesh_error(const SolveOutcome& outcome, FinerAnswer finer = {});
/// Returns why mesh_error returns none.
std::string why_no_estimate(const SolveOutcome& outcome);

/// Returns true where an indentation, mm, exceeds the share of the thickness to which rubber is linear.
bool too_deep(double thickness, double indentation);
/// Returns a warning about an indentation that is too deep for a thickness, both mm; none for others.
std::optional<std::string> depth_warning(double thickness, double deepest);
std::optional<std::string> depth_warning(const fem::Scene& scene, const fem::ContactSolution& solution);

/// Returns "patch of 12 elements, 0.105 mm wide" or "mesh 41 x 11 bbar".
std::string model_name(const SolveOutcome& outcome);

/// Returns a tenth of a contact's width: the slip up to which displacements are small where no mesh is coarser.
double slip_limit(double contact_width);
/// Returns the slip of the indenter over the rubber, mm, up to which displacements are small. The profile stays
/// above the nodes of its first position. The limit is the larger of the mesh's spacing and a tenth of the
/// contact's width, mm, at this step.
double slip_limit(const fem::Sensor& sensor, double contact_width);
/// The same of a step of an answer.
double slip_limit(const fem::Sensor& sensor, const fem::ContactSolution& solution, const fem::ContactStep& step);
/// Returns a warning where the indenter slides further; none otherwise.
std::optional<std::string> slip_warning(const fem::Scene& scene, const fem::ContactSolution& solution);

/// Returns true where a drag until sliding ended without sliding.
bool never_slid(const fem::Scene& scene, const fem::ContactSolution& solution);

/// Returns the warnings about an answer, one line each; usually none. They concern units, depth, slip, a drag that
/// never slid, friction that holds the indenter above its first touch, other solutions, forces that fp32 does not
/// resolve, a rung cut to the largest mesh, and an error that is not estimated.
std::vector<std::string> warnings(const SolveOutcome& outcome);

}  // namespace tactel::host
