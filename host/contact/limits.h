// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <optional>
#include <string>

#include "fem/pad/pad_solver.h"
#include "fem/scenes/scene.h"

// Up to where the models of contact hold.

namespace tactel::host {

/// Returns true where an indentation, mm, exceeds the share of the thickness to which rubber is linear.
bool too_deep(double thickness, double indentation);

/// Returns a tenth of a contact's width: the slip up to which displacements are small where no mesh is coarser.
double slip_limit(double contact_width);
/// Returns the slip of the indenter over the rubber, mm, up to which displacements are small. The profile stays
/// above the nodes of its first position. The limit is the larger of the mesh's spacing and a tenth of the
/// contact's width, mm, at this step.
double slip_limit(const fem::Sensor& sensor, double contact_width);

/// Throws ValueError, before any work, for a scene that would have no end on so many cells a side: key
/// "indenter.shape" for a contact that is a needle or a plain to the rubber, "sensor.sides" for one that
/// reaches_beyond_block, "sensor.tactel_size" for tactels that take too many points of rubber so thin.
void refuse_endless(const fem::PadScene& scene, int cells);

/// Returns true for a contact that reaches nearly to where the block ends that stands for a longer pad with free sides
/// (fem/pad/side_kernel.h).
bool reaches_beyond_block(const fem::PadScene& scene, const fem::PadCells& laid);

/// Returns the distance, mm, from the contact to the nearest edge of the pad, negative beyond it; none where the scene
/// gives no edges, where they are free in the model, or nothing is touched.
std::optional<double> distance_to_edge(const fem::PadScene& scene, const fem::PadSolution& solution);
/// The same of a contact that lies within `reach` from the indenter's axis.
std::optional<double> distance_to_edge(const fem::PadSensor& sensor, const std::array<double, 2>& position,
                                       const fem::PadBox& reach);
/// Returns true where that is less than the thickness.
bool too_near_edge(const fem::PadSensor& sensor, const std::optional<double>& distance);
/// Throws ValueError, key "indenter.position", there.
void refuse_at_edge(const fem::PadScene& scene, const std::optional<double>& distance);
/// Returns "0.005 to 0.018": the error in S of lines without free sides at a distance from the edge over the thickness.
std::string error_at_edge(double distance);

/// Returns true for tactels so far apart that they hardly see what lies between: below a point load sigma_z falls to a
/// tenth within a thickness.
bool wide_pitch(const fem::PadSensor& sensor);
/// Returns true where they hardly see a contact at this distance from the middle of the nearest one, mm.
bool far_from_tactels(const fem::PadSensor& sensor, double distance);

/// What a set keeps of contacts that the model or the tactels do not serve, their sum in the dataset `outside`.
enum PadOutside {
  outside_edges = 1,    ///< nearer than the thickness H to an edge of the pad: solve() refuses the contact
  outside_tactels = 2,  ///< a pitch above 2 H, and the contact stays farther than H from every tactel
  outside_cells = 4,    ///< cells longer than H
};
/// Returns the sum for a contact that lies within `reach` from the indenter's axis, on cells of this longer side, mm.
int outside_model(const fem::PadSensor& sensor, const std::array<double, 2>& position, const fem::PadBox& reach,
                  double cell);

}  // namespace tactel::host
