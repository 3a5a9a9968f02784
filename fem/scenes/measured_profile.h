// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/scenes/indenter.h"

namespace tactel::fem {

/// A point of a measured profile above the lower convex hull of all points.
struct NonConvexity {
  double x, height;  ///< mm: position, and height above the hull
};
std::vector<NonConvexity> non_convexities(const Profile& profile);

/// Returns the lower convex hull of the points, shifted so that its lowest height is 0. Only the corners of the
/// hull remain.
Profile convex_profile(const Profile& profile);

/// Returns the height at x: linear between the points, +infinity beyond the ends (and `edge_guard`). The points
/// are used as they are, without a hull.
double height_between_points(const Profile& profile, double x);

/// Throws ValueError where measured heights span more than ten times their width, both mm: they have another unit, or a
/// number stands for a missing point.
void check_range(const std::string& key, double range, double width);

/// Throws ValueError unless there are at least two points, all finite, x increasing, convex within `smooth`.
void validate(const Profile& profile);

}  // namespace tactel::fem
