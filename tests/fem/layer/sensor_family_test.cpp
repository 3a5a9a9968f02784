// SPDX-License-Identifier: Apache-2.0

// One set of tables for many sensors, against the tables of each.
#include "fem/layer/sensor_family.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <random>

#include "fem/layer/patch_solver.h"
#include "fem/numbers/value_error.h"

namespace tactel::fem::sensor_family_test {

constexpr SensorRange range{.poisson_low = 0.3, .poisson_high = 0.499, .longest = 14};

const SensorFamily& family() {
  static const SensorFamily family(range);
  return family;
}

Sensor sensor_of(double poisson, double thickness, double length) {
  return {.length = length, .thickness = thickness, .poisson = poisson};
}

TEST(SensorFamily, InterpolatesTheLayer) {
  double smooth = 0, stress = 0;
  for (const double poisson : {0.3, 0.3017, 0.4003, 0.4981, 0.499}) {
    const LayerKernels exact(poisson);
    const LayerModel model = family().model(sensor_of(poisson, 1, 14));
    EXPECT_EQ(model.table.poisson(), poisson);
    for (const double x : {0.03, 0.5, 1.3, 4.0, 9.0}) {
      const LayerKernelValues k = exact.at(x);
      const SmoothParts R = model.table.smooth_integral(x);
      smooth = std::max({smooth, std::abs(R.yy - k.smooth_integral.yy) / x, std::abs(R.xx - k.smooth_integral.xx) / x,
                         std::abs(R.xy - k.smooth_integral.xy) / x});
      // A tactel at the middle of the sensor, forces at x: the ends, 7 h away, change it by e^-0.75 to the power 7.
      const Eigen::VectorXd row = model.base.at(x);
      const Eigen::Index tactels = model.sensor.tactels, middle = tactels / 2;
      if (x > 1.5) continue;
      stress = std::max({stress, std::abs(-row[middle] - k.base.sigma_by_y),
                         std::abs(row[BaseStressTable::tau_by_traction * tactels + middle] - k.base.tau_by_x)});
    }
  }
  EXPECT_LT(smooth, 1e-4);
  EXPECT_LT(stress, 5e-3);
}

/// Against the model of that sensor, which integrates over the width in closed form. 0.01 of the largest is what
/// stresses of a family may be off (docs/claims.md).
TEST(SensorFamily, TactelsMayHaveAWidth) {
  Sensor sensor = sensor_of(0.45, 1.5, 20);
  sensor.tactels = range.tactels;
  sensor.tactel_span = 17;
  sensor.tactel_width = 17.0 / (sensor.tactels - 1);
  const LayerModel own = layer_model(sensor), of_family = family().model(sensor);
  double largest = 0, off = 0, points = 0;
  Sensor narrow = sensor;
  narrow.tactel_width = 0;
  const LayerModel as_points = family().model(narrow);
  for (double x = -9; x <= 9; x += 0.35) {
    const Eigen::RowVectorXd row = own.base.at(x);
    largest = std::max(largest, row.cwiseAbs().maxCoeff());
    off = std::max(off, (of_family.base.at(x) - row).cwiseAbs().maxCoeff());
    points = std::max(points, (as_points.base.at(x) - row).cwiseAbs().maxCoeff());
  }
  EXPECT_LT(off, 0.01 * largest);
  EXPECT_GT(points, 0.02 * largest) << "a width that counts";
}

TEST(SensorFamily, ScalesWithThickness) {
  const LayerModel thin = family().model(sensor_of(0.45, 1, 12)), thick = family().model(sensor_of(0.45, 2, 24));
  for (const double x : {-5.5, -2.0, 0.3, 5.9}) {
    const FreeSides::At a = thin.sides.at(x), b = thick.sides.at(2 * x);
    EXPECT_NEAR(thin.sides.between(a.y, a.y), thick.sides.between(b.y, b.y), 1e-12);
    EXPECT_NEAR(thin.sides.between(a.x, a.y), thick.sides.between(b.x, b.y), 1e-12);
    EXPECT_LT((thin.base.at(x) - 2 * thick.base.at(2 * x)).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(SensorFamily, EndsMirrorEachOther) {
  const LayerModel model = family().model(sensor_of(0.42, 1.5, 20));
  const auto between = [&](double to, double by, bool to_x, bool by_x) {
    const FreeSides::At a = model.sides.at(to), b = model.sides.at(by);
    return model.sides.between(to_x ? a.x : a.y, by_x ? b.x : b.y);
  };
  for (const double x : {9.5, 8.0, 6.0}) {
    EXPECT_NEAR(between(x, x - 1, false, false), between(-x, 1 - x, false, false), 1e-13);
    EXPECT_NEAR(between(x, x - 1, true, true), between(-x, 1 - x, true, true), 1e-13);
    EXPECT_NEAR(between(x, x - 1, true, false), -between(-x, 1 - x, true, false), 1e-13);
    EXPECT_NEAR(between(x, x - 1, true, false), between(x - 1, x, false, true), 1e-13);  // Betti
  }
}

/// Errors that the tables add to a contact, over random sensors and places on them: those of docs/claims.md.
void expect_agreement(double shortest, double longest, double larger) {
  std::mt19937_64 generator(5);
  const auto uniform = [&](double from, double to) { return std::uniform_real_distribution(from, to)(generator); };
  std::vector<double> slip, force, stress;
  for (int i = 0; i < 12; ++i) {
    const double thickness = uniform(0.8, 2.5);
    const Sensor sensor =
        sensor_of(uniform(range.poisson_low, range.poisson_high), thickness, thickness * uniform(shortest, longest));
    const LayerModel own = layer_model(sensor), shared = family().model(sensor);
    for (int k = 0; k < 8; ++k) {
      const Scene scene{.sensor = sensor,
                        .indenter = {Parabola{std::exp(uniform(0, 4))}, uniform(-0.47, 0.47) * sensor.length},
                        .friction = uniform(0.1, 1.5),
                        .load = {.indentation = {uniform(0.01, 0.1) * thickness},
                                 .tangential_step = uniform(0.005, 0.03) * thickness,
                                 .tangential_steps = 8}};
      const PatchOptions options{.elements = 12, .tolerance = 1e-9};
      const ContactSolution a = PatchSolver(own, options).solve(scene), b = PatchSolver(shared, options).solve(scene);
      double S = 0, P = 0, sigma = 0;
      for (std::size_t j = 0; j < std::min(a.steps.size(), b.steps.size()); ++j) {
        const ContactStep &p = a.steps[j], &q = b.steps[j];
        if (!p.converged || !q.converged || !p.slip_index) continue;
        S = std::max(S, std::abs(*p.slip_index - *q.slip_index));
        P = std::max({P, std::abs(p.P - q.P) / p.P, std::abs(p.Q - q.Q) / p.P});
        const double largest = p.sigma_y.cwiseAbs().maxCoeff();
        sigma = std::max({sigma, (p.sigma_y - q.sigma_y).cwiseAbs().maxCoeff() / largest,
                          (p.tau_xy - q.tau_xy).cwiseAbs().maxCoeff() / largest});
      }
      slip.push_back(S), force.push_back(P), stress.push_back(sigma);
    }
  }
  const auto at = [](std::vector<double>& errors, double part) {
    std::ranges::sort(errors);
    return errors[static_cast<std::size_t>(part * static_cast<double>(errors.size() - 1))];
  };
  std::cout << shortest << " to " << longest << " thicknesses\n";
  for (auto& [name, errors] : {std::pair{"S", &slip}, {"P, Q", &force}, {"stresses", &stress}})
    std::cout << name << ": median " << at(*errors, 0.5) << ", 95 % " << at(*errors, 0.95) << ", largest "
              << errors->back() << '\n';
  EXPECT_LT(at(slip, 0.5), larger * 5e-5);
  EXPECT_LT(at(slip, 0.95), larger * 1e-3);
  EXPECT_LT(slip.back(), larger * 5e-3);
  EXPECT_LT(at(force, 0.95), larger * 2e-3);
  EXPECT_LT(at(stress, 0.95), larger * 1e-2);
}

TEST(SensorFamily, AgreesWithTheModelOfEachSensor) {
  expect_agreement(8, 14, 1);
  expect_agreement(shortest_of_family, 8, 3);
}

}  // namespace tactel::fem::sensor_family_test
