// SPDX-License-Identifier: Apache-2.0

// The patch of a scene: clipping and margins by hand, the contact's width against closed forms.
#include "fem/layer/patch_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "fem/gap/gap_condensed.h"
#include "fem/layer/frictionless_pressing.h"
#include "fem/layer/patch_compliance.h"
#include "layer_sensors.h"

namespace tactel::fem::patch_search_test {

constexpr double infinity = std::numeric_limits<double>::infinity();

Load pressing(double depth) { return {.indentation = {depth}}; }

TEST(Patch, OverhangsTheEdgesThatPress) {
  // d = 2 a / (n - 2 e): n elements over the punch and 0.15 of an element beyond each edge.
  const Patch patch = make_patch({-2, 2}, {{-10, 10}, {-2, 2}}, 12);
  EXPECT_TRUE(patch.edge_left && patch.edge_right);
  EXPECT_NEAR(patch.width(), 4 / (12 - 0.3), 1e-14);
  EXPECT_NEAR(patch.left, -2 - 0.15 * patch.width(), 1e-14);
  EXPECT_NEAR(patch.right, 2 + 0.15 * patch.width(), 1e-14);
  EXPECT_FALSE(patch.reaches_left || patch.reaches_right);
}

TEST(Patch, EndsWithTheSensor) {
  const Patch wide = make_patch({-40, 40}, {{-10, 10}, {-infinity, infinity}}, 8);
  EXPECT_EQ(wide.left, -10);
  EXPECT_EQ(wide.right, 10);
  EXPECT_TRUE(wide.reaches_left && wide.reaches_right);
  EXPECT_FALSE(wide.edge_left || wide.edge_right);
  // Left end off the rubber, right end an edge on it.
  const Patch half = make_patch({-40, -7}, {{-10, 10}, {-13, -7}}, 8);
  EXPECT_TRUE(half.reaches_left && half.edge_right && !half.edge_left && !half.reaches_right);
  EXPECT_NEAR(half.right, -7 + 0.15 * half.width(), 1e-14);
  // An edge nearer to the end than its overhang.
  const Patch close = make_patch({-2, 9.99}, {{-10, 10}, {-2, 9.99}}, 8);
  EXPECT_EQ(close.right, 10);
  EXPECT_TRUE(close.reaches_right);
}

TEST(Patch, PlacesAreTheMiddlesOfElements) {
  const Patch patch{-1, 2, 3};
  EXPECT_EQ(places(patch), Eigen::Vector3d(-0.5, 0.5, 1.5));
  EXPECT_EQ(patch.place(-1), -1.5);
  EXPECT_EQ(patch.place(3), 2.5);
}

TEST(FrictionlessPressing, TwoElementsByHand) {
  const Eigen::Vector2d compliance(2, 1);
  // Both press: 2 n0 + n1 = 3, n0 + 2 n1 = 3.
  EXPECT_TRUE(frictionless_pressing(compliance, Eigen::Vector2d(-3, -3), 1e-14, 200).isApprox(Eigen::Vector2d(1, 1)));
  // The second would have to pull: 2 n0 = 3, and the gap there is 0.4 + 1.5 - 1.
  const Eigen::VectorXd one = frictionless_pressing(compliance, Eigen::Vector2d(-3, -1), 1e-14, 200);
  EXPECT_NEAR(one[0], 1.5, 1e-13);
  EXPECT_EQ(one[1], 0);
  EXPECT_TRUE(frictionless_pressing(compliance, Eigen::Vector2d(0.1, 0), 1e-14, 200).isZero(0));
}

TEST(PatchSearch, HoldsHertzContactTightly) {
  // Half-plane: a^2 = 4 P R / (pi E*), E* = E / (1 - nu^2). The patch holds [-a, a]; 6 % more and an element of the
  // search (a sixth of a window) on each side is all it may add.
  for (const double P : {0.02, 0.1, 0.5}) {
    const LayerModel& model = half_plane(0.3);
    const Scene scene = scene_on(model, Parabola{5}, 0.7, 0, {.indentation = {}, .normal_force = {P}});
    const PatchSearch found = find_patch(scene, model.table, 12);
    const double a = std::sqrt(4 * P * 5 * (1 - 0.09) / (std::numbers::pi * 2));
    EXPECT_NEAR(found.P, P, 0.02 * P);
    EXPECT_LT(found.patch.left, 0.7 - a * 0.97);  // 1 % of P is half of that in a; an element's edge may lie inside
    EXPECT_GT(found.patch.right, 0.7 + a * 0.97);
    EXPECT_LT(found.patch.right - found.patch.left, 2.7 * a);
  }
}

// The contact without friction on many elements of a wide patch, the judge of the search.
Interval contact_without_friction(const Scene& scene, const LayerModel& model, const Patch& patch) {
  const double middle = (patch.left + patch.right) / 2, half = patch.right - patch.left;
  Patch wide = make_patch({middle - half, middle + half}, patch_limits(scene), 160);
  Scene smooth = scene;
  smooth.friction = 0;
  const ContactSolution solution = GapCondensed(patch_condensation(model, wide)).solve(smooth);
  EXPECT_TRUE(solution.steps.back().converged);
  Interval contact{infinity, -infinity};
  for (Eigen::Index i = 0; i < wide.elements; ++i)
    if (solution.steps.back().normal_force[i] > 0) {
      contact.left = std::min(contact.left, wide.place(static_cast<int>(i)) - wide.width() / 2);
      contact.right = std::max(contact.right, wide.place(static_cast<int>(i)) + wide.width() / 2);
    }
  return contact;
}

TEST(PatchSearch, HoldsTheContactOfEveryShape) {
  const Shape shapes[] = {Flat{2.0},          Wedge{150},
                          Parabola{10},       Cylinder{30},
                          Exponential{.1, 1}, Trapezoid{1, 0.5},
                          RoundedFlat{1, 10}, Taylor{{2, 3}, 10.0, 2.0, {}},
                          Cylinder{0.15},     Profile{{-3, -1, 0, 2}, {0.3, 0, 0, 0.5}, 0, ""}};
  for (const double nu : {0.3, 0.499})
    for (const Shape& shape : shapes) {
      SCOPED_TRACE(testing::Message() << shape_name(shape) << " nu " << nu);
      const LayerModel& model = endless(nu);
      const Scene scene = scene_on(model, shape, -2.5, 0.4, pressing(0.2));
      const Patch patch = find_patch(scene, model.table, 12).patch;
      const Interval contact = contact_without_friction(scene, model, patch);
      const double width = contact.right - contact.left;
      EXPECT_LT(patch.left, contact.left + 0.04 * width);
      EXPECT_GT(patch.right, contact.right - 0.04 * width);
      EXPECT_LT(patch.right - patch.left, 1.35 * width);
    }
}

TEST(PatchSearch, UntouchedScenesHaveAPatch) {
  const LayerModel& model = endless(0.45);
  for (const Shape& shape : {Shape(Parabola{10}), Shape(Flat{2.0}), Shape(Flat{})}) {
    const Patch patch = find_patch(scene_on(model, shape, 9.9, 0.4, pressing(0)), model.table, 12).patch;
    EXPECT_GT(patch.width(), 0) << shape_name(shape);
    EXPECT_GE(patch.left, -10);
    EXPECT_LE(patch.right, 10);
  }
}

TEST(PatchSearch, FindsTheDepthOfAForce) {
  for (const Shape& shape : {Shape(Parabola{10}), Shape(Flat{2.0}), Shape(Wedge{160}), Shape(Flat{})}) {
    const LayerModel& model = endless(0.45);
    const Load load{.indentation = {}, .normal_force = {0.2, 0.8, 0.1}};
    const PatchSearch found = find_patch(scene_on(model, shape, 0.3, 0.4, load), model.table, 12);
    EXPECT_NEAR(found.P, 0.8, 0.02 * 0.8) << shape_name(shape);
  }
}

}  // namespace tactel::fem::patch_search_test
