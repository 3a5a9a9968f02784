// SPDX-License-Identifier: Apache-2.0

// The status iteration on the condensed compliance against the same on the whole mesh: C is all that contact can ask of
// the block.
#include "fem/gap/gap_condensed.h"

#include <gtest/gtest.h>

#include <limits>

#include "fem/gap/gap_reference.h"

namespace tactel::fem::gap_condensed_test {

/// Of base forces, over the largest of them.
double difference(const ContactStep& a, const ContactStep& b) {
  const double scale = std::max(b.base_force_y.cwiseAbs().maxCoeff(), b.base_force_x.cwiseAbs().maxCoeff());
  const double off = std::max((a.base_force_y - b.base_force_y).cwiseAbs().maxCoeff(),
                              (a.base_force_x - b.base_force_x).cwiseAbs().maxCoeff());
  return scale > 0 ? off / scale : off;
}

std::vector<Load> loads() {
  Load drag, force, angle, lifted;
  drag.tangential = {0.05, 0.2, -0.1};
  force.indentation.clear(), force.normal_force = {0.3}, force.tangential = {0.1, -0.1};
  angle.indentation.clear(), angle.normal_force = {0.3}, angle.angle = 5.0, angle.indentation_steps = 3;
  lifted.indentation.clear(), lifted.normal_force = {0.3, 0.0, 0.2};
  return {drag, force, angle, lifted};
}

TEST(GapCondensed, AgreesWithTheWholeMesh) {
  const Sensor sensor{.poisson = 0.49};
  const Condensation condensation = condense(sensor);
  GapReference whole(sensor);
  const GapCondensed condensed(condensation);
  for (const Shape& shape : {Shape(Parabola{10}), Shape(Flat{3.0}), Shape(Wedge{120}), Shape(Flat{})})
    for (double mu : {0.0, 0.3, 1.0, std::numeric_limits<double>::infinity()})
      for (const Load& load : loads()) {
        if (load.angle && mu == 0) continue;  // slides
        const Scene scene{"", sensor, {shape, 0.8}, mu, load};
        const ContactSolution truth = whole.solve(scene), found = condensed.solve(scene);
        ASSERT_EQ(found.steps.size(), truth.steps.size());
        for (std::size_t k = 0; k < truth.steps.size(); ++k) {
          EXPECT_TRUE(found.steps[k].converged) << shape_name(shape) << ", mu " << mu << ", step " << k;
          EXPECT_TRUE(truth.steps[k].converged) << shape_name(shape) << ", mu " << mu << ", step " << k;
          // C is formed in double with errors of some 1e-13 at nu = 0.49, and cond(C) is some 100.
          EXPECT_LE(difference(found.steps[k], truth.steps[k]), 1e-10)
              << shape_name(shape) << ", mu " << mu << ", step " << k;
          EXPECT_NEAR(found.steps[k].indentation, truth.steps[k].indentation, 1e-11);
          const double stress = truth.steps[k].sigma_y.cwiseAbs().maxCoeff();
          EXPECT_LE((found.steps[k].tau_xy - truth.steps[k].tau_xy).cwiseAbs().maxCoeff(), 1e-10 * stress);
        }
      }
}

TEST(GapCondensed, BondedSticksUntilItLiftsOff) {
  Scene scene{"", {}, {Parabola{10}, 0.0}, std::numeric_limits<double>::infinity(), {}};
  scene.load.tangential = {0.3};
  const ContactSolution solution = GapCondensed(condense(scene.sensor)).solve(scene);
  for (const ContactStep& step : solution.steps)
    for (std::size_t i = 0; i < step.status.size(); ++i) EXPECT_NE(step.status[i], GapStatus::slip);
  EXPECT_GT(solution.steps.back().Q, 0.1);
  EXPECT_EQ(solution.steps.back().slip_index, 0.0);
}

/// A step that does not converge takes those after it along: they rest on its history.
TEST(GapCondensed, NothingIsSolvedAfterAnUnsolvedStep) {
  Scene scene{"", {}, {Parabola{10}, 0.0}, 0.5, {}};
  scene.load.tangential = {0.3, 0.31};
  const Condensation condensation = condense(scene.sensor);
  const ContactSolution solution = GapCondensed(condensation, {.most_iterations = 2}).solve(scene);
  EXPECT_FALSE(solution.steps[0].converged);
  EXPECT_FALSE(solution.steps[2].converged);
}

}  // namespace tactel::fem::gap_condensed_test
