// SPDX-License-Identifier: Apache-2.0

// Skins that stand out in their middle: a flat layer under what lies between skin and object.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fem/numbers/angles.h"
#include "fem/numbers/value_error.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_mix.h"
#include "fem/pad/pad_search.h"
#include "fem/pad/pad_solver.h"
#include "fem/pad/pad_surface.h"
#include "tests/fem/pad/named_pad_scenes.h"

namespace tactel::fem::curved_skin_test {

// x^2 / (2 r) + (x + p)^2 / (2 R) has its least at -p r / (r + R), and the curvatures 1 / r and 1 / R add up.
TEST(CurvedSkin, AParaboloidIsAnotherOneElsewhere) {
  const double R = 12, p = 1.5, q = -0.75;
  const std::array r{8.0, 5.0};
  PadScene curved = scene_of(Paraboloid{r}, 0.2, 2, 0.45, 0.5, {{0.05, 0.02, 0}, {0.1, 0.04, 0}}), flat = curved;
  curved.sensor.curvature_radius = R;
  curved.indenter.position = {p, q};
  flat.indenter.shape = Paraboloid{{1 / (1 / r[0] + 1 / R), 1 / (1 / r[1] + 1 / R)}};
  flat.indenter.position = {p * R / (R + r[0]), q * R / (R + r[1])};
  const PadLayer layer = pad_layer(0.45);
  const PadLayout laid = lay_cells(flat, layer, 12, false);
  PadCells shifted = laid.cells;
  shifted.x_middle += flat.indenter.position[0] - p, shifted.y_middle += flat.indenter.position[1] - q;
  PadScene seen = curved;
  seen.indenter = over_skin(curved.indenter, curved.sensor);
  const PadSolver solver(layer, {.tolerance = 1e-8});
  const PadSolution a = solver.solve_on(shifted, seen), b = solver.solve_on(laid.cells, flat);
  for (std::size_t k = 0; k < b.steps.size(); ++k) {
    EXPECT_NEAR(a.steps[k].P, b.steps[k].P, 1e-6 * b.steps[k].P);
    EXPECT_NEAR(a.steps[k].Q[0], b.steps[k].Q[0], 1e-6 * b.steps[k].P);
    EXPECT_LT((a.steps[k].stress - b.steps[k].stress).cwiseAbs().maxCoeff(), 1e-6);
  }
  // By its own search, whose cells end elsewhere.
  EXPECT_NEAR(solver.solve(curved).steps.back().P / b.steps.back().P, 1, 0.005);
  const PadIndenter over = over_skin(curved.indenter, curved.sensor);
  for (const double x : {-1.0, 0.0, 2.5})
    EXPECT_NEAR(pad_height(over, x, 0.4),
                pad_height(flat.indenter, x + p - flat.indenter.position[0], 0.4 + q - flat.indenter.position[1]),
                1e-9);
}

TEST(CurvedSkin, HeightsAreCountedFromFirstTouch) {
  const PadSensor flat{.thickness = 2};
  PadMix mix(5, &flat);
  for (int k = 0; k < 60; ++k) {
    PadScene scene = mix();
    scene.sensor.curvature_radius = 10 + k;
    scene.indenter.position = {0.1 * (k % 7), -0.2 * (k % 5)};
    const PadIndenter over = over_skin(scene.indenter, scene.sensor);
    const PadBox section = rigid_section(over, 0.3);
    double least = 1, most = 0;
    for (double x = -15; x <= 15; x += 0.05)
      for (double y = -15; y <= 15; y += 0.05) {
        const double h = pad_height(over, x, y);
        least = std::min(least, h);
        if (h > 0.3) continue;
        const double beyond =
            std::max({section.x.left - x, x - section.x.right, section.y.left - y, y - section.y.right});
        most = std::max(most, beyond);
      }
    EXPECT_GE(least, -1e-9) << k << shape_name(scene.indenter.shape);
    EXPECT_LE(least, 0.02) << k << shape_name(scene.indenter.shape);  // of points so far apart
    EXPECT_LE(most, 1e-9) << k << shape_name(scene.indenter.shape);
  }
}

/// The curved layer of rubber itself under a plate without friction, nu 0.48, large deformation (CalculiX, CAX8R,
/// neo-Hooke), H = E = 1. What the flat layer bears more is what the product states.
TEST(CurvedSkin, BearsALittleMoreThanTheCurvedLayer) {
  for (const auto& [radius, P, low, high] : {std::tuple{10.0, 1.806, 1.04, 1.08}, {20.0, 4.571, 1.0, 1.04}}) {
    PadScene scene = scene_of(Box{{8, 8}, 0}, 0.15, 1, 0.48, 0, {});
    scene.sensor.curvature_radius = radius;
    const PadLayer layer = pad_layer(0.48);
    const PadStep step = PadSolver(layer, {.cells = 24}).solve(scene).steps.back();
    EXPECT_GT(step.P / P, low) << radius;
    EXPECT_LT(step.P / P, high) << radius;
  }
}

TEST(CurvedSkin, CellsOfAWidePunchLieOverWhatTouches) {
  PadScene scene = scene_of(Punch{6, 0}, 0.05, 1, 0.48, 0.5, {}), ball = scene;
  scene.sensor.curvature_radius = 8;
  ball.indenter.shape = Paraboloid{{8, 8}};
  const PadLayer layer = pad_layer(0.48);
  const PadStep of_punch = PadSolver(layer).solve(scene).steps.back(),
                of_ball = PadSolver(layer).solve(ball).steps.back();
  EXPECT_EQ(of_punch.across, of_ball.across);
  EXPECT_NEAR(of_punch.P, of_ball.P, 1e-6 * of_ball.P);
}

TEST(CurvedSkin, FallsBelowAnObjectOverFixedCells) {
  PadSensor sensor{.thickness = 2, .curvature_radius = 10};
  const PadCells cells = fixed_cells(8, 0.5);
  PadSurface surface = pad_surface(cells, {.shape = Box{{5, 5}, 0}}, {0, 0}, 0);
  add_skin(sensor, cells, surface.height);
  for (int i = 0; i < cells.count(); ++i)
    EXPECT_DOUBLE_EQ(surface.height[i], (std::pow(cells.x(i / 8), 2) + std::pow(cells.y(i % 8), 2)) / 20);
}

TEST(CurvedSkin, SaysWhatItDoesNotServe) {
  const auto key = [](const PadSensor& sensor) -> std::string {
    try {
      validate(sensor);
    } catch (const ValueError& error) {
      return error.key + ": " + error.allowed;
    }
    return "";
  };
  EXPECT_EQ(key({.thickness = 2, .curvature_radius = 10}), "");
  EXPECT_NE(key({.thickness = 2, .curvature_radius = 9.9}).find("sensor.curvature_radius: 5 thicknesses"),
            std::string::npos);
  EXPECT_NE(key({.thickness = 2, .curvature_radius = std::nan("")}), "");
  const PadSensor sides{.thickness = 2, .length = 30, .width = 30, .curvature_radius = 10};
  EXPECT_NE(key(sides).find("or sensor.sides = \"held\""), std::string::npos);
}

}  // namespace tactel::fem::curved_skin_test
