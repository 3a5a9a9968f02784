// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/patch_search.h"

#include <algorithm>
#include <cmath>

#include "fem/layer/element_compliance.h"
#include "fem/layer/frictionless_pressing.h"
#include "fem/layer/rigid_contact.h"

namespace tactel::fem {
namespace {

/// One round: what presses in a window.
struct Pressed {
  Interval extent;                   ///< outer edges of the outermost pressed elements, mm; the window where none does
  bool first = false, last = false;  ///< the window's outermost elements press
  double width;                      ///< of an element, mm
  double force;                      ///< sum of the forces over E, mm
};

Pressed press(const Scene& scene, const LayerTable& table, Interval window, double depth) {
  const Patch elements{window.left, window.right, search_elements};
  const double d = elements.width();
  const Eigen::VectorXd compliance = element_compliance(table, scene.sensor.thickness, d, search_elements).yy;
  const Eigen::VectorXd gap = profile_heights(scene.indenter, places(elements)).array() - depth;
  const Eigen::VectorXd n = frictionless_pressing(compliance, gap, search_tolerance, search_most_sweeps);
  int first = 0, last = search_elements - 1;
  while (first < last && !(n[first] > 0)) ++first;
  while (last > first && !(n[last] > 0)) --last;
  if (!(n[first] > 0)) return {window, false, false, d, 0};
  return {{window.left + first * d, window.right - (search_elements - 1 - last) * d},
          first == 0,
          last == search_elements - 1,
          d,
          n.sum()};
}

/// The next window around what pressed.
Interval next_window(const Pressed& pressed, const PatchLimits& limits) {
  const double width = pressed.extent.right - pressed.extent.left;
  const auto margin = [&](bool outermost) { return outermost ? search_growth * width : search_margin * pressed.width; };
  return {std::max({pressed.extent.left - margin(pressed.first), limits.sensor.left, limits.indenter.left}),
          std::min({pressed.extent.right + margin(pressed.last), limits.sensor.right, limits.indenter.right})};
}

/// A scene that touches nothing: some elements below the profile's lowest part.
Interval untouched(const Scene& scene, const PatchLimits& limits) {
  const Interval lowest = rigid_contact(scene.indenter, 0, limits.sensor);
  const double least = 1e-3 * scene.sensor.thickness;
  if (lowest.right - lowest.left >= least) return lowest;
  const double middle = std::clamp(lowest.left, limits.sensor.left + least, limits.sensor.right - least);
  return {middle - least, middle + least};
}

}  // namespace

PatchLimits patch_limits(const Scene& scene) {
  const double half = scene.sensor.length / 2;
  return {{-half, half}, indenter_extent(scene.indenter)};
}

PatchSearch find_patch_at(double depth, const Scene& scene, const LayerTable& table, int elements) {
  const PatchLimits limits = patch_limits(scene);
  Interval window = rigid_contact(scene.indenter, depth, limits.sensor);
  if (!(depth > 0 && window.right > window.left))
    return {make_patch(untouched(scene, limits), limits, elements), depth, 0};
  Pressed pressed{};
  for (int round = 0; round < search_rounds; ++round) {
    if (round > 0) window = next_window(pressed, limits);
    pressed = press(scene, table, window, depth);
  }
  const double margin = patch_margin * (pressed.extent.right - pressed.extent.left);
  const Interval contact{pressed.extent.left - margin, pressed.extent.right + margin};
  return {make_patch(contact, limits, elements), depth, pressed.force * scene.sensor.young};
}

PatchSearch find_patch(const Scene& scene, const LayerTable& table, int elements) {
  const auto largest = [](const std::vector<double>& targets) {
    return *std::max_element(targets.begin(), targets.end());
  };
  if (!by_force(scene)) return find_patch_at(largest(scene.load.indentation), scene, table, elements);
  const double wanted = largest(scene.load.normal_force);
  if (!(wanted > 0)) return find_patch_at(0, scene, table, elements);
  PatchSearch found = find_patch_at(0.3 * wanted / scene.sensor.young, scene, table, elements), before = found;
  double power = 1;  // P ~ depth^power: 1 below a flat, 2 for a wedge on a thick layer, more on a thin one
  for (int trial = 1; trial < search_most_depths; ++trial) {
    if (std::abs(found.P - wanted) <= search_force_error * wanted) break;
    if (trial > 1 && found.depth != before.depth)
      power = std::clamp(std::log(found.P / before.P) / std::log(found.depth / before.depth), 0.5, 4.0);
    before = found;
    const double factor = std::clamp(std::pow(wanted / found.P, 1 / power), 0.1, 10.0);
    found = find_patch_at(found.depth * factor, scene, table, elements);
  }
  return found;
}

}  // namespace tactel::fem
