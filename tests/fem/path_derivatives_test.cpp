// SPDX-License-Identifier: Apache-2.0

// Derivatives of load paths: one element by hand.
#include "fem/path_derivatives.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "fem/shape_derivatives.h"

namespace tactel::fem {
namespace {

/// One element of compliance a in x and b in y, pressed by `depth` and dragged by `x`; one tactel of weights 0.5 and 2.
ContactPath one_element(Trial trial, bool by_force) {
  ContactPath path{.compliance = Eigen::Vector2d(0.25, 0.5).asDiagonal(),
                   .tactel_stress = Eigen::Vector2d(0.5, 2).asDiagonal(),
                   .height = Eigen::VectorXd::Constant(1, 0.02),
                   .mu = 0.4,
                   .young = 2};
  path.increments.resize(2);
  path.increments[0] = {.target = {by_force, false, by_force ? 0.32 : 0.1, 0}, .trial = {Trial::stick}};
  path.increments[1] = {.target = {by_force, false, by_force ? 0.32 : 0.1, 0.01}, .trial = {trial}};
  return path;
}

TEST(PathDerivatives, OneStickingElementByHand) {
  // n = E (depth - h) / b = 2 * 0.08 / 0.5, t = E x / a = 2 * 0.01 / 0.25, S = t / (mu n).
  const PathDerivatives path(one_element(Trial::stick, false));
  const PathAnswer& a = path.answers()[1];
  EXPECT_NEAR(a.P, 0.32, 1e-15);
  EXPECT_NEAR(a.Q, 0.08, 1e-15);
  EXPECT_NEAR(*a.S, 0.625, 1e-15);
  EXPECT_NEAR(a.frame[0], 0.5 * 0.08, 1e-15);
  EXPECT_NEAR(a.frame[1], -2 * 0.32, 1e-15);
  EXPECT_NEAR(a.distance_to_switch, 1 - 0.625, 1e-15);  // (mu n - t) / (mu n)
  const PathAnswer by_mu = path.forward({.mu = 1})[1];
  EXPECT_NEAR(*by_mu.S, -0.625 / 0.4, 1e-14);
  EXPECT_EQ(by_mu.P, 0);
  const PathAnswer by_E = path.forward({.young = 1})[1];
  EXPECT_NEAR(*by_E.S, 0, 1e-15);
  EXPECT_NEAR((by_E.frame - a.frame / 2).norm(), 0, 1e-15);
  const PathAnswer by_depth = path.forward({.normal = Eigen::Vector2d::Ones()})[1];
  EXPECT_NEAR(by_depth.P, 4, 1e-14);
  EXPECT_NEAR(*by_depth.S, -0.625 / 0.08, 1e-13);
  const PathAnswer by_height = path.forward({.height = Eigen::VectorXd::Ones(1)})[1];
  EXPECT_NEAR(by_height.P, -4, 1e-14);
  const PathAnswer by_drag = path.forward({.tangential = Eigen::Vector2d(0, 1)})[1];
  EXPECT_NEAR(by_drag.Q, 8, 1e-14);
  const PathAnswer by_b = path.forward({.compliance = Eigen::Vector2d(0, 1).asDiagonal()})[1];
  EXPECT_NEAR(by_b.P, -0.32 / 0.5, 1e-14);
}

TEST(PathDerivatives, OneSlidingElementByHand) {
  ContactPath given = one_element(Trial::slip_plus, false);
  given.increments[1].target.tangential = 0.03;
  const PathDerivatives path(given);
  EXPECT_NEAR(*path.answers()[1].S, 1, 1e-15);
  EXPECT_NEAR(*path.forward({.mu = 1})[1].S, 0, 1e-15);
  EXPECT_NEAR(path.forward({.mu = 1})[1].Q, 0.32, 1e-15);
  // u_x = a t / E = 0.25 * 0.128 / 2 = 0.016, 0.014 short of the drag, over the largest displacement 0.08.
  EXPECT_NEAR(path.answers()[1].distance_to_switch, 0.014 / 0.08, 1e-14);
}

TEST(PathDerivatives, GivenForceMovesTheIndenter) {
  const PathDerivatives path(one_element(Trial::stick, true));
  const PathAnswer& a = path.answers()[1];
  EXPECT_NEAR(a.depth, 0.1, 1e-15);
  // depth = h + b P / E.
  const PathAnswer by_E = path.forward({.young = 1})[1];
  EXPECT_NEAR(by_E.P, 0, 1e-15);
  EXPECT_NEAR(by_E.depth, -0.08 / 2, 1e-15);
  EXPECT_NEAR(by_E.frame[1], 0, 1e-15);
  EXPECT_NEAR(path.forward({.normal = Eigen::Vector2d::Ones()})[1].depth, 0.25, 1e-15);
}

TEST(PathDerivatives, WrongSizesAreRefused) {
  ContactPath path = one_element(Trial::stick, false);
  path.height = Eigen::VectorXd::Zero(2);
  EXPECT_THROW(PathDerivatives{path}, std::invalid_argument);
}

TEST(ShapeDerivatives, AgreeWithCentralDifferences) {
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(8, -1.3, 1.5);
  constexpr double step = 1e-5;
  const auto check = [&](const Indenter& indenter, const std::string& key,
                         const std::function<void(Indenter&, double)>& move) {
    Indenter plus = indenter, minus = indenter;
    move(plus, step);
    move(minus, -step);
    const Eigen::VectorXd slope = (profile_heights(plus, x) - profile_heights(minus, x)) / (2 * step);
    for (const HeightDerivative& d : height_derivatives(indenter, x))
      if (d.key == key) {
        EXPECT_LE((slope - d.height).cwiseAbs().maxCoeff(), 1e-8) << key;
        return;
      }
    ADD_FAILURE() << key << " is missing";
  };
  const auto number = [](auto member) {
    return [member](Indenter& indenter, double by) {
      std::visit(
          [&](auto& s) {
            if constexpr (requires { s.*member; }) s.*member += by;
          },
          indenter.shape);
    };
  };
  const Taylor taylor{{1, 3}, 1.7, 0.4, {0.8, 0.3}}, plain{{2, 3}, 1.7};
  check({Wedge{150}, 0.1}, "edge_angle", number(&Wedge::edge_angle));
  check({Parabola{4}, 0.1}, "radius", number(&Parabola::radius));
  check({Cylinder{4}, 0.1}, "radius", number(&Cylinder::radius));
  check({Exponential{0.2, 0.7}, 0.1}, "height", number(&Exponential::height));
  check({Exponential{0.2, 0.7}, 0.1}, "rate", number(&Exponential::rate));
  check({Trapezoid{0.5, 0.7}, 0.1}, "half_width", number(&Trapezoid::half_width));
  check({Trapezoid{0.5, 0.7}, 0.1}, "slope", number(&Trapezoid::slope));
  check({RoundedFlat{0.5, 3}, 0.1}, "half_width", number(&RoundedFlat::half_width));
  check({RoundedFlat{0.5, 3}, 0.1}, "radius", number(&RoundedFlat::radius));
  check({taylor, 0.1}, "scale", number(&Taylor::scale));
  check({plain, 0.1}, "scale", number(&Taylor::scale));
  check({taylor, 0.1}, "height", [](Indenter& i, double by) { *std::get<Taylor>(i.shape).height += by; });
  check({taylor, 0.1}, "coefficients[1]",
        [](Indenter& i, double by) { std::get<Taylor>(i.shape).coefficients[1] += by; });
}

}  // namespace
}  // namespace tactel::fem
