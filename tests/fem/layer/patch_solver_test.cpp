// SPDX-License-Identifier: Apache-2.0

// The relaxed sweeps on a patch against the exact solver on the same elements, which shares nothing with them but the
// compliance; laws of the load path; closed forms of a half-plane.
#include "fem/layer/patch_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "fem/gap/contact_laws.h"
#include "fem/gap/gap_condensed.h"
#include "fem/layer/patch_exact.h"
#include "fem/layer/patch_laws.h"
#include "layer_sensors.h"

namespace tactel::fem::patch_solver_test {

constexpr double bonded = std::numeric_limits<double>::infinity();

Load by_depth(std::vector<double> depths, std::vector<double> tangential) {
  return {.indentation = std::move(depths), .tangential = std::move(tangential)};
}
Load by_force_load(std::vector<double> forces, std::vector<double> tangential) {
  return {.indentation = {}, .normal_force = std::move(forces), .tangential = std::move(tangential)};
}

/// Largest difference of tactel stresses and forces over the largest stress and force.
double difference(const ContactStep& a, const ContactStep& b) {
  const double stress = std::max(b.sigma_y.cwiseAbs().maxCoeff(), b.tau_xy.cwiseAbs().maxCoeff());
  const double off =
      std::max((a.sigma_y - b.sigma_y).cwiseAbs().maxCoeff(), (a.tau_xy - b.tau_xy).cwiseAbs().maxCoeff());
  const double force = std::max(std::abs(b.P), std::abs(b.Q)),
               force_off = std::max(std::abs(a.P - b.P), std::abs(a.Q - b.Q));
  return std::max(stress > 0 ? off / stress : off, force > 0 ? force_off / force : force_off);
}

struct LoadCase {
  const char* name;
  Load load;
  bool slides_at_mu_0 = false;
  bool several_if_bonded = false;  ///< bonded contacts that lose and regain elements have several solutions
};

std::vector<LoadCase> load_cases() {
  Load angle = by_force_load({0.5}, {});
  angle.angle = 8;
  angle.indentation_steps = 3;
  Load unloading = by_depth({0.2, 0.05, 0.12}, {0.03});
  unloading.indentation_steps = 2;
  return {{"drag and back", by_depth({0.15}, {0.02, 0.05, 0.1, 0.05, 0})},
          {"unloading", unloading, false, true},
          {"lifted off", by_depth({0.1, 0, 0.08}, {0.02})},
          {"force", by_force_load({0.3, 0.6}, {0.05, -0.05}), false, true},
          {"angle", angle, true}};
}

/// A shape with a name for test lists.
struct ShapeCase {
  Shape shape;
};
void PrintTo(const ShapeCase& c, std::ostream* out) { *out << shape_name(c.shape); }

class PatchShapes : public testing::TestWithParam<ShapeCase> {};

TEST_P(PatchShapes, SweepsAgreeWithTheExactSolver) {
  for (const double nu : {0.3, 0.49})
    for (const double mu : {0.0, 0.3, 0.9, bonded})
      for (const LoadCase& c : load_cases()) {
        if ((c.slides_at_mu_0 && mu == 0) || (c.several_if_bonded && mu == bonded)) continue;
        SCOPED_TRACE(testing::Message() << "nu " << nu << " mu " << mu << " " << c.name);
        const LayerModel& model = endless(nu);
        const Scene scene = scene_on(model, GetParam().shape, -0.6, mu, c.load);
        const Patch patch = find_patch(scene, model.table, 12).patch;
        // Increments as the load has them, and touched at their ends, so that both take the same path.
        const PatchSolver solver(
            model,
            {.tolerance = 1e-12, .accept = 1e-8, .pressing_increments = 1, .most_sweeps = 20000, .entries = false});
        const ContactSolution found = solver.solve_on(patch, scene);
        const ContactSolution truth = GapCondensed(patch_condensation(model, patch)).solve(scene);
        ASSERT_EQ(found.steps.size(), truth.steps.size());
        for (std::size_t k = 0; k < truth.steps.size(); ++k) {
          ASSERT_TRUE(truth.steps[k].converged);
          EXPECT_TRUE(found.steps[k].converged) << k << " residual " << largest(found.steps[k].residual);
          // Forces are met to ten tolerances; the contraction of the sweeps is above 0.9 in no case.
          EXPECT_LT(difference(found.steps[k], truth.steps[k]), 1e-9) << k;
          EXPECT_NEAR(found.steps[k].slip_distance, truth.steps[k].slip_distance, 1e-9) << k;
        }
      }
}
INSTANTIATE_TEST_SUITE_P(Shapes, PatchShapes,
                         testing::Values(ShapeCase{Flat{2.0}}, ShapeCase{Flat{}}, ShapeCase{Wedge{150}},
                                         ShapeCase{Parabola{10}}, ShapeCase{Cylinder{30}},
                                         ShapeCase{Exponential{.1, 1}}, ShapeCase{Trapezoid{1, 0.5}},
                                         ShapeCase{RoundedFlat{1, 10}}, ShapeCase{Taylor{{2, 3}, 10.0, 2.0, {}}},
                                         ShapeCase{Profile{{-3, -1, 0, 2}, {0.3, 0, 0, 0.5}, 0, ""}}),
                         [](const auto& info) {
                           return std::string(shape_name(info.param.shape)) + std::to_string(info.index);
                         });

TEST(PatchLaws, AnUpdateSolvesAnElementsOwnLaws) {
  // Without relaxation an update closes the element's gap and takes back its slip.
  const LayerModel& model = endless(0.3);
  const Patch patch{-1, 1, 4};
  const PatchCompliance c = patch_compliance(model, patch);
  const PatchLaws laws = patch_laws(c, 1);
  Eigen::Vector4d n(0.1, 0.2, 0.15, 0.05), t(0.01, -0.02, 0.03, 0.04);
  const double inside = 0.03, followed = 0.07;  // mm: depth less height, u_x of a stick
  n[2] = laws.n_per_uy[2] * inside + laws.A.row(2).dot(n) + laws.B.row(2).dot(t);
  EXPECT_NEAR(c.uy_by_n.row(rows_beyond + 2).dot(n) + c.uy_by_t.row(rows_beyond + 2).dot(t), -inside, 1e-15);
  t[2] = laws.t_per_ux[2] * followed + laws.D.row(2).dot(n) + laws.E.row(2).dot(t);
  EXPECT_NEAR(c.ux_by_n.row(rows_beyond + 2).dot(n) + c.ux_by_t.row(rows_beyond + 2).dot(t), followed, 1e-15);
}

TEST(PatchCompliance, IsReciprocalAndRowsBeyondFollowThePattern) {
  const LayerModel& model = endless(0.45);
  const PatchCompliance c = patch_compliance(model, {-1, 2, 8});
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 8; ++j) {
      EXPECT_EQ(c.uy_by_n(i + rows_beyond, j), c.uy_by_n(j + rows_beyond, i));
      EXPECT_EQ(c.ux_by_t(i + rows_beyond, j), c.ux_by_t(j + rows_beyond, i));
      EXPECT_NEAR(c.uy_by_t(i + rows_beyond, j), -c.ux_by_n(j + rows_beyond, i), 1e-16);  // n presses, u_y is up
    }
  // Two places beyond the right end see the last element as element 0 sees element 2 from the left.
  EXPECT_EQ(c.uy_by_n(rows_beyond + 8 + 1, 7), c.uy_by_n(rows_beyond + 2, 0));
  EXPECT_EQ(c.ux_by_n(rows_beyond + 8 + 1, 7), c.ux_by_n(rows_beyond + 2, 0));
  EXPECT_EQ(c.ux_by_n(rows_beyond - 2, 0), c.ux_by_n(rows_beyond, 2));
}

TEST(PatchSolver, PressedRubberBulgesOutwards) {
  // Signs: a parabola drags the rubber to +x with Q > 0; the base is compressed below it.
  const LayerModel& model = endless(0.45);
  const ContactSolution solution =
      PatchSolver(model).solve(scene_on(model, Parabola{10}, 0, 0.5, by_depth({0.15}, {0.05, 0.5})));
  const ContactStep& pressed = solution.steps[0];
  EXPECT_NEAR(pressed.Q, 0, 1e-3 * pressed.P);
  EXPECT_LT(pressed.sigma_y[10], -0.1);
  EXPECT_GT(solution.steps[1].Q, 0);
  EXPECT_NEAR(*solution.steps[2].slip_index, 1, 1e-12);
  EXPECT_TRUE(solution.sliding);
  EXPECT_EQ(solution.surface_x.size(), 12);
  EXPECT_EQ(pressed.status.size(), 12u);
}

TEST(PatchSolver, TactelsCarryTheForce) {
  // Tactels side by side: their stresses times their widths are the force on the base. Farther than 13 h nothing of it
  // is left.
  const Sensor sensor{.length = 40, .tactels = 80, .tactel_width = 0.5};
  const LayerModel model = endless_layer(sensor);
  const ContactSolution solution =
      PatchSolver(model).solve(scene_on(model, Parabola{10}, 0, 0.5, by_depth({0.15}, {0.05})));
  const ContactStep& step = solution.steps.back();
  EXPECT_NEAR(step.sigma_y.sum() * 0.5, -step.P, 1e-4 * step.P);
  EXPECT_NEAR(step.tau_xy.sum() * 0.5, step.Q, 1e-4 * step.P);
}

TEST(PatchSolver, StopsWhereItSlides) {
  const LayerModel& model = endless(0.45);
  const Load load{.tangential_step = 0.02};
  const ContactSolution solution = PatchSolver(model).solve(scene_on(model, Parabola{10}, 0, 0.3, load));
  EXPECT_TRUE(solution.sliding);
  EXPECT_LT(solution.steps.size(), 50u);
  for (std::size_t k = 1; k + 1 < solution.steps.size(); ++k) EXPECT_LT(*solution.steps[k].slip_index, 1 - 1e-12) << k;
  EXPECT_NEAR(*solution.steps.back().slip_index, 1, 1e-12);
}

TEST(PatchSolver, AHeldContactDoesNotCreep) {
  const LayerModel& model = endless(0.45);
  const ContactSolution solution =
      PatchSolver(model).solve(scene_on(model, Parabola{10}, 0, 0.3, by_depth({0.15}, {0.03, 0.03, 0.03})));
  const ContactStep &first = solution.steps[1], &last = solution.steps[3];
  EXPECT_EQ(first.normal_force, last.normal_force);
  EXPECT_EQ(first.tangential_force, last.tangential_force);
  EXPECT_EQ(last.iterations, 0);
  EXPECT_TRUE(last.converged);
}

TEST(PatchSolver, ForcesAreThoseAskedFor) {
  const LayerModel& model = endless(0.45);
  Load load = by_force_load({0.2, 0.7}, {});
  load.angle = 10;
  const PatchSolver solver(model, {.tolerance = 1e-6});
  for (const Shape& shape : {Shape(Parabola{10}), Shape(Flat{2.0}), Shape(Wedge{150})}) {
    const ContactSolution solution = solver.solve(scene_on(model, shape, 1, 0.5, load));
    for (int k = 0; k < 2; ++k) {
      const ContactStep& step = solution.steps[k];
      const double P = load.normal_force[k];
      EXPECT_TRUE(step.converged) << shape_name(shape);
      EXPECT_NEAR(step.P, P, 1e-5 * P);
      EXPECT_NEAR(step.Q, P * std::tan(10 * std::numbers::pi / 180), 1e-5 * P);
    }
  }
}

TEST(PatchSolver, ALiftedIndenterLeavesTheRubberAlone) {
  const LayerModel& model = endless(0.45);
  const ContactSolution solution =
      PatchSolver(model).solve(scene_on(model, Parabola{10}, 0, 0.3, by_depth({0.15, 0}, {0.1})));
  for (const std::size_t k : {1, 2}) {
    EXPECT_EQ(solution.steps[k].P, 0);
    EXPECT_FALSE(solution.steps[k].slip_index);
    EXPECT_TRUE(solution.steps[k].converged);
  }
  EXPECT_FALSE(solution.sliding);
}

TEST(PatchSolver, RefusesAnotherSensor) {
  Scene scene = scene_on(endless(0.45), Parabola{10}, 0, 0.3, by_depth({0.1}, {}));
  scene.sensor.young = 7;  // of no matter
  scene.sensor.columns = 81;
  const PatchSolver solver(endless(0.45));
  const ContactSolution solution = solver.solve(scene);
  EXPECT_EQ(solution.steps[0].base_force_y.sum(), -solution.steps[0].P);
  scene.sensor.poisson = 0.3;
  EXPECT_THROW(solver.solve(scene), std::invalid_argument);
  scene.sensor.poisson = 0.45;
  scene.sensor.tactels = 20;
  EXPECT_THROW(solver.solve(scene), std::invalid_argument);
}

TEST(PatchSolver, ElementsTouchedWithinAnIncrementStickFromThere) {
  // Judge: 400 increments, where the estimate does not matter. With few, tractions of the pressing are off by what the
  // rubber moved between the increment's start and the touch.
  for (const double nu : {0.3, 0.49})
    for (const Shape& shape : {Shape(Parabola{10}), Shape(Wedge{150}), Shape(RoundedFlat{1, 10})}) {
      SCOPED_TRACE(testing::Message() << "nu " << nu << " " << shape_name(shape));
      const LayerModel& model = endless(nu);
      const Scene scene = scene_on(model, shape, 0, 0.5, by_depth({0.15}, {}));
      const Patch patch = find_patch(scene, model.table, 24).patch;
      const auto tractions = [&](int increments, bool entries) {
        const PatchOptions options{
            .elements = 24, .tolerance = 1e-9, .pressing_increments = increments, .entries = entries};
        return PatchSolver(model, options).solve_on(patch, scene).steps[0].tangential_force;
      };
      const Eigen::VectorXd truth = tractions(400, false);
      for (const int increments : {4, 8}) {
        const double with = (tractions(increments, true) - truth).lpNorm<1>();
        const double without = (tractions(increments, false) - truth).lpNorm<1>();
        EXPECT_LT(with, (increments == 4 ? 1 : 0.8) * without) << increments << " of " << truth.lpNorm<1>();
      }
    }
}

TEST(PatchSolver, AnglesOfLittleFrictionAreReached) {
  // A trial that slides as a whole tells nothing about the way back: with mu below 0.1 the first one usually slides.
  const LayerModel& model = endless(0.45);
  for (const Shape& shape : {Shape(Flat{2}), Shape(Wedge{150}), Shape(Parabola{10}), Shape(Exponential{0.1, 1})})
    for (const double mu : {0.01, 0.02, 0.05, 0.1})
      for (const double share : {-0.9, 0.3, 0.6, 0.8}) {
        SCOPED_TRACE(testing::Message() << shape_name(shape) << " mu " << mu << " share " << share);
        Load load = by_force_load({0.2}, {});
        load.angle = std::atan(share * mu) * 180 / std::numbers::pi;
        load.indentation_steps = 2;
        const ContactSolution solution = PatchSolver(model).solve(scene_on(model, shape, 0.3, mu, load));
        const ContactStep& last = solution.steps.back();
        EXPECT_TRUE(last.converged);
        EXPECT_NEAR(last.P, 0.2, 2e-4);
        EXPECT_NEAR(last.Q, share * mu * 0.2, 2.2e-4);
      }
}

TEST(PatchExact, SolvesWhatSweepsCannot) {
  // Too few sweeps; and the increments of the sweeps, so that a solved scene has the same answer.
  const LayerModel& model = endless(0.3);
  Load load = by_depth({0.1, 0.2}, {0.05, 0.1});
  load.indentation_steps = 3;
  const Scene scene = scene_on(model, Parabola{10}, 0, 0.5, load);
  const Patch patch = find_patch(scene, model.table, 12).patch;
  EXPECT_FALSE(PatchSolver(model, {.most_sweeps = 3}).solve_on(patch, scene).steps.back().converged);
  const ContactSolution swept =
      PatchSolver(model, {.tolerance = 1e-12, .accept = 1e-8, .pressing_increments = 5, .entries = false})
          .solve_on(patch, scene);
  const ContactSolution exact = solve_patch_exactly(model, patch, scene, 5);
  ASSERT_EQ(exact.steps.size(), 8u);
  ASSERT_EQ(swept.steps.size(), 8u);
  for (std::size_t k = 0; k < 8; ++k) {
    EXPECT_TRUE(exact.steps[k].converged);
    EXPECT_EQ(exact.steps[k].indentation, swept.steps[k].indentation);
    EXPECT_LT(difference(swept.steps[k], exact.steps[k]), 1e-9) << k;
  }
}

TEST(PatchSolver, APatchThatIsTooSmallGrows) {
  const Patch patch{-1, 1, 8};
  const PatchLimits open{{-10, 10}, {-bonded, bonded}};
  const Patch right = grown(patch, 0, 2, open);
  EXPECT_EQ(right.left, -1);
  EXPECT_NEAR(right.right, 1 + 2.5 * 0.25, 1e-15);
  // Pressed hard on a patch half as wide as the contact: penetrated beyond both ends, so it is not solved there.
  const LayerModel& model = endless(0.45);
  const Scene scene = scene_on(model, Parabola{10}, 0, 0.3, by_depth({0.15}, {}));
  const PatchSolver solver(model);
  const ContactSolution small = solver.solve_on({-0.5, 0.5, 12}, scene);
  EXPECT_FALSE(small.steps[0].converged);
  EXPECT_GT(small.steps[0].residual.penetration, 0.1);
  EXPECT_TRUE(solver.solve(scene).steps[0].converged);
}

// Half-plane: Hertz, and Cattaneo and Mindlin (K. L. Johnson, Contact Mechanics, 1985, (4.43) to (4.46), (7.28)).
struct Hertz {
  static constexpr double a = 0.5, radius = 50, nu = 0.5 - 1e-9;  // mm; incompressible: no coupling
  static constexpr double modulus = 2 / (1 - nu * nu);            // MPa, E = 2
  static constexpr double P = std::numbers::pi * modulus * a * a / (4 * radius);
  static constexpr double peak = 2 * P / (std::numbers::pi * a);
};

double hertz_error(int elements) {
  const LayerModel& model = half_plane(Hertz::nu);
  const Patch patch{-0.6, 0.6, elements};
  const PatchSolver solver(model, {.elements = elements, .tolerance = 1e-7, .pressing_increments = 1});
  const ContactStep step =
      solver.solve_on(patch, scene_on(model, Parabola{Hertz::radius}, 0, 0, by_force_load({Hertz::P}, {}))).steps[0];
  EXPECT_TRUE(step.converged);
  double error = 0;
  for (int i = 0; i < elements; ++i) {
    const double x = patch.place(i), p = step.normal_force[i] / patch.width();
    if (std::abs(x) < 0.8 * Hertz::a)
      error = std::max(error, std::abs(p - Hertz::peak * std::sqrt(1 - x * x / (Hertz::a * Hertz::a))));
  }
  return error / Hertz::peak;
}

TEST(PatchClosedForms, Hertz) {
  const double coarse = hertz_error(12), fine = hertz_error(96);
  EXPECT_LT(coarse, 0.05);
  EXPECT_LT(fine, 0.005);
}

TEST(PatchClosedForms, CattaneoMindlinStickZone) {
  // Stick within c = a sqrt(1 - Q / (mu P)): known to an element.
  constexpr int elements = 96;
  const LayerModel& model = half_plane(Hertz::nu);
  const Patch patch{-0.6, 0.6, elements};
  const double mu = 0.2;
  const PatchSolver solver(model, {.elements = elements, .tolerance = 1e-7, .pressing_increments = 1});
  for (const double ratio : {0.25, 0.5, 0.75}) {
    const Scene scene = scene_on(model, Parabola{Hertz::radius}, 0, mu, by_force_load({Hertz::P}, {}));
    // The tangential position that gives this Q, by bisection.
    double low = 0, high = 0.05;
    ContactStep step;
    for (int pass = 0; pass < 30; ++pass) {
      Scene dragged = scene;
      dragged.load.tangential = {(low + high) / 2};
      step = solver.solve_on(patch, dragged).steps.back();
      (*step.slip_index < ratio ? low : high) = (low + high) / 2;
    }
    EXPECT_NEAR(*step.slip_index, ratio, 0.02);
    double stick = 0;
    for (const GapStatus status : step.status) stick += status == GapStatus::stick ? patch.width() / 2 : 0;
    EXPECT_NEAR(stick, Hertz::a * std::sqrt(1 - ratio), 1.5 * patch.width()) << ratio;
  }
}

}  // namespace tactel::fem::patch_solver_test
