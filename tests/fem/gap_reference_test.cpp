// SPDX-License-Identifier: Apache-2.0
#include "fem/gap/gap_reference.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "fem/gap/contact_laws.h"
#include "fem/mesh/condensation.h"

namespace tactel::fem::gap_reference_test {

// Residual from surface forces alone: displacements by the condensed compliance (another factorization, another route),
// gaps from the profile, slips from the displacements of the step before.
class ForceWitness {
 public:
  ForceWitness(const Scene& scene, const Condensation& condensation)
      : scene_(scene),
        condensation_(condensation),
        before_(Eigen::VectorXd::Zero(condensation.compliance.rows())),
        height_(profile_heights(scene.indenter, condensation.surface_x)) {}

  Residual next(const ContactStep& step) {
    const Eigen::Index n = height_.size();
    Eigen::VectorXd load(2 * n);
    load.reshaped(2, n) << step.tangential_force.transpose(), -step.normal_force.transpose();
    const Eigen::VectorXd u = condensation_.compliance * load / scene_.sensor.young;
    const GapElements elements{
        .mu = scene_.friction,
        .gap = height_.array() - step.indentation - u.reshaped(2, n).row(1).transpose().array(),
        .slip = (u - before_).reshaped(2, n).row(0).transpose().array() - (step.tangential - tangential_),
        .normal_force = step.normal_force,
        .tangential_force = step.tangential_force,
        .base_force = {step.base_force_x.sum(), step.base_force_y.sum()},
        .largest_displacement = u.reshaped(2, n).colwise().norm().maxCoeff()};
    base_error_ = (condensation_.base_force * load).reshaped(2, step.base_force_x.size());
    base_error_.row(0) -= step.base_force_x.transpose();
    base_error_.row(1) -= step.base_force_y.transpose();
    dissipated_ = -elements.slip.cwiseProduct(step.tangential_force).array() / (step.P * elements.largest_displacement);
    before_ = u;
    tangential_ = step.tangential;
    return contact_residual(elements);
  }

  /// Of the last step: largest difference between base nodal forces, over the largest of them.
  double base_error(const ContactStep& step) const {
    return base_error_.cwiseAbs().maxCoeff() /
           std::max(step.base_force_x.cwiseAbs().maxCoeff(), step.base_force_y.cwiseAbs().maxCoeff());
  }
  /// Of the last step: what friction dissipated at each node, over P times the largest displacement.
  double least_dissipation() const { return dissipated_.minCoeff(); }

 private:
  const Scene& scene_;
  const Condensation& condensation_;
  Eigen::VectorXd before_, height_;
  Eigen::MatrixXd base_error_;
  Eigen::ArrayXd dissipated_;
  double tangential_ = 0;
};

const std::vector<Shape>& all_shapes() {
  static const std::vector<Shape> shapes{Flat{},
                                         Flat{2.0},
                                         Wedge{150},
                                         Parabola{10},
                                         Cylinder{8},
                                         Exponential{0.1, 0.5},
                                         Trapezoid{1.5, 0.3},
                                         RoundedFlat{1.5, 6},
                                         Taylor{{1, 3}, 10.0},
                                         Profile{{-6, -3, -1, 2, 5}, {1.2, 0.3, 0, 0.1, 1.0}, 0, ""}};
  return shapes;
}

struct ShapeCase {
  std::size_t shape;
  double poisson;
};

class EveryShape : public testing::TestWithParam<ShapeCase> {};

void expect_symmetric(const ContactStep& step, double tolerance) {
  const double scale = step.normal_force.maxCoeff();
  EXPECT_LT((step.normal_force - step.normal_force.reverse()).cwiseAbs().maxCoeff(), tolerance * scale);
  EXPECT_LT((step.tangential_force + step.tangential_force.reverse()).cwiseAbs().maxCoeff(), tolerance * scale);
}

// Mesh B; two depths, then a drag and its reversal.
TEST_P(EveryShape, MeetsTheLawsAtEveryFriction) {
  Scene scene{.sensor = {.poisson = GetParam().poisson},
              .indenter = {.shape = all_shapes()[GetParam().shape]},
              .load = {.indentation_steps = 2, .tangential = {0.06, 0.12, 0.25, 0.1, -0.1}}};
  GapReference solver(scene.sensor);
  const Condensation condensation = condense(scene.sensor);
  for (double mu : {0.0, 0.2, 0.5, 1.0, 5.0}) {
    SCOPED_TRACE("mu " + std::to_string(mu));
    scene.friction = mu;
    ForceWitness witness(scene, condensation);
    const ContactSolution solution = solver.solve(scene);
    ASSERT_EQ(solution.steps.size(), 7u);
    for (const ContactStep& step : solution.steps) {
      EXPECT_TRUE(step.converged);
      // The factors of the condensation are in double: cond(K) rounding errors, 1e-10 at nu = 0.4999.
      EXPECT_LT(largest(witness.next(step)), 1e-9);
      EXPECT_LT(witness.base_error(step), 1e-9);
      EXPECT_GE(witness.least_dissipation(), -1e-9);  // rounding where nodes stick
      EXPECT_LT(std::abs(step.P + step.base_force_y.sum()), 1e-10 * step.P);
    }
    const bool even = !std::holds_alternative<Profile>(scene.indenter.shape);
    if (even) expect_symmetric(solution.steps[1], 1e-11);  // rounding of K, 1e-16 / (1 - 2 nu), in forces
  }
}

std::vector<ShapeCase> all_cases() {
  std::vector<ShapeCase> cases;
  for (std::size_t shape = 0; shape < all_shapes().size(); ++shape)
    for (double poisson : {0.0, 0.3, 0.45, 0.49, 0.4999}) cases.push_back({shape, poisson});
  return cases;
}

INSTANTIATE_TEST_SUITE_P(OnMeshB, EveryShape, testing::ValuesIn(all_cases()), [](const auto& info) {
  const int digits = int(std::lround(info.param.poisson * 1e4));
  return shape_name(all_shapes()[info.param.shape]) + std::to_string(info.param.shape) + "_nu" + std::to_string(digits);
});

// A random scene: shape, place, friction, path by depth or force, several reversals.
Scene random_scene(std::mt19937& generator, const Sensor& sensor, double most_friction) {
  const auto uniform = [&](double from, double to) { return std::uniform_real_distribution(from, to)(generator); };
  Scene scene;
  scene.sensor = sensor;
  scene.friction = uniform(0, most_friction);
  scene.indenter.position = uniform(-3, 3);
  switch (generator() % 6) {
    case 0:
      scene.indenter.shape = Parabola{std::exp(uniform(0, 4.6))};
      break;
    case 1:
      scene.indenter.shape = Wedge{uniform(90, 178)};
      break;
    case 2:
      scene.indenter.shape = Cylinder{uniform(1, 30)};
      break;
    case 3:
      scene.indenter.shape = Trapezoid{uniform(0.2, 4), uniform(0.05, 2)};
      break;
    case 4:
      scene.indenter.shape = RoundedFlat{uniform(0.2, 4), uniform(1, 30)};
      break;
    default:
      scene.indenter.shape = Flat{uniform(0.6, 6)};
  }
  if (generator() % 3 == 0) {
    scene.load.normal_force = {uniform(0.1, 3)};
    if (generator() % 2) scene.load.angle = std::atan(scene.friction * uniform(-0.99, 0.99)) * 180 / std::numbers::pi;
  } else {
    scene.load.indentation = {uniform(0.02, 0.3), uniform(0.02, 0.3)};
  }
  scene.load.indentation_steps = 1 + int(generator() % 3);
  if (scene.load.angle) return scene;
  for (double x = 0; scene.load.tangential.size() < 6;) scene.load.tangential.push_back(x += uniform(-0.15, 0.15));
  return scene;
}

// Friction up to 1: every increment must converge. Beyond, solutions may be several, but the path finds one here too.
TEST(GapReferenceRandom, ThousandScenesConverge) {
  std::mt19937 generator(2024);
  Sensor sensor{.columns = 21, .rows = 5};
  for (double most_friction : {1.0, 5.0}) {
    int increments = 0, converged = 0, with_path = 0, most_iterations = 0;
    long iterations = 0;
    for (double poisson : {0.0, 0.3, 0.45, 0.49, 0.4999}) {
      sensor.poisson = poisson;
      GapReference solver(sensor);
      for (int k = 0; k < (most_friction > 1 ? 40 : 200); ++k) {
        for (const ContactStep& step : solver.solve(random_scene(generator, sensor, most_friction)).steps) {
          ++increments;
          converged += step.converged;
          iterations += step.iterations;
          most_iterations = std::max(most_iterations, step.iterations);
          with_path += step.iterations > 12;
        }
      }
    }
    EXPECT_EQ(converged, increments) << "friction up to " << most_friction;
    std::printf(
        "friction up to %g: %d of %d increments converged, %.2f iterations each, at most %d, %d took more than 12\n",
        most_friction, converged, increments, double(iterations) / increments, most_iterations, with_path);
  }
}

Scene dragged_parabola() { return {.load = {.indentation_steps = 3, .tangential_step = 0.05, .tangential_steps = 4}}; }

TEST(GapReference, EveryElementAndRecoveryIsServed) {
  for (Element element : {Element::bbar, Element::q4, Element::q4i, Element::q8}) {
    for (StressRecovery recovery : {StressRecovery::reaction, StressRecovery::element}) {
      Scene scene = dragged_parabola();
      scene.sensor.element = element;
      scene.sensor.stress = recovery;
      SCOPED_TRACE(std::string(name(element)) + " " + name(recovery));
      const ContactSolution solution = solve_gap_reference(scene);
      const Condensation condensation = condense(scene.sensor);
      ASSERT_EQ(solution.base_x.size(), condensation.base_x.size());
      EXPECT_EQ(solution.tactel_x, condensation.tactel_x);
      ForceWitness witness(scene, condensation);
      for (const ContactStep& step : solution.steps) {
        EXPECT_TRUE(step.converged);
        EXPECT_LT(largest(witness.next(step)), 1e-11);  // nu = 0.45: the condensation loses four digits
        EXPECT_LT(witness.base_error(step), 1e-11);
        Eigen::VectorXd load(2 * step.normal_force.size());
        load.reshaped(2, step.normal_force.size()) << step.tangential_force.transpose(), -step.normal_force.transpose();
        const Eigen::VectorXd stress = condensation.tactel_stress * load;
        const double scale = stress.cwiseAbs().maxCoeff();
        EXPECT_LT((stress.head(step.sigma_y.size()) - step.sigma_y).cwiseAbs().maxCoeff(), 1e-11 * scale);
        EXPECT_LT((stress.tail(step.tau_xy.size()) - step.tau_xy).cwiseAbs().maxCoeff(), 1e-11 * scale);
      }
    }
  }
}

TEST(GapReference, StopsWhereTheWholeContactSlides) {
  Scene scene = dragged_parabola();
  scene.load.tangential_steps.reset();
  const ContactSolution solution = solve_gap_reference(scene);
  ASSERT_TRUE(solution.sliding);
  const ContactStep &last = solution.steps.back(), &before = solution.steps[solution.steps.size() - 2];
  EXPECT_NEAR(*last.slip_index, 1, 1e-12);
  EXPECT_LT(*before.slip_index, 1 - 1e-3);
  EXPECT_EQ(std::count(last.status.begin(), last.status.end(), GapStatus::stick), 0);
  EXPECT_GT(std::count(before.status.begin(), before.status.end(), GapStatus::stick), 0);
}

TEST(GapReference, DraggingToEitherSideIsMirrored) {
  Scene scene = dragged_parabola();
  const ContactStep right = solve_gap_reference(scene).steps.back();
  scene.load.tangential_step = -scene.load.tangential_step;
  const ContactStep left = solve_gap_reference(scene).steps.back();
  EXPECT_GT(right.Q, 0);
  EXPECT_GT(right.tau_xy.sum(), 0);  // the drag to +x is felt as positive shear, pressure as negative sigma_y
  EXPECT_LT(right.sigma_y.sum(), 0);
  EXPECT_LT((right.normal_force - left.normal_force.reverse()).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((right.tangential_force + left.tangential_force.reverse()).cwiseAbs().maxCoeff(), 1e-12);
}

// What a run by depth needs as force, given as force, leads to the same depth and forces.
TEST(GapReference, ForceAndDepthAgree) {
  for (double poisson : {0.3, 0.4999}) {
    Scene scene = dragged_parabola();
    scene.sensor.poisson = poisson;
    scene.load.indentation_steps = 1;
    scene.load.tangential_steps = 0;
    const ContactStep by_depth = solve_gap_reference(scene).steps.back();
    scene.load.normal_force = {by_depth.P};
    const ContactStep by_force = solve_gap_reference(scene).steps.back();
    EXPECT_TRUE(by_force.converged);
    EXPECT_NEAR(by_force.indentation, by_depth.indentation, 1e-12 * by_depth.indentation);
    EXPECT_LT((by_force.normal_force - by_depth.normal_force).cwiseAbs().maxCoeff(), 1e-12 * by_depth.P);
    EXPECT_LT((by_force.tangential_force - by_depth.tangential_force).cwiseAbs().maxCoeff(), 1e-12 * by_depth.P);
  }
}

TEST(GapReference, AnAngleKeepsItsRatioOfForces) {
  const Scene scene{.load = {.normal_force = {1.5}, .indentation_steps = 4, .angle = 20}};
  for (const ContactStep& step : solve_gap_reference(scene).steps) {
    EXPECT_TRUE(step.converged);
    EXPECT_NEAR(step.Q / step.P, std::tan(20 * std::numbers::pi / 180), 1e-12);
    EXPECT_NEAR(*step.slip_index, std::tan(20 * std::numbers::pi / 180) / 0.5, 1e-12);  // S = tan theta / tan theta_L
  }
}

TEST(GapReference, YoungsModulusOnlyScalesForces) {
  Scene scene = dragged_parabola();
  const ContactSolution soft = solve_gap_reference(scene);
  scene.sensor.young = 2e4;
  const ContactSolution hard = solve_gap_reference(scene);
  for (std::size_t k = 0; k < soft.steps.size(); ++k) {
    EXPECT_NEAR(hard.steps[k].P, 1e4 * soft.steps[k].P, 1e-12 * hard.steps[k].P);
    EXPECT_NEAR(hard.steps[k].Q, 1e4 * soft.steps[k].Q, 1e-12 * hard.steps[k].P);
    EXPECT_EQ(hard.steps[k].status, soft.steps[k].status);
  }
}

TEST(GapReference, UnloadingEndsWithoutForces) {
  const Scene scene{.load = {.indentation = {0.15, 0.05, 0}}};
  const ContactSolution solution = solve_gap_reference(scene);
  EXPECT_GT(solution.steps[0].P, solution.steps[1].P);
  EXPECT_TRUE(solution.steps[2].converged);
  EXPECT_EQ(solution.steps[2].P, 0);
  EXPECT_FALSE(solution.steps[2].slip_index);
  EXPECT_EQ(solution.steps[2].base_force_y.cwiseAbs().maxCoeff(), 0);
}

TEST(GapReference, WithoutFrictionThereIsNoSlipIndex) {
  Scene scene = dragged_parabola();
  scene.friction = 0;
  const ContactStep step = solve_gap_reference(scene).steps.back();
  EXPECT_FALSE(step.slip_index);
  EXPECT_LT(std::abs(step.Q), 1e-14);
  EXPECT_EQ(std::count(step.status.begin(), step.status.end(), GapStatus::stick), 0);
}

TEST(GapReference, RefusesASceneOnAnotherSensor) {
  GapReference solver{Sensor{}};
  const Scene scene{.sensor = {.columns = 21}};
  EXPECT_THROW(solver.solve(scene), std::invalid_argument);
}

TEST(GapReference, RefusesAScenesBadValue) {
  const Scene scene{.friction = -1};
  EXPECT_THROW(solve_gap_reference(scene), std::invalid_argument);
}

}  // namespace tactel::fem::gap_reference_test
