// SPDX-License-Identifier: Apache-2.0

// Stress on the base beside free sides: bricks of 27 nodes, and bonded and sliding faces beside an independent program.
#include "fem/pad/side_base.h"

#include <gtest/gtest.h>

#include "fem/pad/mixed_brick.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_solver.h"
#include "fem/pad/side_kernel.h"
#include "tests/scratch.h"

namespace tactel::fem::side_base_test {

TEST(MixedBrick, UniformStrainHasTheStressOfHookesLaw) {
  constexpr double nu = 0.3, hx = 0.7, hy = 1.1, hz = 0.4;
  const MixedBrick brick(hx, hy, hz, nu);
  Eigen::Matrix3d slope;  // of the displacement
  slope << 0.3, -0.1, 0.5, 0.2, -0.4, 0.7, -0.6, 0.8, 0.9;
  Eigen::VectorXd u(MixedBrick::unknowns);
  for (int node = 0; node < 27; ++node)
    u.segment<3>(3 * node) = slope * Eigen::Vector3d(hx * (node / 9) / 2, hy * (node / 3 % 3) / 2, hz * (node % 3) / 2);
  const double G = 1 / (2 * (1 + nu)), lambda = nu / ((1 + nu) * (1 - 2 * nu));
  const Eigen::Vector3d stress = brick.face_stress(0.3, -0.8) * u;
  EXPECT_NEAR(stress[0], G * (slope(0, 2) + slope(2, 0)), 1e-12);
  EXPECT_NEAR(stress[1], G * (slope(1, 2) + slope(2, 1)), 1e-12);
  EXPECT_NEAR(stress[2], lambda * slope.trace() + 2 * G * slope(2, 2), 1e-12);
  // Its energy is that of the stress over the volume.
  const Eigen::Matrix3d strain = (slope + slope.transpose()) / 2;
  const double energy = hx * hy * hz * (lambda * slope.trace() * slope.trace() + 2 * G * strain.squaredNorm());
  EXPECT_NEAR(u.dot(brick.stiffness() * u), energy, 1e-12);
}

TEST(BaseBlock, BaseBearsWhatPressesTheSurface) {
  // Gauss points integrate the stress of each brick; it is singular at the sides, which leaves 3 %.
  const auto half = [](double) { return 0.5; };
  BaseMesh mesh{graded_edges(1, 0.1, 2, half), graded_edges(1.5, 0.1, 2, half), {}};
  for (const double edge : graded_edges(1, 0.1, 2, half)) mesh.z.insert(mesh.z.begin(), 1 - edge);
  const Eigen::MatrixXd stress = base_block(mesh, {2, 2}, 0.45);
  const auto side = [](const std::vector<double>& edges, std::size_t place) {  // of the brick of a Gauss point
    const std::size_t bricks = edges.size() - 1, k = place / 2 < bricks ? bricks - 1 - place / 2 : place / 2 - bricks;
    return edges[k + 1] - edges[k];
  };
  const std::size_t nx = gauss_places(mesh.x).size(), ny = gauss_places(mesh.y).size();
  for (Eigen::Index source = 0; source < stress.cols(); ++source) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero(), applied = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < nx; ++i)
      for (std::size_t j = 0; j < ny; ++j)
        sum += side(mesh.x, i) * side(mesh.y, j) / 4 *
               stress.block<3, 1>(static_cast<Eigen::Index>(3 * (i * ny + j)), source);
    applied[source % 3] = 0.5 * 0.75;
    EXPECT_LT((sum - applied).norm(), 0.03 * applied.norm()) << source << ": " << sum.transpose();
  }
}

/// A face over all of a pad, E 1 MPa, 4 x 4 tactels whose outermost lie 0.065 of a side from the sides.
PadScene covered(double side, double H, double nu, double mu, double depth, double drag) {
  PadScene scene;
  scene.sensor = {.thickness = H, .young = 1, .poisson = nu, .length = side, .width = side};
  scene.sensor.pitch = {0.29 * side, 0.29 * side};
  scene.indenter.shape = Box{.half_widths = {40, 40}};
  scene.friction = mu;
  scene.load.indentation = {depth};
  if (drag > 0) scene.load.drags = {{drag, 0, 0}};
  return scene;
}

PadSolution solved(const PadScene& scene) { return PadSolver(pad_layer(scene.sensor.poisson)).solve(scene); }

TEST(SideBase, BondedCubeIsThatOfCalculiX) {
  // A cube of 8 mm, bonded, pressed by 0.4, dragged by 0.3 mm. CalculiX 2.20 at the corner: 2000 C3D20R and 784 C3D20 a
  // quarter, graded to the sides, the base and the face, which differ by 0.0004 and 0.0001; elsewhere bricks of 27
  // nodes of another program. Twelve cells have 0.6 % too little of P, 0.8 % too much of Q, which leaves 3 % of the
  // dragged sigma_z.
  const PadSolution solution = solved(covered(8, 8, 0.3, 100, 0.4, 0.3));
  ASSERT_EQ(solution.steps.size(), 2u);
  const Eigen::MatrixX3d press = solution.steps[0].stress, drag = solution.steps[1].stress - press;
  constexpr int corner = 15, edge = 14, middle = 10;  // (3.48, 3.48), (1.16, 3.48), (1.16, 1.16)
  constexpr double sigma = 0.057, tau = 0.0139, sigma_dragged = 0.0245, tau_dragged = 0.0099;
  EXPECT_NEAR(press(corner, 0), -0.0573, 0.02 * sigma);
  EXPECT_NEAR(press(corner, 1), 0.0134, 0.02 * tau);
  EXPECT_NEAR(press(edge, 0), -0.0517, 0.02 * sigma);
  EXPECT_NEAR(press(edge, 2), 0.0139, 0.02 * tau);
  EXPECT_NEAR(press(middle, 0), -0.0468, 0.02 * sigma);
  EXPECT_NEAR(press(middle, 1), 0.0033, 0.02 * tau);
  EXPECT_NEAR(drag(corner, 0), -0.0246, 0.04 * sigma_dragged);
  EXPECT_NEAR(drag(corner, 1), 0.0083, 0.03 * tau_dragged);
  EXPECT_NEAR(drag(corner, 2), 0.0052, 0.03 * tau_dragged);
  EXPECT_NEAR(drag(edge, 1), 0.0096, 0.03 * tau_dragged);
  EXPECT_NEAR(drag(middle, 1), 0.0099, 0.03 * tau_dragged);
}

TEST(SideBase, NarrowStripIsThatOfAnIndependentProgram) {
  // 12 x 6 x 3 mm, nu 0.49, bonded, pressed by 0.12 mm; 0.39 mm from the long side. Bricks of 27 nodes in Python, 16 to
  // the side and 17 above one another, the smallest 0.01 mm: 11 and 13 differ by 0.0001.
  PadScene scene = covered(12, 3, 0.49, 100, 0.12, 0);
  scene.sensor.width = 6, scene.sensor.tactels = {2, 2}, scene.sensor.pitch = {0.6, 5.22};
  const Eigen::MatrixX3d stress = solved(scene).steps.back().stress;
  EXPECT_NEAR(stress(3, 0), -0.0715, 0.03 * 0.0935);
  EXPECT_NEAR(stress(3, 2), 0.0489, 0.03 * 0.0489);
}

TEST(SideBaseNightly, ThinRubberIsThatOfAnIndependentProgram) {
  // 10 x 10 x 1 mm, nu 0.499, mu 0.4: finite elements of 27 nodes, dense compliance of the touching nodes.
  const PadSolution solution = solved(covered(10, 1, 0.499, 0.4, 0.03, 0));
  const Eigen::MatrixX3d& stress = solution.steps.back().stress;
  constexpr double sigma = 0.56, tau = 0.101;
  EXPECT_NEAR(stress(5, 0), -0.5599, 0.03 * sigma);
  EXPECT_NEAR(stress(5, 1), -0.0352, 0.04 * tau);  // cells are 0.83 H wide: 24 have -0.0333, 12 -0.0315
  EXPECT_NEAR(stress(0, 0), -0.0560, 0.06 * sigma);
  EXPECT_NEAR(stress(0, 1), -0.0324, 0.06 * tau);
  EXPECT_NEAR(stress(1, 0), -0.1194, 0.06 * sigma);
  EXPECT_NEAR(stress(1, 2), -0.1013, 0.06 * tau);
}

TEST(SideBase, IsReadBackToTheLastBit) {
  const ScratchFolder folder;
  const SideGrid grid{{2, 3}, {4, 6}};
  const BaseGrading coarse{.finest = 0.3, .growth = 2, .widest = 1, .highest = 1};
  const SideBase made(grid, 0.5, coarse, folder / ""), read(grid, 0.5, coarse, folder / ""),
      near(grid, 0.49999, coarse, folder / "");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder / ""), {}), 1);
  EXPECT_TRUE(made.stress(0.7, 1.1) == read.stress(0.7, 1.1));
  EXPECT_TRUE(made.stress(0.7, 1.1) == near.stress(0.7, 1.1));  // nu = 1/2 is that of 0.49999
  EXPECT_TRUE(made.stress(1.2, 0).isZero());                    // beyond the side
}

TEST(SideCost, IsSaidWhereNoTableIsKept) {
  PadSensor sensor{.thickness = 4, .poisson = 0.437, .length = 19, .width = 19};
  const double seconds = seconds_for_sides(sensor, SideBricks::usual);
  EXPECT_GT(seconds, 0.2);  // some 8 GFLOP
  EXPECT_LT(seconds, 2);
  sensor.length = 48, sensor.width = 48;
  EXPECT_GT(seconds_for_sides(sensor, SideBricks::finer), 4 * seconds);
}

TEST(SideCost, TowersAreRefused) {
  PadSensor sensor{.thickness = 24, .length = 19, .width = 6};
  sensor.tactels = {2, 2}, sensor.pitch = {2, 2};
  EXPECT_NO_THROW(validate(sensor));  // four times the shorter side
  sensor.thickness = 24.1;
  EXPECT_ANY_THROW(validate(sensor));
  sensor.sides = Sides::held;
  EXPECT_NO_THROW(validate(sensor));
}

TEST(SideCells, ABillionthOfTheThicknessPresses) {
  // As on a half-space: H. Hertz's 4/3 E / (1 - nu^2) sqrt(R) d^(3/2). Cells leave 2 %.
  PadScene scene = covered(19, 4.5, 0.48, 0.5, 4.5e-9, 0);
  scene.indenter.shape = Sphere{15};
  const PadStep& step = solved(scene).steps.back();
  const double P = 4.0 / 3 / (1 - 0.48 * 0.48) * std::sqrt(15) * std::pow(4.5e-9, 1.5);
  EXPECT_NEAR(step.P, P, 0.02 * P);
  EXPECT_TRUE(step.slip_index);
}

}  // namespace tactel::fem::side_base_test
