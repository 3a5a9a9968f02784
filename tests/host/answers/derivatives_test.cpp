// SPDX-License-Identifier: Apache-2.0

// Derivatives of answers against laws of scale and closed forms, which know nothing of differences, and against the
// device, which shares no code with the solver of the differences.
#include "host/answers/derivatives.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "host/support/errors.h"
#include "tests/thrown_message.h"

namespace tactel::host {
namespace {

using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;

/// A press and a drag in the middle of a strip so long that its ends do not count.
fem::Scene in_the_middle(const fem::Shape& shape) {
  return {.sensor = {.length = 30, .poisson = 0.45, .tactels = 4},
          .indenter = {shape, 0.3},
          .friction = 0.5,
          .load = {.indentation = {0.1, 0.15}, .tangential = {0.02, 0.05, 0.03}},
          .model = fem::SurfaceModel::patch};
}

ContactDerivatives derivatives_of(const fem::Scene& scene, const SolveOptions& options = {}) {
  return derivatives(scene, solve(scene, options));
}

/// p dy/dp summed over the parameters, each as often as `weight` of its unit; y is P, or S.
double weighted(const ContactDerivatives& d, std::size_t step, bool of_S, int (*weight)(const std::string& unit)) {
  double sum = 0;
  for (std::size_t i = 0; i < d.parameters.size(); ++i) {
    const fem::ContactStep& by = d.by[i][step];
    sum += weight(d.parameters[i].unit) * d.parameters[i].value * (of_S ? by.slip_index.value_or(0) : by.P);
  }
  return sum;
}

int of_length(const std::string& unit) { return unit == "mm" || unit == "N/mm" ? 1 : unit == "1/mm" ? -1 : 0; }
int of_stress(const std::string& unit) { return unit == "MPa" || unit == "N/mm"; }

/// By a parameter; zeros where it has none.
std::vector<fem::ContactStep> by(const ContactDerivatives& d, const std::string& name) {
  const auto found = std::ranges::find(d.parameters, name, &SceneParameter::name);
  EXPECT_NE(found, d.parameters.end()) << name;
  return found == d.parameters.end() ? std::vector<fem::ContactStep>(d.distance_to_switch.size())
                                     : d.by[static_cast<std::size_t>(found - d.parameters.begin())];
}

/// Where all stresses grow by a factor, or all lengths, P (N/mm) grows by it and S stays: Euler's theorem. A patch
/// grows with a flat alone. In the middle it does not matter where the indenter is. 1e-5: differences of answers to
/// rounding.
void expect_laws(const fem::Scene& scene, bool lengths = false) {
  constexpr double rounding = 1e-5;
  const SolveOutcome outcome = solve(scene, {});
  const ContactDerivatives d = derivatives(scene, outcome);
  for (std::size_t k = 0; k < d.distance_to_switch.size(); ++k) {
    SCOPED_TRACE(k);
    const double P = outcome.solution.steps[k].P;
    EXPECT_NEAR(weighted(d, k, false, of_stress), P, rounding * P);
    EXPECT_NEAR(weighted(d, k, true, of_stress), 0, rounding);
    if (scene.model == fem::SurfaceModel::patch) {
      EXPECT_NEAR(by(d, "indenter.position")[k].P, 0, 1e-4 * P);  // the free sides, 10 thicknesses away
      EXPECT_NEAR(by(d, "indenter.position")[k].slip_index.value_or(0), 0, 1e-4);
    }
    if (!lengths) continue;
    EXPECT_NEAR(weighted(d, k, false, of_length), P, 1e-4 * P);
    EXPECT_NEAR(weighted(d, k, true, of_length), 0, 1e-4);
  }
}

TEST(Derivatives, ObeyTheLawsOfScale) {
  for (const fem::Shape& shape : std::initializer_list<fem::Shape>{
           fem::Parabola{10}, fem::Wedge{150}, fem::Cylinder{8}, fem::Exponential{0.1, 0.5}, fem::Trapezoid{0.5, 0.3},
           fem::RoundedFlat{0.5, 8}, fem::Taylor{{2, 4}, 4, 0.4, {0.8, 0.3}}, fem::Flat{1.2}}) {
    SCOPED_TRACE(fem::shape_name(shape));
    expect_laws(in_the_middle(shape), std::holds_alternative<fem::Flat>(shape));
  }
}

TEST(Derivatives, ObeyTheLawsOfScaleUnderForcesAndOnMeshes) {
  fem::Scene by_force = in_the_middle(fem::Flat{1.2}), inclined = by_force, until_sliding = by_force;
  by_force.load = {.indentation = {}, .normal_force = {0.4, 0.6}, .tangential = {0.02, 0.04}};
  inclined.load = {.indentation = {}, .normal_force = {0.6}, .indentation_steps = 3, .angle = 12};
  until_sliding.load = fem::Load{.indentation = {0.1}}.drag_until_sliding(0.02);
  for (const fem::Scene& scene : {by_force, inclined, until_sliding}) expect_laws(scene, true);
  fem::Scene on_mesh = in_the_middle(fem::Parabola{10});
  on_mesh.model = fem::SurfaceModel::mesh;
  expect_laws(on_mesh);
}

/// The kernel's differences over 1e-4, whose residual of 1e-10 leaves 1e-5 of the largest; a status that changes on the
/// way, 1e-3.
TEST(Derivatives, AgreeWithDifferencesOfTheDevice) {
  fem::Scene scene = in_the_middle(fem::Parabola{12});
  scene.model = fem::SurfaceModel::mesh;
  scene.sensor.length = 20, scene.sensor.poisson = 0.4, scene.sensor.tactels = 10;
  const ContactDerivatives d = derivatives_of(scene);
  const auto check = [&](const char* name, const auto& value) {
    SCOPED_TRACE(name);
    constexpr double step = 1e-4;
    const auto at = [&](double by) {
      fem::Scene moved = scene;
      value(moved) += by;
      return solve(moved, {.precision = "fp64", .tolerance = 1e-10}).solution.steps;
    };
    const auto plus = at(step), minus = at(-step);
    const auto steps = by(d, name);
    double largest = 0, worst = 0, largest_S = 1e-9, worst_S = 0;
    for (std::size_t k = 0; k < steps.size(); ++k) {
      const Eigen::VectorXd sigma = (plus[k].sigma_y - minus[k].sigma_y) / (2 * step);
      const double S = (*plus[k].slip_index - *minus[k].slip_index) / (2 * step);
      largest = std::max(largest, sigma.cwiseAbs().maxCoeff());
      worst = std::max(worst, (sigma - steps[k].sigma_y).cwiseAbs().maxCoeff());
      largest_S = std::max(largest_S, std::abs(S)), worst_S = std::max(worst_S, std::abs(S - *steps[k].slip_index));
    }
    EXPECT_LE(worst, 1e-3 * largest);
    EXPECT_LE(worst_S, 1e-3 * largest_S);
  };
  check("indenter.radius", [](fem::Scene& s) -> double& { return std::get<fem::Parabola>(s.indenter.shape).radius; });
  check("indenter.position", [](fem::Scene& s) -> double& { return s.indenter.position; });
  check("contact.friction", [](fem::Scene& s) -> double& { return s.friction; });
  check("load.indentation[1]", [](fem::Scene& s) -> double& { return s.load.indentation[1]; });
  check("load.tangential[1]", [](fem::Scene& s) -> double& { return s.load.tangential[1]; });
  check("sensor.poisson", [](fem::Scene& s) -> double& { return s.sensor.poisson; });
  check("sensor.thickness", [](fem::Scene& s) -> double& { return s.sensor.thickness; });
}

TEST(Derivatives, AreOneSidedAtTheEndOfARange) {
  fem::Scene scene = in_the_middle(fem::Parabola{10});
  scene.friction = 0;
  scene.sensor.poisson = 0.5;
  const SolveOutcome outcome = solve(scene, {});
  const ContactDerivatives d = derivatives(scene, outcome);
  // It slides: Q = mu P.
  EXPECT_NEAR(by(d, "contact.friction")[3].Q, outcome.solution.steps[3].P, 1e-4 * outcome.solution.steps[3].P);
  EXPECT_GT(by(d, "sensor.poisson")[3].P, outcome.solution.steps[3].P);  // nearly incompressible rubber stiffens fast
}

/// Tables of stress have rows of h / 30: 600 of a sensor of 30 mm, or 601 where it is a little thinner; of one of
/// 29.725 mm 595 either way. Its ends are far: what they change is below 1e-3.
TEST(Derivatives, DoNotShowTheRowsOfTables) {
  const auto by_thickness = [](double length) {
    fem::Scene scene = in_the_middle(fem::Parabola{10});
    scene.sensor.length = length, scene.sensor.tactels = 10, scene.sensor.tactel_span = 9;
    const std::vector<fem::ContactStep> steps = by(derivatives_of(scene), "sensor.thickness");
    return Eigen::VectorXd(steps.back().sigma_y);
  };
  const Eigen::VectorXd at_a_row = by_thickness(30), between = by_thickness(29.725);
  EXPECT_LE((at_a_row - between).cwiseAbs().maxCoeff(), 1e-2 * between.cwiseAbs().maxCoeff());
}

/// From the answer's forces alone: no distance is larger than to the nearest change that they show.
TEST(Derivatives, TellHowNearAChangeOfStatusIs) {
  const fem::Scene scene = in_the_middle(fem::Parabola{10});
  const SolveOutcome outcome = solve(scene, {.precision = "fp64", .tolerance = 1e-9});
  const std::vector<double> distance = derivatives(scene, outcome).distance_to_switch;
  double nearest = 1, drawn_near = 0;
  for (std::size_t k = 0; k < distance.size(); ++k) {
    const fem::ContactStep& step = outcome.solution.steps[k];
    const double most = step.normal_force.maxCoeff();
    for (std::size_t i = 0; i < step.status.size(); ++i) {
      const double n = step.normal_force[Eigen::Index(i)], t = std::abs(step.tangential_force[Eigen::Index(i)]);
      if (step.status[i] != fem::GapStatus::open) nearest = std::min(nearest, n / most);
      if (step.status[i] == fem::GapStatus::stick) nearest = std::min(nearest, (0.5 * n - t) / (0.5 * most));
    }
    EXPECT_LE(distance[k], nearest * (1 + 1e-6)) << k;
    EXPECT_GE(distance[k], 0) << k;
    drawn_near += distance[k] > 1e-6;
  }
  EXPECT_GT(drawn_near, 0);
}

TEST(Derivatives, SayWhichAreMissing) {
  fem::Scene bonded = in_the_middle(fem::Profile{{-2, -0.5, 0.5, 2}, {1, 0, 0.1, 0.9}});
  bonded.friction = std::numeric_limits<double>::infinity();
  EXPECT_THAT(derivatives_of(bonded).missing,
              ElementsAre(Field(&NoDerivative::name, "indenter.y"), Field(&NoDerivative::name, "contact.friction")));
  fem::Scene flat = in_the_middle(fem::Flat{2});
  flat.indenter.position = 14;
  EXPECT_THAT(derivatives_of(flat).missing, ElementsAre(Field(&NoDerivative::name, "indenter.position"),
                                                        Field(&NoDerivative::reason, HasSubstr("beyond the sensor"))));
  EXPECT_THAT(
      thrown_message<ConfigError>([&] { derivatives_of(in_the_middle(fem::Parabola{10}), {.rung = "reference"}); }),
      HasSubstr("patch-24"));
}

}  // namespace
}  // namespace tactel::host
