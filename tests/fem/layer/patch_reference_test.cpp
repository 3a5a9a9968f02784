// SPDX-License-Identifier: Apache-2.0

// The judge of patches against closed forms of a half-plane and the whole mesh; patches of 12 elements against it.
#include "fem/layer/patch_reference.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/gap/gap_condensed.h"
#include "fem/layer/element_compliance.h"
#include "fem/layer/patch_solver.h"
#include "fem/layer/strip_compliance.h"
#include "fem/numbers/cache_directory.h"
#include "layer_sensors.h"

namespace tactel::fem::patch_reference_test {

constexpr double pi = std::numbers::pi;
constexpr double incompressible = 0.5 - 1e-9;  // no coupling on a half-plane

Load by_depth(double depth, std::vector<double> tangential) {
  return {.indentation = {depth}, .tangential = std::move(tangential)};
}
Load given_force(double force) { return {.indentation = {}, .normal_force = {force}}; }

TEST(StripCompliance, IsThatOfEqualElements) {
  const LayerTable table(0.3, 10);
  const ElementCompliance equal = element_compliance(table, 1.5, 0.2, 5);
  for (int k = -4; k < 5; ++k) {
    const SmoothParts c = strip_compliance(table, 1.5, 0.2 * k, 0.2);
    EXPECT_NEAR(c.yy, equal.yy[std::abs(k)], 1e-13);
    EXPECT_NEAR(c.xx, equal.xx[std::abs(k)], 1e-13);
    EXPECT_NEAR(c.xy, k < 0 ? -equal.xy[-k] : equal.xy[k], 1e-13);
  }
}

TEST(GradedElements, CoverTheContact) {
  for (const bool left : {false, true})
    for (const bool right : {false, true}) {
      const UnequalElements e = graded_elements({-1, 2}, left, right, 30);
      EXPECT_NEAR(e.width.sum(), 3, 1e-12);
      EXPECT_NEAR(e.middle[0] - e.width[0] / 2, -1, 1e-12);
      EXPECT_NEAR(e.middle[29] + e.width[29] / 2, 2, 1e-12);
      EXPECT_EQ(e.width[0] < 0.02, left);
      EXPECT_EQ(e.width[29] < 0.02, right);
    }
}

TEST(PatchReference, Hertz) {
  // a^2 = 4 P R (1 - nu^2) / (pi E); K. L. Johnson, Contact Mechanics (1985), (4.43) to (4.45).
  const LayerModel& model = half_plane(incompressible);
  const double a = 0.5, radius = 50, P = pi * 2 / 0.75 * a * a / (4 * radius), peak = 2 * P / (pi * a);
  const PatchReference reference(model, {.elements = 120, .pressing_increments = 1});
  const ContactSolution solution = reference.solve(scene_on(model, Parabola{radius}, 0.1, 0, given_force(P)));
  const ContactStep& step = solution.steps.back();
  EXPECT_TRUE(step.converged);
  const double width = solution.surface_x[1] - solution.surface_x[0];
  for (Eigen::Index i = 0; i < 120; ++i) {
    const double x = solution.surface_x[i] - 0.1;
    if (std::abs(x) > 0.9 * a) continue;
    EXPECT_NEAR(step.normal_force[i] / width, peak * std::sqrt(1 - x * x / (a * a)), 3e-3 * peak) << x;
  }
}

TEST(PatchReference, CattaneoMindlin) {
  // Constant P, Q by dragging: stick within c = a sqrt(1 - Q / (mu P)); Johnson (7.28).
  const LayerModel& model = half_plane(incompressible);
  const double a = 0.5, radius = 50, mu = 0.2, P = pi * 2 / 0.75 * a * a / (4 * radius);
  Scene scene = scene_on(model, Parabola{radius}, 0, mu, given_force(P));
  const PatchReference reference(model, {.elements = 120, .pressing_increments = 1});
  // In steps, so that one scene shows many ratios: the law holds at each, loading only.
  for (int k = 1; k <= 12; ++k) scene.load.tangential.push_back(0.0008 * k);
  const ContactSolution solution = reference.solve(scene);
  const double width = solution.surface_x[1] - solution.surface_x[0];
  int compared = 0;
  for (std::size_t k = 1; k < solution.steps.size(); ++k) {
    const ContactStep& step = solution.steps[k];
    EXPECT_TRUE(step.converged);
    if (*step.slip_index > 0.95) continue;
    double stick = 0;
    for (const GapStatus status : step.status) stick += status == GapStatus::stick ? width / 2 : 0;
    EXPECT_NEAR(stick, a * std::sqrt(1 - *step.slip_index), 1.5 * width) << *step.slip_index;
    ++compared;
  }
  EXPECT_GE(compared, 4);
}

TEST(PatchReference, FlatPunchHasItsSingularEdges) {
  // Frictionless on a half-plane: p = P / (pi sqrt(a^2 - x^2)); Johnson (2.64).
  const LayerModel& model = half_plane(0.3);
  const double a = 0.8;
  const Scene scene = scene_on(model, Flat{a}, 0, 0, given_force(0.3));
  const ContactSolution solution = PatchReference(model, {.elements = 80, .pressing_increments = 1}).solve(scene);
  const UnequalElements elements = graded_elements({-a, a}, true, true, 80);
  const ContactStep& step = solution.steps.back();
  EXPECT_TRUE(step.converged);
  for (Eigen::Index i = 2; i + 2 < 80; ++i) {
    const double from = elements.middle[i] - elements.width[i] / 2, to = from + elements.width[i];
    const double force = 0.3 / pi * (std::asin(to / a) - std::asin(from / a));
    EXPECT_NEAR(step.normal_force[i], force, 4e-3 * force) << elements.middle[i];
  }
}

TEST(PatchReference, AgreesWithTheWholeMesh) {
  Sensor sensor;
  const LayerModel model = layer_model(sensor);
  Sensor fine = sensor;
  fine.columns = 161;
  fine.rows = 25;
  const Condensation mesh = condense_cached(fine, default_cache_directory());
  Scene scene{"", sensor, {Exponential{0.1, 0.6}, -1.3}, 0.6, by_depth(0.2, {0.1, 0.3, 0.1})};
  const ContactSolution found = PatchReference(model, {.elements = 80, .pressing_increments = 8}).solve(scene);
  scene.load.indentation_steps = 8;
  scene.sensor = fine;
  const ContactSolution truth = GapCondensed(mesh).solve(scene);
  ASSERT_EQ(found.steps.size() + 7, truth.steps.size());
  for (std::size_t k = 0; k < found.steps.size(); ++k) {
    EXPECT_TRUE(found.steps[k].converged);
    EXPECT_NEAR(*found.steps[k].slip_index, *truth.steps[k + 7].slip_index, 1.5e-3);
    EXPECT_NEAR(found.steps[k].P / truth.steps[k + 7].P, 1, 3e-3);
    const double largest = truth.steps[k + 7].sigma_y.cwiseAbs().maxCoeff();
    for (Eigen::Index t = 1; t + 1 < found.tactel_x.size(); ++t) {
      EXPECT_NEAR(found.steps[k].sigma_y[t], truth.steps[k + 7].sigma_y[t], 5e-3 * largest);
      EXPECT_NEAR(found.steps[k].tau_xy[t], truth.steps[k + 7].tau_xy[t], 5e-3 * largest);
    }
  }
}

TEST(PatchReference, TwelveElementsAreNear) {
  // One scene of each shape; over a random mix the 95 % quantile of the error of S is 0.012, the largest 0.025.
  const Shape shapes[] = {Flat{2.0},          Wedge{160},        Parabola{10},       Cylinder{30},
                          Exponential{.1, 1}, Trapezoid{1, 0.5}, RoundedFlat{1, 10}, Taylor{{2, 3}, 10.0, 2.0, {}}};
  const LayerModel& model = endless(0.45);
  const PatchReference reference(model, {.elements = 80});
  for (const Shape& shape : shapes) {
    const Scene scene = scene_on(model, shape, 0.7, 0.5, by_depth(0.15, {0.03, 0.08, 0.15, 0.08}));
    const ContactSolution truth = reference.solve(scene), found = PatchSolver(model).solve(scene);
    ASSERT_EQ(truth.steps.size(), found.steps.size());
    for (std::size_t k = 0; k < truth.steps.size(); ++k) {
      EXPECT_TRUE(truth.steps[k].converged && found.steps[k].converged) << shape_name(shape);
      EXPECT_NEAR(*found.steps[k].slip_index, *truth.steps[k].slip_index, 0.02) << shape_name(shape) << k;
      EXPECT_NEAR(found.steps[k].P / truth.steps[k].P, 1, 0.04) << shape_name(shape) << k;
    }
  }
}

TEST(PatchReference, TheEdgeRuleKeepsTheForceOfAFlat) {
  const LayerModel& model = endless(0.45);
  const Scene scene = scene_on(model, Flat{2.0}, 0, 0.3, by_depth(0.1, {}));
  const double truth = PatchReference(model, {.elements = 100, .pressing_increments = 4}).solve(scene).steps[0].P;
  for (const int elements : {8, 12, 16})
    EXPECT_NEAR(PatchSolver(model, {.elements = elements}).solve(scene).steps[0].P / truth, 1, 0.006) << elements;
}

}  // namespace tactel::fem::patch_reference_test
