// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/layer/layer_model.h"
#include "fem/layer/patch.h"
#include "fem/mesh/condensation.h"

namespace tactel::fem {

// The free sides at low rank (free_sides.h) do not resolve the corner at an end of the rubber, where the compliance of
// the surface grows with the logarithm of the distance: their mesh has 12 columns to a thickness, and 8 modes. A
// contact over the end at nu = 0 has S off by 0.02. A mesh of the whole sensor, graded towards the contact, resolves
// it.

/// Thicknesses from an end within which a patch feels the corner.
inline constexpr double corner_reach = 0.5;

/// Thicknesses between nodes up to which the mesh resolves the layer. A contact of 120 wider ones spans 30 thicknesses,
/// of which the corner is a small part.
inline constexpr double widest_node_distance = 0.25;

/// Returns true where a contact [left, right], mm, lies within `corner_reach` of an end of the sensor.
bool near_end(const Sensor& sensor, Interval contact);

/// Returns the x of mesh columns over the whole sensor: the nodes [ascending] mm of the contact, and beyond them
/// columns that widen by a fifth each, up to a twelfth of the thickness.
Eigen::VectorXd graded_columns(const Sensor& sensor, const Eigen::VectorXd& nodes);

/// Returns the surface nodes as gap elements of the exact solver; as patch_condensation. Their compliance is that of a
/// mesh with graded_columns and 33 rows of bbar. nu = 1/2 is taken as 0.49999.
Condensation end_condensation(const LayerModel& model, const Eigen::VectorXd& nodes);

}  // namespace tactel::fem
