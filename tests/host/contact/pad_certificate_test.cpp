// SPDX-License-Identifier: Apache-2.0

// Certificates of pads: those of the kernel recomputed from its forces, and those of many random scenes.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/pad/pad_mix.h"
#include "host/contact/pads/pad_stream.h"
#include "kernels/shared/pad_layout.h"
#include "tests/host/device/test_device.h"

namespace tactel::host::pad_certificate_test {

/// The laws of fem/pad/pad_contact.h from the forces of an answer, step after step. All increments of its path must be
/// asked.
class Audit {
 public:
  Audit(const fem::PadScene& scene, const fem::PadLayer& layer, const fem::PadSolution& solution)
      : scene_(scene),
        solution_(solution),
        n_(solution.cells.n),
        influence_(layer, scene.sensor.thickness, solution.cells.hx, solution.cells.hy, n_),
        heights_(fem::cell_heights(solution.cells, scene.indenter)),
        turn_(Eigen::Rotation2Dd(scene.indenter.yaw * std::numbers::pi / 180).toRotationMatrix()),
        stuck_at_(Eigen::MatrixX2d::Zero(n_ * n_, 2)) {}

  fem::PadResidual next() {
    const fem::PadStep& step = solution_.steps[k_++];
    const double unit = 1 / (scene_.sensor.young * solution_.cells.area()), d = step.indentation, mu = scene_.friction;
    const Eigen::VectorXd n = unit * step.normal_force;
    const Eigen::MatrixX2d t = unit * step.tangential_force * turn_;
    Eigen::Vector3d motion;
    motion << turn_.transpose() * Eigen::Vector2d(step.x, step.y), step.twist;
    const Eigen::Vector3d change = motion - motion_;
    motion_ = motion;
    const double moved = std::max(0.1 * d, change.head<2>().norm() + std::abs(change[2]) * solution_.cells.half_size());
    fem::PadResidual r;
    for (int ix = -1; ix <= n_; ++ix)
      for (int iy = -1; iy <= n_; ++iy) {
        Eigen::Vector3d u = Eigen::Vector3d::Zero();
        for (int jx = 0; jx < n_; ++jx)
          for (int jy = 0; jy < n_; ++jy) {
            const int j = jx * n_ + jy;
            const Eigen::Index c = influence_.at(jx - ix, jy - iy);
            const auto& I = influence_;
            u[0] += I.xx[c] * t(j, 0) + I.xy[c] * t(j, 1) - I.xz[c] * n[j];
            u[1] += I.xy[c] * t(j, 0) + I.yy[c] * t(j, 1) - I.yz[c] * n[j];
            u[2] -= I.zz[c] * n[j] + I.xz[c] * t(j, 0) + I.yz[c] * t(j, 1);
          }
        const double gap = (heights_(ix + 1, iy + 1) - d - u[2]) / d;
        r.penetration = std::max(r.penetration, -gap);
        if (ix < 0 || iy < 0 || ix == n_ || iy == n_) continue;
        const int i = ix * n_ + iy;
        const Eigen::Vector2d would = stuck_at_.row(i).transpose() + change.head<2>() +
                                      change[2] * Eigen::Vector2d(-solution_.cells.y(iy), solution_.cells.x(ix));
        const Eigen::Vector2d slip = would - u.head<2>();
        const bool sticks = step.status[static_cast<std::size_t>(i)] == fem::GapStatus::stick;
        stuck_at_.row(i) = (sticks ? would : Eigen::Vector2d(u.head<2>())).transpose();
        if (!(n[i] > 0)) continue;
        const double length = t.row(i).norm();
        r.complementarity = std::max(r.complementarity, std::abs(gap));
        r.cone = std::max(r.cone, (length - mu * n[i]) / n.maxCoeff());
        if (sticks)
          r.drift = std::max(r.drift, slip.norm() / moved);
        else if (length > 0)
          r.angle = std::max(r.angle, (slip.norm() - t.row(i).dot(slip) / length) / moved);
      }
    return r;
  }

 private:
  const fem::PadScene& scene_;
  const fem::PadSolution& solution_;
  int n_;
  fem::PadInfluence influence_;
  Eigen::MatrixXd heights_;
  Eigen::Matrix2d turn_;
  Eigen::MatrixX2d stuck_at_;  ///< [cells] mm: where a cell sticks from
  Eigen::Vector3d motion_ = Eigen::Vector3d::Zero();
  std::size_t k_ = 0;
};

TEST(PadCertificate, IsThatOfTheForcesInFp64) {
  const PadContact<float> contact(executor(), {.cells = 8, .limit_increments = 0});
  const fem::PadSensor sensor{.thickness = 1.5, .poisson = 0.49};
  fem::PadMix draw(5, &sensor);
  std::vector<fem::PadScene> scenes(90);
  for (fem::PadScene& scene : scenes) {
    scene = draw();
    scene.load.indentation_steps = 2;  // as many as the increments of 8 cells
  }
  auto batch = contact.prepare(scenes);
  batch.run();
  double largest = 0;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::PadSolution solution = batch.solution(i);
    Audit audit(batch.scene(i), *contact.layer({sensor.poisson}), solution);
    for (std::size_t k = 0; k < solution.steps.size(); ++k) {
      const fem::PadResidual found = audit.next(), said = solution.steps[k].residual;
      // Rounding of the kernel's sums and of a history of ten steps, over depths and motions.
      constexpr double near = 2e-4;
      EXPECT_NEAR(found.penetration, said.penetration, near) << i << " " << k;
      EXPECT_NEAR(found.complementarity, said.complementarity, near) << i << " " << k;
      EXPECT_NEAR(found.cone, said.cone, near) << i << " " << k;
      EXPECT_NEAR(found.drift, said.drift, near) << i << " " << k;
      EXPECT_NEAR(found.angle, said.angle, near) << i << " " << k;
      largest = std::max(largest, found.largest());
    }
  }
  EXPECT_GT(largest, 5e-3);  // the numbers compared are no zeros
  EXPECT_LE(largest, contact.options().accept);
}

class RandomPads : public testing::TestWithParam<std::tuple<int, int>> {};

/// mu 0.1 to 1.5, nu 0.3 to 1/2, depths to a fifth of H, eight drags. Whatever the kernel does not settle is counted
/// and solved again.
TEST_P(RandomPads, NoneIsUnsettled) {
  const auto [cells, count] = GetParam();
  std::vector<fem::PadSensor> sensors(8);
  std::vector<fem::PadMix> mixes;
  for (unsigned k = 0; k < sensors.size(); ++k) {
    sensors[k].thickness = 1 + 0.4 * k;
    sensors[k].poisson = k == 0 ? 0.5 : 0.28 + 0.0307 * k;
    mixes.emplace_back(100 + k, &sensors[k]);
  }
  std::vector<fem::PadScene> scenes(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < scenes.size(); ++i) scenes[i] = mixes[i % mixes.size()]();
  const PadStream stream(executor(), {.options = {.cells = cells}});
  std::size_t in_place = 0, steps = 0, sliding = 0, grown = 0, fell_back = 0;
  double worst = 0;
  stream.solve(
      scenes,
      [&](std::size_t i, const LaneAnswer& answer, auto&&) {
        ++in_place;
        for (int k = 0; k < answer.steps; ++k, ++steps) {
          for (int row = RESULT_PENETRATION; row <= PAD_RESULT_ANGLE; ++row)
            worst = std::max(worst, answer.result(k, row));
          const double S = answer.result(k, RESULT_S);
          EXPECT_TRUE(S >= 0 && S <= 1.001) << i << " " << k << ": " << S;
          sliding += S > 0.99;
        }
      },
      [&](std::size_t i, fem::PadSolution&& solution) {
        ++(solution.fell_back ? fell_back : grown);
        EXPECT_TRUE(every_step_converged(solution)) << i;
      },
      [](std::size_t) { return true; });
  RecordProperty("grown", static_cast<int>(grown));
  RecordProperty("fell_back", static_cast<int>(fell_back));
  std::cout << count << " scenes at " << cells << " cells: " << grown << " grown, " << fell_back
            << " solved by the twin, largest residual in place " << worst << "\n";
  EXPECT_EQ(in_place + grown + fell_back, scenes.size());
  EXPECT_LE(1000 * (grown + fell_back), scenes.size());  // one in a thousand
  EXPECT_EQ(steps, 9 * in_place);
  EXPECT_LE(worst, PadContact<float>(executor(), {.cells = cells}).options().accept);
  EXPECT_GT(sliding, steps / 100);  // the scenes go to the limit
}

std::string cells_and_scenes(const testing::TestParamInfo<std::tuple<int, int>>& pads) {
  return std::to_string(std::get<0>(pads.param)) + "_cells_" + std::to_string(std::get<1>(pads.param));
}
INSTANTIATE_TEST_SUITE_P(CellsAndScenes, RandomPads, testing::Combine(testing::Values(8, 12), testing::Values(1000)),
                         cells_and_scenes);
INSTANTIATE_TEST_SUITE_P(Nightly, RandomPads, testing::Combine(testing::Values(8, 12), testing::Values(100000)),
                         cells_and_scenes);

}  // namespace tactel::host::pad_certificate_test
