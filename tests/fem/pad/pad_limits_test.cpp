// SPDX-License-Identifier: Apache-2.0

// Contacts on a pad in limits: the line as the middle of a long contact, and more and more cells and increments.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "fem/layer/patch_reference.h"
#include "fem/pad/pad_mix.h"
#include "fem/pad/pad_reference.h"
#include "fem/pad/pad_search.h"
#include "tests/fem/pad/named_pad_scenes.h"

namespace tactel::fem::pad_limits_test {

/// A cylinder that presses and drags across, on the line (plane strain) and on a pad, 16 thicknesses long.
struct LongContact {
  double H = 1.5, nu = 0.45, mu = 0.5, radius = 8, depth = 0.2;
  std::vector<double> drags{0.02, 0.04, 0.06};

  ContactSolution line() const {
    const Sensor sensor{.thickness = H, .young = 1, .poisson = nu, .tactels = 5, .tactel_span = 4};
    const LayerModel model = endless_layer(sensor);
    const Load load{.indentation = {depth}, .tangential = drags};
    return PatchReference(model, {.elements = 120}).solve({"", sensor, {Cylinder{radius}, 0}, mu, load});
  }
  PadSolution pad(int cells) const {
    PadScene scene = scene_of(LyingCylinder{radius, 8 * H}, depth, H, nu, mu, {});
    scene.load.indentation_steps = 1;
    for (const double drag : drags) scene.load.drags.push_back({drag, 0, 0});
    scene.sensor.tactels = {5, 1};
    const PadLayer layer(nu);
    return PadSolver(layer, {.cells = cells, .tolerance = 1e-5, .drag_increments = 2, .ladder = false}).solve(scene);
  }
};

TEST(PadLimits, TheMiddleOfALongContactIsTheLine) {
  const LongContact contact;
  const ContactSolution line = contact.line();
  for (const auto& [cells, off] : {std::pair{16, 0.01}, {24, 0.005}}) {
    const PadSolution pad = contact.pad(cells);
    for (std::size_t k = 0; k < line.steps.size(); ++k) {
      const ContactStep& expected = line.steps[k];
      const PadStep& found = pad.steps[k];
      // The two rows of cells beside the middle, per length.
      const double length = 2 * pad.cells.hy;
      double P = 0, Q = 0, largest = 0;
      for (int i = 0; i < cells; ++i)
        for (const int j : {cells / 2 - 1, cells / 2}) {
          P += found.normal_force[i * cells + j] / length;
          Q += found.tangential_force(i * cells + j, 0) / length;
          largest = std::max(largest, found.normal_force[i * cells + j] / pad.cells.area());
        }
      const double pressure = (expected.normal_force.array() / line.surface_width.array()).maxCoeff();
      const double stress = expected.sigma_y.cwiseAbs().maxCoeff();
      EXPECT_NEAR(P / expected.P, 1, off) << cells << ' ' << k;
      EXPECT_NEAR(Q / (contact.mu * P), *expected.slip_index, off) << cells << ' ' << k;
      EXPECT_NEAR(largest / pressure, 1, 2 * off) << cells << ' ' << k;  // means over cells
      for (int tactel = 0; tactel < 5; ++tactel) {
        EXPECT_NEAR(found.stress(tactel, 0) / stress, expected.sigma_y[tactel] / stress, off) << cells << ' ' << k;
        EXPECT_NEAR(found.stress(tactel, 1) / stress, expected.tau_xy[tactel] / stress, off) << cells << ' ' << k;
        EXPECT_NEAR(found.stress(tactel, 2), 0, 1e-6);
      }
    }
  }
}

TEST(PadLimits, IncrementsConvergeAtFirstOrder) {
  PadSensor sensor;
  sensor.poisson = 0.3;  // pressing makes surfaces slip
  const PadLayer layer(sensor.poisson);
  double off[2] = {};
  PadMix mix(21, &sensor);
  for (int scenes = 0; scenes < 36; ++scenes) {
    PadScene scene = mix();
    const PadLayout laid = lay_cells(scene, layer, 8, true);  // the same cells for all
    scene.indenter = laid.indenter;
    std::array<PadSolution, 3> paths;
    for (const int k : {0, 1, 2}) {
      const PadOptions options{
          .tolerance = 1e-6, .pressing_increments = 4 << k, .drag_increments = 1 << k, .limit_increments = 0};
      paths[k] = PadSolver(layer, options).solve_on(laid.cells, scene);
    }
    for (const int k : {0, 1}) off[k] += pad_difference(paths[k], paths[k + 1]).S;
  }
  EXPECT_NEAR(off[0] / off[1], 2, 0.4);  // errors c / increments
}

TEST(PadLimits, CellsConvergeAtFirstOrderAtLeast) {
  // Over spheres and boxes of several sizes, so that the place of the contact's edge among the cells averages out.
  double error[3] = {};
  const PadLayer layer(0.45);
  for (const double size : {0.8, 1.1, 1.4, 1.7})
    for (const PadShape& shape : {PadShape(Sphere{4 * size}), PadShape(Box{{size, 0.7 * size}, 0.1})}) {
      PadScene scene = scene_of(shape, .15, 2, .45, .5, {{.02, .01, .01}});
      scene.load.indentation_steps = 1;
      const auto S = [&](int cells) {
        const PadOptions options{.cells = cells, .pressing_increments = 4, .ladder = false};
        return *PadSolver(layer, options).solve(scene).steps.back().slip_index;
      };
      const double fine = S(40);
      for (const int k : {0, 2}) error[k] += std::abs(S(6 << k) - fine);
    }
  EXPECT_GT(error[0] / error[2], 4);  // 4 at first order; the finest has an error, too
}

}  // namespace tactel::fem::pad_limits_test
