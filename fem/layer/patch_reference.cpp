// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/patch_reference.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/layer/end_mesh.h"
#include "fem/layer/linear_elements.h"
#include "fem/layer/patch_compliance.h"
#include "fem/layer/patch_exact.h"
#include "fem/layer/patch_search.h"
#include "fem/layer/rigid_contact.h"
#include "fem/layer/strip_compliance.h"

namespace tactel::fem {
namespace {

/// Share of its width by which a patch grows on a side whose outermost element presses.
constexpr double growth = 0.15;
constexpr int most_growths = 8, usual_increments = 20;

/// Where the elements lie: without the overhang of equal elements beyond an edge.
Interval contact_of(const Patch& patch, const PatchLimits& limits) {
  return {patch.edge_left ? limits.indenter.left : patch.left, patch.edge_right ? limits.indenter.right : patch.right};
}

bool presses(const ContactSolution& solution, Eigen::Index element) {
  return std::any_of(solution.steps.begin(), solution.steps.end(),
                     [&](const ContactStep& step) { return step.normal_force[element] > 0; });
}

/// The ends of elements, and how far each reaches to its neighbours' halves: the gap elements of a mesh.
UnequalElements nodes_of(const UnequalElements& elements) {
  const Eigen::Index n = elements.middle.size();
  UnequalElements nodes{Eigen::VectorXd(n + 1), Eigen::VectorXd::Zero(n + 1)};
  nodes.middle << elements.middle[0] - elements.width[0] / 2, elements.middle + elements.width / 2;
  nodes.width.head(n) += elements.width / 2, nodes.width.tail(n) += elements.width / 2;
  return nodes;
}

}  // namespace

UnequalElements graded_elements(Interval contact, bool edge_left, bool edge_right, int elements) {
  const double width = contact.right - contact.left, quarter = std::numbers::pi / 2;
  const auto end = [&](int k) {
    const double s = static_cast<double>(k) / elements;
    double share = s;
    if (edge_left && edge_right) share = (1 - std::cos(2 * quarter * s)) / 2;
    if (edge_left && !edge_right) share = 1 - std::cos(quarter * s);
    if (!edge_left && edge_right) share = std::sin(quarter * s);
    return contact.left + share * width;
  };
  UnequalElements result{Eigen::VectorXd(elements), Eigen::VectorXd(elements)};
  for (int k = 0; k < elements; ++k) {
    result.middle[k] = (end(k) + end(k + 1)) / 2;
    result.width[k] = end(k + 1) - end(k);
  }
  return result;
}

Condensation elements_condensation(const LayerModel& model, const UnequalElements& elements) {
  const Eigen::Index n = elements.middle.size();
  Condensation result = without_compliance(model, elements.middle);
  std::vector<FreeSides::At> sides;
  for (const double x : elements.middle) sides.push_back(model.sides.at(x));
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = 0; i < n; ++i) {
      const FreeSides::At &at = sides[static_cast<std::size_t>(i)], &by = sides[static_cast<std::size_t>(j)];
      const SmoothParts c = strip_compliance(model.table, model.sensor.thickness,
                                             elements.middle[i] - elements.middle[j], elements.width[j]);
      result.compliance.block<2, 2>(2 * i, 2 * j) << c.xx + model.sides.between(at.x, by.x),
          c.xy + model.sides.between(at.x, by.y), -c.xy + model.sides.between(at.y, by.x),
          c.yy + model.sides.between(at.y, by.y);
    }
  return result;
}

PatchReference::PatchReference(const LayerModel& model, const PatchOptions& options)
    : model_(model), options_(options) {}

ContactSolution PatchReference::solve(const Scene& scene) const {
  scene.validate();
  require_sensor_of(model_, scene.sensor);
  Scene fine = scene;
  fine.indenter = with_hull(scene.indenter);
  const PatchLimits limits = patch_limits(fine);
  Patch patch = find_patch(fine, model_.table, options_.elements).patch;
  const int increments = options_.pressing_increments > 0 ? options_.pressing_increments : usual_increments;
  GapReferenceOptions exact;
  if (options_.accept > 0) exact.tolerance = options_.accept;
  for (int growths = 0;; ++growths) {
    UnequalElements elements =
        graded_elements(contact_of(patch, limits), patch.edge_left, patch.edge_right, options_.elements);
    const bool linear = options_.linear || needs_linear_pressure(scene.sensor, elements.width.maxCoeff());
    const bool at_end = !linear && !model_.sides.endless() && near_end(scene.sensor, {patch.left, patch.right}) &&
                        patch.width() <= widest_node_distance * scene.sensor.thickness;
    if (at_end) elements = nodes_of(elements);
    ContactSolution solution = solve_in_increments(at_end   ? end_condensation(model_, elements.middle)
                                                   : linear ? linear_condensation(model_, elements)
                                                            : elements_condensation(model_, elements),
                                                   fine, increments, exact);
    const bool left = !patch.edge_left && !patch.reaches_left && presses(solution, 0);
    const bool right = !patch.edge_right && !patch.reaches_right && presses(solution, elements.middle.size() - 1);
    solution.surface_width = elements.width;
    solution.linear_elements = linear;
    if (!(left || right) || growths == most_growths) return solution;
    const double more = growth * (patch.right - patch.left);
    patch = make_patch({patch.left - (left ? more : 0), patch.right + (right ? more : 0)}, limits, options_.elements);
  }
}

}  // namespace tactel::fem
