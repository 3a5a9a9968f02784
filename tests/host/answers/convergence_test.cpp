// SPDX-License-Identifier: Apache-2.0

// Extrapolation to cells of size 0: of values with a known law, and of contacts with a closed form.
#include "host/answers/convergence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

namespace tactel::host::convergence_test {

using testing::HasSubstr;

constexpr double pi = std::numbers::pi;
const std::vector<double> halved = {0.8, 0.4, 0.2, 0.1};

TEST(Extrapolation, FindsOrderAndLimitOfALaw) {
  for (const double order : {0.5, 1.0, 1.3125, 2.0}) {
    std::vector<double> values(halved);
    for (double& value : values) value = 2 - 3 * std::pow(value, order);
    const Extrapolation fit = extrapolate(halved, values);
    EXPECT_DOUBLE_EQ(fit.order, order);
    EXPECT_NEAR(fit.limit, 2, 1e-12);
    EXPECT_NEAR(fit.slope, -3, 1e-11);
    EXPECT_NEAR(fit.uncertainty, 1.25 * 3 * std::pow(0.1, order), 1e-11);  // of the finest value, and 1.25 times
    EXPECT_STREQ(fit.trend, "monotone");
  }
}

TEST(Extrapolation, SmallerCellsWeighMore) {
  const std::vector<double> values = {5.1, 3.4, 2.71, 2.34};  // some 2 + 4 h, with noise
  const Extrapolation fit = extrapolate(halved, values);
  EXPECT_GT(fit.scatter, 0.01);
  double sum = 0, product = 0, size = 0, squares = 0;  // the normal equations of least squares, with weights 1 / h^2
  for (std::size_t r = 0; r < halved.size(); ++r) {
    const double power = std::pow(halved[r], fit.order), off = values[r] - fit.limit - fit.slope * power;
    const double weight = 1 / (halved[r] * halved[r]);
    sum += weight * off, product += weight * off * power, size += weight, squares += weight * off * off;
  }
  EXPECT_NEAR(sum / size, 0, 1e-12);
  EXPECT_NEAR(product / size, 0, 1e-12);
  EXPECT_NEAR(fit.scatter, std::sqrt(4 * squares / size), 1e-12);  // 4 values less 3 numbers of the fit
}

TEST(Extrapolation, ValuesThatScatterHaveNoOrder) {
  const std::vector<double> to_and_fro = {1, 3, 1, 2}, noisy = {1, 3, 3.5, 1.5};
  for (const auto& values : {to_and_fro, noisy}) {
    const Extrapolation fit = extrapolate(halved, values);
    EXPECT_EQ(fit.order, 0);
    EXPECT_EQ(fit.limit, values.back());
  }
  // At order 1 the finest is off by 1/7, 1/3 and 1 of its differences from the others.
  EXPECT_DOUBLE_EQ(extrapolate(halved, to_and_fro).uncertainty, 1.25);
  EXPECT_DOUBLE_EQ(extrapolate(halved, noisy).uncertainty, 1.25 * 2);
  EXPECT_STREQ(extrapolate(halved, to_and_fro).trend, "oscillating");
  EXPECT_STREQ(extrapolate(halved, noisy).trend, "noisy");
}

TEST(Extrapolation, EqualValuesAreExact) {
  const Extrapolation fit = extrapolate(halved, std::vector<double>{1, 1, 1, 1});
  EXPECT_EQ(fit.limit, 1);
  EXPECT_EQ(fit.uncertainty, 0);
  EXPECT_STREQ(fit.trend, "constant");
  const Extrapolation rounded = extrapolate(halved, std::vector<double>{1, 1.01, 1, 0.99}, 0.05);
  EXPECT_STREQ(rounded.trend, "constant");
  EXPECT_EQ(rounded.uncertainty, 0.05);
}

const ConvergedQuantity& quantity(const Convergence& found, const std::string& name) {
  return *std::ranges::find(found.quantities, name, &ConvergedQuantity::name);
}

testing::AssertionResult covers(const Extrapolation& fit, double exact, double most) {
  const bool good = std::abs(fit.limit - exact) <= fit.uncertainty && fit.uncertainty <= most * std::abs(exact);
  return (good ? testing::AssertionSuccess() : testing::AssertionFailure())
         << "exact " << exact << ", limit " << fit.limit << " +- " << fit.uncertainty << ", order " << fit.order;
}

/// A layer so thick that it is a half-plane: nu = 1/2, where pressing and dragging do not couple.
struct HalfPlane {
  static constexpr double H = 1000, E = 2, nu = 0.5;
  double softness = 2 * (1 - nu * nu) / (pi * E);  // displacement under a line force, to the factor ln(1 / |x|)
  fem::Scene scene{.sensor = {.length = 40 * H, .thickness = H, .young = E, .poisson = nu},
                   .model = fem::SurfaceModel::patch};

  /// The layer's part of the displacement near a line force: of u_y with sign -1, of u_x with 1 (docs/theory.md).
  static double layer_constant(double sign) {
    const auto f = [sign](double w) {
      const double D = std::cosh(2 * w) + 2 * w * w + 1;
      return (std::sinh(2 * w) + sign * 2 * w) / D - 1 + std::exp(-w);
    };
    double sum = 0;  // over ln w
    const double from = std::log(1e-6), step = (std::log(40.0) - from) / 20000;
    for (int k = 0; k < 20000; ++k) sum += step * f(std::exp(from + (k + 0.5) * step));
    return sum;
  }
};

TEST(Convergence, FlatPunchOnAHalfPlane) {
  HalfPlane half;
  const double a = 1, depth = 0.05;
  half.scene.indenter.shape = fem::Flat{a};
  half.scene.friction = 0;
  half.scene.load.indentation = {depth};
  const Convergence found = converge(solve(half.scene, {}), 0);
  ASSERT_EQ(found.rungs.size(), 4u);
  const double P = depth / half.softness / (std::log(2 * HalfPlane::H / a) + HalfPlane::layer_constant(-1));
  EXPECT_TRUE(covers(quantity(found, "P").fit, P, 1e-3));
}

TEST(Convergence, CattaneoAndMindlin) {
  HalfPlane half;
  const double R = 10, P = 0.1, mu = 0.5, inner = std::sqrt(0.5);
  const double a = std::sqrt(4 * P * R * (1 - HalfPlane::nu * HalfPlane::nu) / (pi * HalfPlane::E));
  const auto displacement = [&](double Q, double r) {
    return half.softness * Q * (std::log(2 * HalfPlane::H / r) + 0.5 + HalfPlane::layer_constant(1));
  };
  half.scene.indenter.shape = fem::Parabola{R};
  half.scene.friction = mu;
  half.scene.load = {.indentation = {}, .normal_force = {P}};
  half.scene.load.tangential = {displacement(mu * P, a) - displacement(mu * P * 0.5, inner * a)};
  const Convergence found = converge(solve(half.scene, {}), 1);
  EXPECT_EQ(found.step, 1u);
  EXPECT_TRUE(covers(quantity(found, "S").fit, 0.5, 2e-2));  // stick within c = a sqrt(1 - S); Johnson (7.28)
  EXPECT_TRUE(covers(quantity(found, "Q").fit, 0.5 * mu * P, 2e-2));
  EXPECT_STREQ(quantity(found, "P").fit.trend, "constant");  // given
}

TEST(Convergence, WideFlatOnABondedLayer) {
  // In the middle the layer strains in one direction: sigma = depth / H E (1 - nu) / ((1 + nu) (1 - 2 nu)).
  fem::Scene scene{.sensor = {.length = 80, .thickness = 1, .young = 2, .poisson = 0.3, .tactels = 3}};
  scene.indenter.shape = fem::Flat{12};
  scene.friction = std::numeric_limits<double>::infinity();
  scene.load.indentation = {0.01};
  const Convergence found = converge(solve(scene, {}), 0);
  // The widest elements are wider than the layer is thick: the uncertainty is that of few rungs.
  EXPECT_TRUE(covers(quantity(found, "sigma_y").fit, 0.01 * 2 * 0.7 / (1.3 * 0.4), 0.25));
}

TEST(Convergence, PathsUntilSlidingAreJudgedWhereAllHaveSteps) {
  fem::Scene scene;
  scene.indenter.shape = fem::Parabola{10};
  scene.load.tangential_step = 0.05;
  const SolveOutcome outcome = solve(scene, {});
  const Convergence found = converge(outcome, outcome.solution.steps.size() - 1);
  EXPECT_LT(found.step, outcome.solution.steps.size());
  EXPECT_GE(found.step, outcome.solution.steps.size() - 2);
  EXPECT_EQ(found.quantities.size(), 4u);
}

TEST(Convergence, WithoutContactThereIsNothingToFit) {
  fem::Scene scene;
  scene.load.indentation = {0};
  const Convergence found = converge(solve(scene, {}), 0);
  for (const ConvergedQuantity& q : found.quantities) EXPECT_STREQ(q.fit.trend, "constant") << q.name;
}

TEST(Convergence, TableAndJson) {
  const Extrapolation fit{.limit = 2, .uncertainty = 0.3, .order = 1.5, .slope = 1, .trend = "monotone"};
  const Convergence found{.step = 3,
                          .h = 0.4,
                          .rungs = {{"15 elements", 0.2, 0.1}, {"30 elements", 0.1, 1.25}},
                          .quantities = {{"P", "N/mm", 2.5, {2.25, 2.125}, {0.15}, fit},
                                         {"S", "", 0.5, {0.75, 0.25}, {0.5}, {0.25, 0.5, 0, 0, 0.35, "noisy"}}}};
  const std::string table = convergence_table(found);
  EXPECT_THAT(table, HasSubstr("convergence of step 4,"));
  EXPECT_THAT(table, HasSubstr("\n15 elements       0.2000    +0.12     +0.5\n"
                               "30 elements       0.1000   2.1250   0.2500\n"));
  EXPECT_THAT(table, HasSubstr("\nanswer - limit    0.4000     +0.5    +0.25\n"
                               "S: no order, for values scatter by 0.35; "));
  const nlohmann::ordered_json json = to_json(found);
  EXPECT_EQ(json["step"], 4);
  EXPECT_EQ(json["quantities"][0]["error"], 0.5);
  EXPECT_EQ(json["quantities"][0]["order"], 1.5);
  EXPECT_TRUE(json["quantities"][1]["order"].is_null());
  EXPECT_EQ(convergence_table({.missed = {{"60 elements", 2e-8, 1e-9}}}),
            "convergence is not judged: 60 elements missed the tolerance (residual 2e-08, 1e-09 is accepted)\n");
  EXPECT_EQ(convergence_table({}), "convergence is not judged: the answer's numbers are not finite\n");
}

TEST(PadConvergence, Hertz) {
  // A layer of 10^4 contact radii; K. L. Johnson, Contact Mechanics (1985), (4.22).
  const double nu = 0.3, R = 1, depth = 1e-4, a = std::sqrt(R * depth);
  fem::PadScene scene;
  scene.sensor = {.thickness = 1e4 * a, .young = 1, .poisson = nu};
  scene.indenter.shape = fem::Paraboloid{{R, R}};
  scene.friction = 0;
  scene.load.indentation = {depth};
  PadOutcome outcome;
  outcome.scene = scene;
  outcome.solution.steps.resize(1);
  outcome.solution.steps[0].stress = Eigen::MatrixX3d::Zero(16, 3);
  const Convergence found = converge(outcome, 0);
  EXPECT_EQ(found.rungs.size(), 5u);
  EXPECT_TRUE(covers(quantity(found, "P").fit, 4.0 / 3 / (1 - nu * nu) * std::sqrt(R) * std::pow(depth, 1.5), 5e-3));
}

}  // namespace tactel::host::convergence_test
