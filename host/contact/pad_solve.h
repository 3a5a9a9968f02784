// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fem/pad/pad_solver.h"
#include "host/contact/pad_rung.h"
#include "host/contact/solve.h"

namespace tactel::host {

/// An answer on a pad with its solver, precision and device.
struct PadOutcome {
  fem::PadSolution solution;
  fem::PadScene scene;
  std::string solver;  ///< "batched", "twin" or "reference"
  std::string precision, device;
  PadRung rung;
  std::optional<PadError> error{};                   ///< to expect; none where nothing is touched
  std::optional<double> accuracy{};                  ///< that was asked for and decided the rung
  std::shared_ptr<const Convergence> convergence{};  ///< none: not asked for

  bool kept() const { return !accuracy || !error || error->most95.slip_index <= *accuracy; }
};

/// Returns the solvers of pads: "batched" and "twin", which needs no device and computes in fp64.
std::vector<std::string> pad_solver_names();

/// Solves one scene on a pad. Throws ConfigError for contradictory options, and ValueError, key "indenter.position",
/// for a contact nearer than its thickness to an edge of the pad.
PadOutcome solve(const fem::PadScene& scene, const SolveOptions& options);

/// Returns "12 x 12 cells of 0.21 x 0.21 mm".
std::string model_name(const PadOutcome& outcome);

/// Returns the distance, mm, from the contact to the nearest edge of the pad, negative beyond it; none where the scene
/// gives no edges, or nothing is touched.
std::optional<double> distance_to_edge(const fem::PadScene& scene, const fem::PadSolution& solution);
/// The same of a contact that lies within `reach` from the indenter's axis.
std::optional<double> distance_to_edge(const fem::PadSensor& sensor, const std::array<double, 2>& position,
                                       const fem::PadBox& reach);

/// Throws ValueError, before any work, for a scene that would have no end on so many cells a side: key
/// "indenter.shape" for a contact that is a needle or a plain to the rubber, "sensor.tactel_size" for tactels that take
/// too many points of rubber so thin.
void refuse_endless(const fem::PadScene& scene, int cells);

/// Returns true where that is less than the thickness.
bool too_near_edge(const fem::PadSensor& sensor, const std::optional<double>& distance);
/// Throws ValueError, key "indenter.position", there.
void refuse_at_edge(const fem::PadScene& scene, const std::optional<double>& distance);

/// What a set keeps of contacts that the model or the tactels do not serve, their sum in the dataset `outside`.
enum PadOutside {
  outside_edges = 1,    ///< nearer than the thickness H to an edge of the pad: solve() refuses the contact
  outside_tactels = 2,  ///< a pitch above 2 H, and the contact stays farther than H from every tactel
  outside_cells = 4,    ///< cells longer than H
};
/// Returns the sum for a contact that lies within `reach` from the indenter's axis, on cells of this longer side, mm.
int outside_model(const fem::PadSensor& sensor, const std::array<double, 2>& position, const fem::PadBox& reach,
                  double cell);

/// Returns the warnings about an answer, one line each; usually none. They concern units, depth, slip, edges of the
/// pad, steps that touch nothing or few cells, a contact that the tactels hardly see, and errors that are large or were
/// not measured.
std::vector<std::string> warnings(const PadOutcome& outcome);

}  // namespace tactel::host
