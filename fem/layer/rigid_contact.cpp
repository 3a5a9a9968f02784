// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/rigid_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/scenes/measured_profile.h"

namespace tactel::fem {
namespace {

constexpr Interval everywhere{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};

Interval extent(const Flat& s) { return s.half_width ? Interval{-*s.half_width, *s.half_width} : everywhere; }
Interval extent(const Cylinder& s) { return {-s.radius, s.radius}; }
Interval extent(const Profile& s) { return {s.x.front(), s.x.back()}; }
template <class Endless>
Interval extent(const Endless&) {
  return everywhere;
}

/// Returns the farthest place between `inside`, which is in contact, and `outside` that still is.
double last_in_contact(const Indenter& indenter, double depth, double inside, double outside) {
  if (profile_height(indenter, outside) <= depth) return outside;
  for (int pass = 0; pass < 60; ++pass) {
    const double middle = (inside + outside) / 2;
    (profile_height(indenter, middle) <= depth ? inside : outside) = middle;
  }
  return inside;
}

}  // namespace

Interval indenter_extent(const Indenter& indenter) {
  const Interval shape = std::visit([](const auto& s) { return extent(s); }, indenter.shape);
  return {shape.left + indenter.position, shape.right + indenter.position};
}

Interval rigid_contact(const Indenter& indenter, double depth, Interval room) {
  const Interval edges = indenter_extent(indenter), lowest = lowest_part(indenter);
  room = {std::max(room.left, edges.left), std::min(room.right, edges.right)};
  const auto inside = [&](double x) { return std::clamp(x, room.left, room.right); };
  return {last_in_contact(indenter, depth, inside(lowest.left), room.left),
          last_in_contact(indenter, depth, inside(lowest.right), room.right)};
}

Indenter with_hull(const Indenter& indenter) {
  Indenter result = indenter;
  if (auto* measured = std::get_if<Profile>(&result.shape)) *measured = convex_profile(*measured);
  return result;
}

}  // namespace tactel::fem
