// SPDX-License-Identifier: Apache-2.0

// Solutions that neither the mesh nor the iteration knows, each with its range of validity. Johnson, Contact Mechanics
// (1985).
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/gap/gap_reference.h"
#include "fem/mesh/block.h"

namespace tactel::fem::closed_forms_test {

constexpr double pi = std::numbers::pi;

// A parabola on a block that is thick and long against the contact: half-width a, `depth` a thick and twice as long
// each way, `per_half_width` columns to a. The half-plane is off by (a / thickness)^2, 0.0025 for 20 a.
struct HalfPlane {
  static constexpr double a = 0.2, radius = 10;  // mm
  HalfPlane(int depth, int per_half_width, double poisson) : spacing(a / per_half_width) {
    sensor.thickness = depth * a;
    sensor.length = 2 * depth * a;
    sensor.columns = 2 * depth * per_half_width + 1;
    sensor.rows = 2 * per_half_width + 9;
    sensor.grading = 2.0 * depth;  // top rows as high as columns are wide, or less
    sensor.poisson = poisson;
    force = pi * sensor.young * a * a / (4 * radius * (1 - poisson * poisson));  // a^2 = 4 P R (1 - nu^2) / (pi E)
    peak = 2 * force / (pi * a);
  }
  /// Hertz, Johnson (4.45).
  double pressure(double x) const { return std::abs(x) < a ? peak * std::sqrt(1 - x * x / (a * a)) : 0; }
  /// Cattaneo and Mindlin, Johnson (7.24) to (7.28): traction at friction mu under Q, the stick zone within c = a
  /// sqrt(1 - Q / (mu P)).
  double shear(double x, double mu, double ratio) const {
    const double c = a * std::sqrt(1 - ratio);
    const double stuck = std::abs(x) < c ? c / a * peak * std::sqrt(1 - x * x / (c * c)) : 0;
    return mu * (pressure(x) - stuck);
  }
  Sensor sensor;
  double spacing, force, peak;  // mm, N/mm, MPa
};

// Largest error of the nodal pressure within 0.8 a, over the peak; beyond, the square root's infinite slope is the
// mesh's affair.
double hertz_error(const HalfPlane& half_plane) {
  const Scene scene{.sensor = half_plane.sensor,
                    .indenter = {.shape = Parabola{HalfPlane::radius}},
                    .friction = 0,
                    .load = {.normal_force = {half_plane.force}}};
  const ContactSolution solution = solve_gap_reference(scene);
  const ContactStep& step = solution.steps.back();
  EXPECT_TRUE(step.converged);
  double error = 0;
  for (Eigen::Index i = 0; i < solution.surface_x.size(); ++i) {
    const double x = solution.surface_x[i];
    if (std::abs(x) > 0.8 * HalfPlane::a) continue;
    error =
        std::max(error, std::abs(step.normal_force[i] / half_plane.spacing - half_plane.pressure(x)) / half_plane.peak);
  }
  const double touching = double((step.normal_force.array() > 0).count()) * half_plane.spacing / 2;
  EXPECT_NEAR(touching, HalfPlane::a, half_plane.spacing);  // the edge is known to a column
  return error;
}

TEST(ClosedForms, HertzLineContact) {
  for (double poisson : {0.3, 0.4999}) {
    SCOPED_TRACE(poisson);
    const double coarse = hertz_error({20, 4, poisson}), fine = hertz_error({20, 8, poisson});
    EXPECT_LT(coarse, 0.05);
    EXPECT_LT(fine, 0.005);  // 8 columns to a
    EXPECT_LT(fine, coarse / 4);
    // What is left on a fine mesh is the half-plane's own error, the square of a / thickness: four times as much at 10
    // a.
    const double shallow = hertz_error({10, 16, poisson}), thick = hertz_error({20, 16, poisson});
    EXPECT_LT(thick, 0.002);
    EXPECT_NEAR(shallow / thick, 4, 1.2);
  }
}

struct PartialSlip {
  double error = 0;  // mean over the contact of the traction's error, over mu times the peak pressure
  double stick = 0;  // half-width of the stick zone, mm
};

// Pressed without friction, then pulled with it. Near nu = 0.5 a half-plane's tangential traction leaves the pressure
// alone.
PartialSlip pull(const HalfPlane& half_plane, double ratio) {
  constexpr double mu = 0.1;
  GapBlock block(make_mesh(half_plane.sensor), stiffness(make_mesh(half_plane.sensor), half_plane.sensor));
  const Eigen::VectorXd x = surface_positions(half_plane.sensor);
  const Eigen::VectorXd height = profile_heights({Parabola{HalfPlane::radius}}, x);
  const double P = half_plane.force;
  const GapPose start = undeformed(block, height);
  const GapAnswer pressed = solve_increment({block, 0, height, {true, false, P, 0}, start}, 100, 1e-9);
  const GapAnswer pulled =
      solve_increment({block, mu, height, {true, true, P, ratio * mu * P}, pressed.pose}, 100, 1e-9);
  EXPECT_TRUE(pressed.converged && pulled.converged);
  PartialSlip found;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double traction = pulled.pose.tangential_force[i] / half_plane.spacing;
    const double error = std::abs(traction - half_plane.shear(x[i], mu, ratio)) / (mu * half_plane.peak);
    if (touches(pulled.pose.trial[i])) found.error += error * half_plane.spacing / (2 * HalfPlane::a);
    if (pulled.pose.trial[i] == Trial::stick) found.stick += half_plane.spacing / 2;
  }
  return found;
}

TEST(ClosedForms, CattaneoMindlinPartialSlip) {
  for (double ratio : {0.3, 0.6, 0.9}) {  // Q / (mu P)
    SCOPED_TRACE(ratio);
    const HalfPlane coarse(10, 4, 0.49), fine(10, 16, 0.49);
    const PartialSlip on_coarse = pull(coarse, ratio), on_fine = pull(fine, ratio);
    const double c = HalfPlane::a * std::sqrt(1 - ratio);
    EXPECT_NEAR(on_coarse.stick, c, coarse.spacing);
    EXPECT_NEAR(on_fine.stick, c, fine.spacing);
    EXPECT_LT(on_fine.error, 0.02);
    // Kinks of infinite slope at c and a: better than first order in the mean, 4^1 = 4 for four times the columns.
    EXPECT_LT(on_fine.error, on_coarse.error / 4);
  }
}

// A thin layer bonded to its base, compressible, presses back like separate columns under lateral constraint: p = M
// (depth - y) / h, M = E (1 - nu) / ((1 + nu) (1 - 2 nu)), Johnson section 5.8. Valid for a >> h and nu well below 0.5;
// the error is of order (h / a)^2.
double constrained_modulus(const Sensor& sensor) {
  const double nu = sensor.poisson;
  return sensor.young * (1 - nu) / ((1 + nu) * (1 - 2 * nu));
}

double thin_layer_error(double thickness, double poisson, double mu) {
  constexpr double radius = 100, depth = 0.02;
  const double a = std::sqrt(2 * radius * depth);  // 2 mm
  const Scene scene{
      .sensor = {.length = 6, .thickness = thickness, .poisson = poisson, .columns = 241, .rows = 9, .grading = 1},
      .indenter = {.shape = Parabola{radius}},
      .friction = mu,
      .load = {.indentation = {depth}}};
  const ContactStep step = solve_gap_reference(scene).steps.back();
  EXPECT_TRUE(step.converged);
  const double expected =
      2.0 / 3 * constrained_modulus(scene.sensor) / thickness * a * a * a / radius;  // integral of p
  return std::abs(step.P / expected - 1);
}

TEST(ClosedForms, ThinBondedLayer) {
  for (double mu : {0.0, 0.5}) {
    for (double poisson : {0.3, 0.4}) {
      SCOPED_TRACE(testing::Message() << "nu " << poisson << " mu " << mu);
      const double thick = thin_layer_error(0.4, poisson, mu), thin = thin_layer_error(0.1, poisson, mu);
      EXPECT_LT(thick, 0.04);      // h / a = 1 / 5
      EXPECT_LT(thin, 0.004);      // h / a = 1 / 20
      EXPECT_LT(thin, thick / 8);  // 16 for a purely quadratic error
    }
  }
}

TEST(ClosedForms, WideFlatOnColumnsThatDoNotSpread) {
  // nu = 0: every column of rubber by itself, p = E depth / h everywhere; end nodes bear half a column. Exact in any
  // mesh.
  const Scene scene{.sensor = {.poisson = 0}, .indenter = {.shape = Flat{}}, .load = {.indentation = {0.15}}};
  const ContactStep step = solve_gap_reference(scene).steps.back();
  const double per_node = 2.0 * 0.15 / 1.5 * 0.5;  // E depth / h, columns 0.5 mm apart
  for (int i = 0; i < 41; ++i) {
    EXPECT_NEAR(step.normal_force[i], per_node * (i == 0 || i == 40 ? 0.5 : 1), 1e-14);
    EXPECT_NEAR(step.tangential_force[i], 0, 1e-14);
  }
  EXPECT_LT((step.sigma_y.array() + 2.0 * 0.15 / 1.5).abs().maxCoeff(), 1e-13);
}

TEST(ClosedForms, WideFlatOnAConstrainedLayer) {
  // Far from the free sides p = M depth / h without friction, and under a flat that sticks the drag adds tau = G X / h.
  // What the sides do fades over a few thicknesses: 10 mm to either side are twenty of them here.
  Scene scene{.sensor = {.thickness = 0.5, .poisson = 0.3},
              .indenter = {.shape = Flat{}},
              .friction = 0,
              .load = {.indentation = {0.02}}};
  const double pressure = constrained_modulus(scene.sensor) * 0.02 / 0.5, width = 0.5;
  const int middle = 20;
  EXPECT_NEAR(solve_gap_reference(scene).steps.back().normal_force[middle], pressure * width, 1e-8 * pressure);
  scene.friction = 5;
  scene.load.tangential = {0.01};
  const ContactStep dragged = solve_gap_reference(scene).steps.back();
  const double shear = 2.0 / (2 * 1.3) * 0.01 / 0.5;  // G X / h
  EXPECT_EQ(dragged.status[middle], GapStatus::stick);
  EXPECT_NEAR(dragged.tangential_force[middle], shear * width, 1e-8 * pressure);
  EXPECT_NEAR(dragged.normal_force[middle], pressure * width, 1e-8 * pressure);
}

}  // namespace tactel::fem::closed_forms_test
