#pragma once
#include "fem/indenter.h"

namespace tactel::fem {

/// A point of a measured profile that stands above the lower convex hull of all points.
struct NonConvexity {
  double x, height;  ///< mm: where, and how far above the hull
};
std::vector<NonConvexity> non_convexities(const Profile& profile);

/// Lower convex hull of the points with its lowest height taken as 0: what the contact sees. Only hull corners remain.
Profile convex_profile(const Profile& profile);

/// Linear between the points, +infinity beyond the ends (and `edge_guard`). Points as they are: no hull.
double height_between_points(const Profile& profile, double x);

/// Throws ValueError: at least two points, finite, x increasing, convex within `smooth`.
void validate(const Profile& profile);

}  // namespace tactel::fem
