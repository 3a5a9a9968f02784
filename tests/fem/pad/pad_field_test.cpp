// SPDX-License-Identifier: Apache-2.0

// The rubber below a contact: base and surface by integrals of another kind, and the laws of elasticity by differences.
#include "fem/pad/pad_field.h"

#include <gtest/gtest.h>

#include <numbers>

#include "fem/pad/pad_layer.h"
#include "tests/fem/pad/named_pad_scenes.h"

namespace tactel::fem::pad_field_test {

/// A paraboloid that is pressed, dragged and twisted. `yaw` turns it about its axis, and the drag with it.
struct Pressed {
  explicit Pressed(double nu, double yaw = 0) : layer(nu) {
    const Eigen::Vector2d drag = Eigen::Rotation2Dd(yaw * std::numbers::pi / 180) * Eigen::Vector2d(0.05, 0.03);
    scene = scene_of(Paraboloid{{8, 6}}, 0.3, 2.5, nu, 0.5, {{drag[0], drag[1], 0.02}});
    scene.indenter.yaw = yaw;
    solution = PadSolver(layer, {.cells = 12}).solve_on({.n = 12, .hx = 0.38, .hy = 0.33}, scene);
    field = pad_field(scene, solution, solution.steps.size() - 1);
    at = &solution.steps.back();
    largest = at->normal_force.maxCoeff() / solution.cells.area();
  }
  Eigen::Index index(int x, int y, int z) const {
    return (Eigen::Index(z) * field.points[1] + y) * field.points[0] + x;
  }
  double place(int along, int x, int y, int z) const { return field.place(along, index(x, y, z)); }

  PadLayer layer;
  PadScene scene;
  PadSolution solution;
  PadField field;
  const PadStep* at = nullptr;
  double largest = 0;  ///< MPa: pressure
};

class Field : public testing::TestWithParam<double> {};

// The layer's Hankel integrals over the cells.
TEST_P(Field, TheBaseBearsWhatTheLayerSays) {
  const Pressed p(GetParam());
  const PadCells& cells = p.solution.cells;
  for (int y = 0; y < p.field.points[1]; y += 6)
    for (int x = 0; x < p.field.points[0]; x += 6) {
      const Eigen::Index i = p.index(x, y, 0);
      Eigen::Vector3d base = Eigen::Vector3d::Zero();
      for (int c = 0; c < cells.count(); ++c) {
        const Eigen::Vector2d from = p.field.place.col(i).head<2>() - p.solution.places.row(c).transpose();
        base += p.layer.base_stress(p.scene.sensor.thickness, cells.hx, cells.hy, from[0], from[1]) *
                Eigen::Vector3d(p.at->tangential_force(c, 0), p.at->tangential_force(c, 1), -p.at->normal_force[c]) /
                cells.area();
      }
      EXPECT_NEAR(p.field.stress(2, i), base[0], 3e-3 * p.largest) << x << " " << y;
      EXPECT_NEAR(p.field.stress(5, i), base[1], 3e-3 * p.largest) << x << " " << y;
      EXPECT_NEAR(p.field.stress(4, i), base[2], 3e-3 * p.largest) << x << " " << y;
      EXPECT_LT(p.field.displacement.col(i).norm(), 1e-12);
    }
}

// Below the middle of a cell the traction is its own; where nothing touches there is none, but for what the mean over
// half a cell leaves of the sums' end. The surface lies where the cells' influence puts it.
TEST_P(Field, TheSurfaceBearsTheTractions) {
  const Pressed p(GetParam());
  const PadCells& cells = p.solution.cells;
  const PadInfluence influence(p.layer, p.scene.sensor.thickness, cells.hx, cells.hy, cells.n);
  const int top = p.field.points[2] - 1;
  int met = 0;
  for (int y = 0; y < p.field.points[1]; ++y)
    for (int x = 0; x < p.field.points[0]; ++x) {
      const Eigen::Index i = p.index(x, y, top);
      const Eigen::Vector2d place = p.field.place.col(i).head<2>();
      const double column = place[0] / cells.hx + (cells.n - 1) / 2.0, row = place[1] / cells.hy + (cells.n - 1) / 2.0;
      const int cx = static_cast<int>(std::lround(column)), cy = static_cast<int>(std::lround(row));
      if (std::hypot(column - cx, row - cy) > 0.1) continue;
      const bool inside = cx >= 0 && cx < cells.n && cy >= 0 && cy < cells.n;
      const int c = cx * cells.n + cy;
      EXPECT_NEAR(p.field.stress(2, i), inside ? -p.at->normal_force[c] / cells.area() : 0, 0.03 * p.largest);
      EXPECT_NEAR(p.field.stress(5, i), inside ? p.at->tangential_force(c, 0) / cells.area() : 0, 0.03 * p.largest);
      EXPECT_NEAR(p.field.stress(4, i), inside ? p.at->tangential_force(c, 1) / cells.area() : 0, 0.03 * p.largest);
      if (!inside) continue;
      double down = 0;
      for (int jx = 0; jx < cells.n; ++jx)
        for (int jy = 0; jy < cells.n; ++jy) {
          const Eigen::Index of = influence.at(jx - cx, jy - cy), j = jx * cells.n + jy;
          down += (influence.zz[of] * p.at->normal_force[j] + influence.xz[of] * p.at->tangential_force(j, 0) +
                   influence.yz[of] * p.at->tangential_force(j, 1)) /
                  cells.area();
        }
      EXPECT_NEAR(p.field.displacement(2, i), -down, 0.01 * p.scene.load.indentation[0]);
      ++met;
    }
  EXPECT_GT(met, 10);
}

// Stress is that of the strain, by differences over two points of a level in the middle of the layer.
TEST_P(Field, StressFollowsStrain) {
  const double nu = GetParam(), G = 1 / (2 * (1 + nu));
  const Pressed p(nu);
  double worst_shear = 0, worst_normal = 0, most = 0;
  const int z = 4;
  for (int y = 1; y + 1 < p.field.points[1]; ++y)
    for (int x = 1; x + 1 < p.field.points[0]; ++x) {
      const auto slope = [&](int of, int along) {
        const int dx = along == 0, dy = along == 1;
        return (p.field.displacement(of, p.index(x + dx, y + dy, z)) -
                p.field.displacement(of, p.index(x - dx, y - dy, z))) /
               (p.place(along, x + dx, y + dy, z) - p.place(along, x - dx, y - dy, z));
      };
      const Eigen::Index i = p.index(x, y, z);
      worst_shear = std::max(worst_shear, std::abs(p.field.stress(3, i) - G * (slope(0, 1) + slope(1, 0))));
      const double difference = p.field.stress(0, i) - p.field.stress(1, i);
      worst_normal = std::max(worst_normal, std::abs(difference - 2 * G * (slope(0, 0) - slope(1, 1))));
      most = std::max({most, std::abs(difference), std::abs(p.field.stress(3, i))});
    }
  EXPECT_LT(worst_shear, 0.02 * most);
  EXPECT_LT(worst_normal, 0.02 * most);
}

INSTANTIATE_TEST_SUITE_P(Poisson, Field, testing::Values(0.0, 0.3, 0.48, 0.5));

// A contact that is turned has the same rubber, turned.
TEST(PadField, TurnsWithTheIndenter) {
  const Pressed p(0.45), turned(0.45, 90);
  ASSERT_EQ(p.field.points, turned.field.points);
  for (Eigen::Index i = 0; i < p.field.place.cols(); i += 97) {
    EXPECT_NEAR(turned.field.place(0, i), -p.field.place(1, i), 1e-9);
    EXPECT_NEAR(turned.field.displacement(1, i), p.field.displacement(0, i), 1e-5);
    EXPECT_NEAR(turned.field.stress(0, i), p.field.stress(1, i), 1e-3 * p.largest);
    EXPECT_NEAR(turned.field.stress(3, i), -p.field.stress(3, i), 1e-3 * p.largest);
    EXPECT_NEAR(turned.field.stress(4, i), p.field.stress(5, i), 1e-3 * p.largest);
  }
}

// A needle: cells far below a thickness, whose waves are limited; the base bears its force.
TEST(PadField, OfANeedleIsThatOfAPoint) {
  const double nu = 0.48;
  const PadLayer layer(nu);
  const PadScene scene = scene_of(Punch{0.01, 0}, 0.005, 2.5, nu, 0.5, {});
  const PadSolution solution = PadSolver(layer, {.cells = 12}).solve(scene);
  const PadField field = pad_field(scene, solution, 0);
  const Eigen::Index middle = Eigen::Index(field.points[1] / 2) * field.points[0] + field.points[0] / 2;
  const double b0 = layer.stresses(0)[0];
  EXPECT_NEAR(field.stress(2, middle), -b0 * solution.steps[0].P / (2 * std::numbers::pi * 2.5 * 2.5),
              0.01 * std::abs(b0) * solution.steps[0].P / (2 * std::numbers::pi * 2.5 * 2.5));
}

// Equilibrium: each level bears the same force. Beyond the points lies little of it.
TEST(PadField, EachLevelBearsTheForce) {
  const Pressed p(0.3);
  for (int z = 0; z < p.field.points[2]; z += 4) {
    double force = 0;
    for (int y = 1; y < p.field.points[1]; ++y)
      for (int x = 1; x < p.field.points[0]; ++x)
        force -= p.field.stress(2, p.index(x, y, z)) * (p.place(0, x, y, z) - p.place(0, x - 1, y, z)) *
                 (p.place(1, x, y, z) - p.place(1, x, y - 1, z));
    EXPECT_NEAR(force / p.at->P, 1, 0.04) << z;
  }
}

}  // namespace tactel::fem::pad_field_test
