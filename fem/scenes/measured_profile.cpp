// SPDX-License-Identifier: Apache-2.0
#include "fem/scenes/measured_profile.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/numbers/number_text.h"
#include "fem/numbers/value_error.h"

namespace tactel::fem {
namespace {

// Points on a straight line, written in decimals, miss it by rounding; no measurement is that fine. mm
constexpr double convexity_rounding = 1e-9;

/// Andrew's monotone chain (1979), lower half: the points whose chain only ever turns to the left.
Profile lower_hull(const Profile& profile) {
  Profile hull;
  hull.x.reserve(profile.x.size()), hull.y.reserve(profile.x.size());
  for (std::size_t i = 0; i < profile.x.size(); ++i) {
    const auto turns_left = [&] {
      const std::size_t n = hull.x.size();
      return (hull.x[n - 1] - hull.x[n - 2]) * (profile.y[i] - hull.y[n - 2]) >
             (hull.y[n - 1] - hull.y[n - 2]) * (profile.x[i] - hull.x[n - 2]);
    };
    while (hull.x.size() >= 2 && !turns_left()) hull.x.pop_back(), hull.y.pop_back();
    hull.x.push_back(profile.x[i]);
    hull.y.push_back(profile.y[i]);
  }
  return hull;
}

void check_points(const Profile& profile) {
  const auto finite = [](const std::vector<double>& v) {
    return std::all_of(v.begin(), v.end(), [](double a) { return std::isfinite(a) && std::abs(a) <= 1e6; });
  };
  const auto text = [](const std::vector<double>& v) { return number_text(v.data(), v.size()); };
  if (profile.x.size() < 2) throw ValueError("indenter.x", text(profile.x), "at least two points");
  if (profile.y.size() != profile.x.size())
    throw ValueError("indenter.y", text(profile.y),
                     "as many heights as there are x: " + std::to_string(profile.x.size()));
  if (!finite(profile.x)) throw ValueError("indenter.x", text(profile.x), "finite positions in mm, none beyond 1e6");
  if (!finite(profile.y)) throw ValueError("indenter.y", text(profile.y), "finite heights in mm, none beyond 1e6");
  for (std::size_t i = 1; i < profile.x.size(); ++i)
    if (!(profile.x[i] > profile.x[i - 1]))
      throw ValueError("indenter.x", number_text(profile.x[i]) + " after " + number_text(profile.x[i - 1]),
                       "strictly increasing");
  const auto [lowest, highest] = std::ranges::minmax(profile.y);
  check_range(profile.file.empty() ? "indenter.y" : "indenter.file", highest - lowest,
              profile.x.back() - profile.x.front());
}

std::string dents(const std::vector<NonConvexity>& found) {
  constexpr std::size_t most = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(most, found.size()); ++i)
    text += (i ? ", " : "") + number_text(found[i].height) + " mm at x = " + number_text(found[i].x);
  return found.size() > most ? text + " and " + std::to_string(found.size() - most) + " more" : text;
}

}  // namespace

void check_range(const std::string& key, double range, double width) {
  if (range <= 10 * width) return;
  throw ValueError(key, number_text(range) + " mm of heights over " + number_text(width) + " mm",
                   "at most ten times as high as wide: heights in mm, and no number such as -9999 for a missing point; "
                   "fill it from its neighbours");
}

std::vector<NonConvexity> non_convexities(const Profile& profile) {
  const Profile hull = lower_hull(profile);
  std::vector<NonConvexity> found;
  for (std::size_t i = 0; i < profile.x.size(); ++i) {
    const double height = profile.y[i] - height_between_points(hull, profile.x[i]);
    if (height > convexity_rounding) found.push_back({profile.x[i], height});
  }
  std::sort(found.begin(), found.end(), [](auto& a, auto& b) { return a.height > b.height; });
  return found;
}

Profile convex_profile(const Profile& profile) {
  Profile hull = lower_hull(profile);
  const double lowest = *std::min_element(hull.y.begin(), hull.y.end());
  for (double& y : hull.y) y -= lowest;
  return hull;
}

double height_between_points(const Profile& profile, double x) {
  const auto& px = profile.x;
  if (!(x >= px.front() - edge_guard && x <= px.back() + edge_guard)) return std::numeric_limits<double>::infinity();
  x = std::clamp(x, px.front(), px.back());
  const auto right = std::clamp<std::ptrdiff_t>(std::upper_bound(px.begin(), px.end(), x) - px.begin(), 1,
                                                static_cast<std::ptrdiff_t>(px.size()) - 1);
  const auto i = static_cast<std::size_t>(right);
  const double part = (x - px[i - 1]) / (px[i] - px[i - 1]);
  return profile.y[i - 1] + part * (profile.y[i] - profile.y[i - 1]);
}

void validate(const Profile& profile) {
  if (!(profile.smooth >= 0 && std::isfinite(profile.smooth)))
    throw ValueError("indenter.smooth", number_text(profile.smooth), "a height in mm, finite and not below 0");
  check_points(profile);
  const auto found = non_convexities(profile);
  if (found.empty() || found.front().height <= profile.smooth) return;
  const auto [lowest, highest] = std::ranges::minmax(profile.y);
  const bool upside_down = found.front().height > 0.5 * (highest - lowest);
  throw ValueError(profile.file.empty() ? "indenter.y" : "indenter.file",
                   profile.file.empty() ? number_text(profile.y.data(), profile.y.size()) : profile.file,
                   "convex: points lie above the lower convex hull, by " + dents(found) +
                       "; smooth = " + number_text(found.front().height) + " (mm) or more accepts them" +
                       (upside_down ? "; is it upside down? y counts upwards from the lowest point" : ""));
}

}  // namespace tactel::fem
