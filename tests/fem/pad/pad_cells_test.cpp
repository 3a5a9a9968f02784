// SPDX-License-Identifier: Apache-2.0

// Shapes, the search for the touched rectangle, cells and their ladder.
#include "fem/pad/pad_cells.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "fem/pad/pad_mix.h"
#include "fem/pad/pad_search.h"
#include "fem/pad/pad_solver.h"
#include "tests/fem/pad/named_pad_scenes.h"

namespace tactel::fem::pad_cells_test {

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(PadShapes, Heights) {
  EXPECT_NEAR(pad_height({Sphere{5}}, 3, 0), 1, 1e-15);
  EXPECT_EQ(pad_height({Sphere{5}}, 4, 4), infinity);
  EXPECT_NEAR(pad_height({Paraboloid{{2, 4}}}, 1, 2), 0.75, 1e-15);
  EXPECT_NEAR(pad_height({LyingCylinder{5, 2}}, 3, 2), 1, 1e-15);
  EXPECT_EQ(pad_height({LyingCylinder{5, 2}}, 3, 2.1), infinity);
  EXPECT_NEAR(pad_height({Punch{1, 0.5}}, 0, 2), 1, 1e-15);
  EXPECT_EQ(pad_height({Punch{1, 0}}, 0.8, 0.8), infinity);
  EXPECT_EQ(pad_height({Punch{1, 0}}, 0.8, 0.8, true), 0);
  EXPECT_NEAR(pad_height({Box{{1, 2}, 0.5}}, 2, 4), 5, 1e-15);
  EXPECT_NEAR(pad_height({Cone{45}}, 3, 4), 5, 1e-14);
  HeightMap map{1, Eigen::MatrixXd(2, 3)};
  map.heights << 2, 0, 1, 4, 2, 6;
  EXPECT_NEAR(pad_height({map}, -0.5, 0), 0, 1e-15);
  EXPECT_NEAR(pad_height({map}, 0.25, 0.5), 0.25 * 0.5 * (0 + 1) + 0.75 * 0.5 * (2 + 6), 1e-15);
  EXPECT_EQ(pad_height({map}, 0, 1.1), infinity);
}

TEST(PadShapes, HeightsOnAGridAreThoseOfItsPlaces) {
  HeightMap map{1.5, Eigen::MatrixXd(3, 3)};
  map.heights << 2, 0, 1, 4, 2, 6, 3, 3, 3;
  std::vector<PadIndenter> indenters{{.shape = map}};
  PadMix mix(11);
  for (int k = 0; k < 9; ++k) indenters.push_back(mix().indenter);
  const Eigen::ArrayXd x = Eigen::ArrayXd::LinSpaced(7, -1.6, 1.4), y = Eigen::ArrayXd::LinSpaced(5, -0.3, 2);
  for (const PadIndenter& indenter : indenters) {
    const Eigen::MatrixXd heights = pad_heights(indenter, x, y);
    for (int i = 0; i < x.size(); ++i)
      for (int j = 0; j < y.size(); ++j) {
        const double height = pad_height(indenter, x[i], y[j], true);
        if (std::isinf(height))
          EXPECT_EQ(heights(i, j), height);
        else
          EXPECT_NEAR(heights(i, j), height, 1e-14) << indenter.shape.index() << " " << i << " " << j;
      }
  }
}

TEST(PadShapes, ATiltedBottomRisesFromItsLowestPoint) {
  // The tilted punch of the six named scenes, written out.
  PadIndenter punch{Punch{1.5, 0.5}};
  punch.tilt = 3;
  punch.tilt_direction = 30;
  const double t = std::tan(3 * std::numbers::pi / 180), c = std::sqrt(0.75);
  EXPECT_NEAR(pad_height(punch, 1.6, 0.2),
              std::pow(std::hypot(1.6, 0.2) - 1.5, 2) + t * (1.6 * c + 0.1) + 1.5 * t + t * t / 4, 1e-14);
  PadIndenter box{Box{{1, 0.5}, 0}};
  box.tilt = 3;
  box.tilt_direction = 30;
  double least = infinity, least_punch = infinity;
  for (double x = -2; x <= 2; x += 1.0 / 256)
    for (double y = -2; y <= 2; y += 1.0 / 256) {
      least = std::min(least, pad_height(box, x, y));
      least_punch = std::min(least_punch, pad_height(punch, x, y));
    }
  EXPECT_NEAR(least, 0, 1e-14);  // its corner is a point of the grid
  EXPECT_GE(least_punch, 0);
  EXPECT_NEAR(least_punch, 0, 1e-5);
}

TEST(PadShapes, RigidSectionsHoldWhatLiesBelowADepth) {
  PadMix mix(5);
  for (int k = 0; k < 18; ++k) {
    const PadScene scene = mix();
    const double d = scene.load.indentation[0];
    const PadBox box = rigid_section(scene.indenter, d);
    for (int i = 0; i <= 40; ++i)
      for (int j = 0; j <= 40; ++j) {
        const double x = (i - 20) / 15.0 * box.x.right, y = (j - 20) / 15.0 * box.y.right;
        if (!(pad_height(scene.indenter, x, y) < d)) continue;
        EXPECT_LE(std::abs(x), box.x.right * (1 + 1e-12)) << k;
        EXPECT_LE(std::abs(y), box.y.right * (1 + 1e-12)) << k;
      }
  }
}

TEST(PadSearch, FindsTheCircleOfHertz) {
  PadScene scene;
  scene.sensor.thickness = 1000;
  scene.indenter.shape = Paraboloid{{1, 1}};
  scene.load.indentation = {1e-4};
  const PadBox contact = find_pad_contact(scene, PadLayer(scene.sensor.poisson)).contact;
  const double a = 0.01;  // the rigid section is 1.41 times as wide
  EXPECT_GT(contact.x.right, a);
  EXPECT_LT(contact.x.right, 1.25 * a);
  EXPECT_NEAR(contact.x.right, contact.y.right, 1e-12);
}

TEST(PadSearch, MeetsAForce) {
  PadScene scene;
  scene.indenter.shape = Sphere{8};
  scene.load.indentation = {0.25};
  const PadLayer layer(scene.sensor.poisson);
  const PadSearch given = find_pad_contact(scene, layer);
  scene.load.indentation = {};
  scene.load.normal_force = {given.P};
  const PadSearch found = find_pad_contact(scene, layer);
  EXPECT_NEAR(found.P / given.P, 1, 0.02);
  EXPECT_NEAR(found.depth, 0.25, 0.005);
}

PadScene box_scene(double edge, double tilt = 0) {
  PadScene scene;
  scene.indenter.shape = Box{{2, 1}, edge};
  scene.indenter.tilt = tilt;
  scene.load.indentation = {0.2};
  return scene;
}

TEST(PadLayout, CellsEndAtTheRimOfABox) {
  const PadLayer layer(PadScene{}.sensor.poisson);
  const auto cells_of = [&](double edge, double tilt) {
    return lay_cells(box_scene(edge, tilt), layer, 12, true).cells;
  };
  // Both sides end as far beyond their contacts, which end as far beyond the flats; none is on the ladder.
  const PadCells fine = cells_of(0.05, 0);
  const double x = fine.box().x.right - 2 - 0.15 * fine.hx, y = fine.box().y.right - 1 - 0.15 * fine.hy;
  EXPECT_NEAR(x, y, 0.02 * fine.hy);  // h is that of the search
  EXPECT_GT(x, 0);
  // As at a sharp edge, the less the rounding: reach ~ edge^(2/3).
  const PadCells finest = cells_of(0.05 / 8, 0);
  EXPECT_NEAR((finest.box().x.right - 2 - 0.15 * finest.hx) / x, 0.25, 0.05);
  // A rounding over many cells, and a box that is touched on one side, are where the search found them.
  for (const PadScene& scene : {box_scene(30), box_scene(0.05, 8)})
    EXPECT_NEAR(lay_cells(scene, layer, 12, false).cells.box().x.right, find_pad_contact(scene, layer).contact.x.right,
                1e-12);
}

TEST(PadLayout, ARimUnderAPunchIsThatOfAHalfSpace) {
  // Pressure E' d / (pi sqrt(a^2 - r^2)) of a flat punch: E' strength / sqrt(s) with strength d / (pi sqrt(2 a)).
  const double H = 1000, a = 1, d = 0.05, edge = 0.02;
  PadScene scene;
  scene.sensor.thickness = H;
  scene.indenter.shape = Punch{a, edge};
  scene.load.indentation = {d};
  const PadLayout laid = lay_cells(scene, PadLayer(scene.sensor.poisson), 12, true);
  const Punch& sharp = std::get<Punch>(laid.indenter.shape);
  EXPECT_EQ(sharp.edge, 0);
  const double reach = std::pow(1.5 * std::numbers::pi * edge * d / (std::numbers::pi * std::sqrt(2 * a)), 2.0 / 3);
  EXPECT_NEAR((sharp.radius - a) / (0.6 * reach), 1, 0.1);  // 1.1^(2/3), and the search's P
}

TEST(PadLayout, RoundingsAboutACellCostLittle) {
  // The force hardly depends on the cells, and many cells, which resolve the rounding, give it too. As it is, the
  // rounding makes it 2 to 6 % wrong at 12 cells.
  for (const double edge : {0.05, 0.2, 0.5}) {
    const PadScene scene = box_scene(edge);
    const PadLayer layer(scene.sensor.poisson);
    const auto P = [&](int cells) {
      return PadSolver(layer, {.cells = cells, .ladder = false}).solve(scene).steps.back().P;
    };
    const double fine = P(48);
    for (const int cells : {8, 11, 12, 16}) EXPECT_NEAR(P(cells) / fine, 1, 0.015) << edge << ' ' << cells;
  }
}

TEST(PadLayout, ATiltedPunchKeepsItsForces) {
  // lay_cells turns the frame of a punch along its tilt; the stated totals are those of a frame that is not.
  const PadScene scene = tilted_punch();
  const PadLayer layer(scene.sensor.poisson);
  EXPECT_EQ(lay_cells(scene, layer, 16, false).indenter.tilt_direction, 0);
  const PadStep step = PadSolver(layer, {.cells = 16, .ladder = false}).solve(scene).steps.back();
  EXPECT_NEAR(step.P / 0.36599, 1, 0.01);  // another grid of 16 x 16 cells
  EXPECT_NEAR(step.Q[1] / 0.20514, 1, 0.02);
  EXPECT_NEAR(step.M / -0.14838, 1, 0.02);
}

// A punch is round: one that is tilted along 30 degrees of its frame is one that is turned by 30 degrees and tilted
// along x. An oblique drag tells 30 degrees from -30.
TEST(PadLayout, ATiltedPunchMayBeTurned) {
  PadScene scene = tilted_punch();
  scene.load.drags = {{0.04, 0.02, 0}};
  PadScene turned = scene;
  turned.indenter.yaw = std::exchange(turned.indenter.tilt_direction, 0);
  const PadLayer layer(scene.sensor.poisson);
  const PadSolver solver(layer, {.cells = 8, .ladder = false});
  const PadStep step = solver.solve(scene).steps.back(), same = solver.solve(turned).steps.back();
  EXPECT_NEAR(step.P, same.P, 1e-12);
  EXPECT_NEAR(step.Q[0], same.Q[0], 1e-12);
  EXPECT_NEAR(step.Q[1], same.Q[1], 1e-12);
  EXPECT_GT(std::abs(step.Q[1]), 0.01);
}

TEST(PadCells, JustCoverTheContact) {
  const PadCells cells = pad_cells({{-1, 2}, {-1, 1}}, {Sphere{8}}, 10, 2, false);
  EXPECT_DOUBLE_EQ(cells.hx, 0.3);
  EXPECT_DOUBLE_EQ(cells.hy, 0.2);
  EXPECT_DOUBLE_EQ(cells.x(0), -0.85);
  EXPECT_DOUBLE_EQ(cells.y(9), 0.9);
}

TEST(PadCells, SizesAreOnTheLadderWithEqualParity) {
  PadMix mix(2);
  for (int k = 0; k < 60; ++k) {
    const PadScene scene = mix();
    if (!std::isinf(pad_edges(scene.indenter.shape).y.right)) continue;
    const PadBox contact = rigid_section(scene.indenter, scene.load.indentation[0]);
    const double H = scene.sensor.thickness;
    const PadCells cells = pad_cells(contact, scene.indenter, 12, H, true);
    const double kx = 4 * std::log2(cells.hx / H), ky = 4 * std::log2(cells.hy / H);
    EXPECT_NEAR(kx, std::round(kx), 1e-9);
    EXPECT_EQ(std::lround(kx - ky) % 2, 0);
    EXPECT_GE(12 * cells.hx, (contact.x.right - contact.x.left) * (1 - 1e-8));
    EXPECT_LE(12 * cells.hx, (contact.x.right - contact.x.left) * std::exp2(0.5) * (1 + 1e-8));
    EXPECT_NEAR(cells.x_middle, (contact.x.right + contact.x.left) / 2, 1e-12);
  }
}

TEST(PadCells, ReachPartOfACellBeyondSharpEdges) {
  const PadIndenter box{Box{{1, 2}, 0}};
  const PadCells both = pad_cells({{-9, 9}, {-9, 0.5}}, box, 12, 2, false);
  EXPECT_NEAR(both.hx, 2 / (12 - 0.3), 1e-12);
  EXPECT_NEAR(both.box().x.right, 1 + 0.15 * both.hx, 1e-12);
  EXPECT_NEAR(both.hy, 2.5 / (12 - 0.15), 1e-12);
  EXPECT_NEAR(both.box().y.left, -2 - 0.15 * both.hy, 1e-12);
  EXPECT_NEAR(both.box().y.right, 0.5, 1e-12);
  const Eigen::MatrixXd h = cell_heights(both, box);
  EXPECT_EQ(h(0, 5), infinity);  // beyond the edge
  EXPECT_EQ(h(5, 0), infinity);
  EXPECT_EQ(h(5, 13), 0);  // the ring where the contact ends before the edge
  EXPECT_EQ(h(1, 1), 0);
}

TEST(PadCells, TheBorderOfAMapIsAnEdge) {
  PadScene box, map;
  box.indenter = {Box{{1, 2}, 0}};
  map.indenter = {HeightMap{0.5, Eigen::MatrixXd::Zero(5, 9)}};  // the same bottom, measured
  for (PadScene* scene : {&box, &map}) scene->load.drags = {{0.05, 0.02, 0}, {0.1, 0.1, 0}};
  const PadLayer layer(0.45);
  const PadSolution one = PadSolver(layer, {.cells = 8}).solve(box), other = PadSolver(layer, {.cells = 8}).solve(map);
  EXPECT_EQ(other.cells.edge, one.cells.edge);
  EXPECT_EQ(other.cells.hx, one.cells.hx);
  EXPECT_EQ(other.cells.hy, one.cells.hy);
  for (std::size_t k = 0; k < one.steps.size(); ++k) {
    EXPECT_EQ(other.steps[k].P, one.steps[k].P);
    EXPECT_EQ(other.steps[k].slip_index, one.steps[k].slip_index);
  }
}

TEST(PadCells, BelowASharpRoundEdgeHaveItsArea) {
  for (const int n : {8, 12}) {
    const PadIndenter punch{Punch{1.5, 0}};
    const PadCells cells = pad_cells({{-9, 9}, {-9, 9}}, punch, n, 2, true);
    const Eigen::MatrixXd h = cell_heights(cells, punch);
    const auto count = (h.array() == 0).count();
    EXPECT_NEAR(static_cast<double>(count) * cells.area(), std::numbers::pi * std::pow(1.5 + 0.125 * cells.hx, 2),
                1e-12);
    EXPECT_EQ(h(1, 1), infinity);  // a corner
    EXPECT_EQ(h(1, n / 2), 0);
  }
}

}  // namespace tactel::fem::pad_cells_test
