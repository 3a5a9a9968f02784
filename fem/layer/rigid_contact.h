// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/scenes/indenter.h"

namespace tactel::fem {

/// Returns the indenter's own edges, mm along the array; infinite where it has none.
Interval indenter_extent(const Indenter& indenter);

/// Returns where the profile, `depth` mm below the flat surface, is at or below it: mm along the array, within
/// `room`, of which a part must lie under the profile's lowest part. Found by bisection, to rounding.
Interval rigid_contact(const Indenter& indenter, double depth, Interval room);

/// Returns the indenter with a measured profile replaced by its lower convex hull, which is then built once.
Indenter with_hull(const Indenter& indenter);

}  // namespace tactel::fem
