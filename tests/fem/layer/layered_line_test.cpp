// SPDX-License-Identifier: Apache-2.0

// Lines on layers upon layers. Expected numbers are of layered_line_values.py (200 digits), of closed forms, and of
// finite elements with a modulus for each row.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <tuple>
#include <vector>

#include "fem/gap/contact_laws.h"
#include "fem/gap/gap_condensed.h"
#include "fem/gap/stress_field.h"
#include "fem/layer/element_compliance.h"
#include "fem/layer/long_layer.h"
#include "fem/layer/patch_reference.h"
#include "fem/layer/patch_solver.h"
#include "fem/layer/sensor_family.h"
#include "fem/numbers/cache_directory.h"
#include "fem/numbers/value_error.h"

namespace tactel::fem::layered_line_test {

using Layers = std::vector<RubberLayer>;

const Layers cover{{1.3875, 1, 0.48}, {0.1125, 10, 0.48}}, glue{{0.0375, 0.1, 0.48}, {1.4625, 1, 0.48}},
    skin_on_foam{{1.2, 0.2, 0.3}, {0.3, 1, 0.48}};

Sensor sensor_of(Layers layers, double length = 20) {
  Sensor sensor{.length = length};
  sensor.layers = std::move(layers);
  return with_layers(sensor);
}

std::string refused(const Sensor& sensor) {
  try {
    validate(sensor);
  } catch (const ValueError& error) {
    return error.key + ": " + error.allowed;
  }
  return "";
}

/// The kernels at x of layers over the sum of all.
LayerKernelValues kernels_at(const Layers& layers, double x) {
  double farthest = layers.back().thickness;
  while (farthest < x) farthest *= 2;
  return LayerKernels(layers, farthest).at(x);
}

TEST(LayeredLine, KernelsAreThoseOfManyDigits) {
  const Layers stiff{{0.925, 0.1, 0.48}, {0.075, 1, 0.48}}, three{{0.05, 0.1, 0.49}, {0.5, 2, 0}, {0.45, 1, 0.4999}};
  const struct {
    Layers layers;
    double x;
    double yy, xx, xy, sigma_by_y, tau_by_x, tau_by_y, sigma_by_x;
  } cases[] = {{stiff, 0.05, 8.92395697949, 7.51578866214, 0.57937158164, 0.866639104649, 0.0763366895529,
                -0.0517628863887, -0.0227337239638},
               {stiff, 0.5, -0.107547362666, 5.255578123, -0.313053078557, 0.471199522053, 0.145628544405,
                -0.316528484356, -0.144409777185},
               {stiff, 2.0, -0.288028845458, 2.51815129688, -0.648765457194, -0.00826744895094, 0.111504743811,
                -0.0299610975947, -0.0433106972157},
               {three, 0.05, 0.878478608731, 1.80298121281, -0.021480751421, 0.820647465171, 0.147575903824,
                -0.0129428798952, -0.0536105808926},
               {three, 0.5, 0.0275294757052, 0.771241397418, -0.126250612127, 0.435353728727, 0.181972472936,
                -0.075988055071, -0.318443322454},
               {three, 2.0, -0.0123497782971, 0.243111288272, -0.0543922926923, 0.00837182454914, 0.107140407791,
                -0.0258275489968, -0.049195925851}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.x);
    const LayerKernelValues k = kernels_at(c.layers, c.x);
    const double nu = c.layers.back().poisson, log = std::log(c.x), jump = (1 - 2 * nu) * std::acos(0.0);
    EXPECT_NEAR(layer_cy(nu) * (k.smooth.yy - log), c.yy, 1e-8);
    EXPECT_NEAR(layer_cy(nu) * (k.smooth.xx - log), c.xx, 1e-8);
    EXPECT_NEAR(layer_cx(nu) * (jump + k.smooth.xy), c.xy, 1e-8);
    EXPECT_NEAR(k.base.sigma_by_y, c.sigma_by_y, 1e-8);
    EXPECT_NEAR(k.base.tau_by_x, c.tau_by_x, 1e-8);
    EXPECT_NEAR(k.base.tau_by_y, c.tau_by_y, 1e-8);
    EXPECT_NEAR(k.base.sigma_by_x, c.sigma_by_x, 1e-8);
  }
}

TEST(LayeredLine, EqualLayersHaveTheKernelsOfOne) {
  for (const double nu : {0.0, 0.3, 0.4999, 0.5}) {
    const Layers three{{0.29, 1, nu}, {0.7, 1, nu}, {0.01, 1, nu}};
    const LayerKernels one(nu);
    for (const double x : {0.0, 0.003, 0.01, 0.013, 0.1, 0.7, 1.0, 3.0, 9.0, 40.0}) {
      SCOPED_TRACE(testing::Message() << nu << " " << x);
      const LayerKernelValues a = kernels_at(three, x), b = one.at(x);
      for (const auto member : {&SmoothParts::yy, &SmoothParts::xx, &SmoothParts::xy}) {
        EXPECT_NEAR(a.smooth.*member, b.smooth.*member, 1e-10);
        EXPECT_NEAR(a.smooth_integral.*member, b.smooth_integral.*member, 1e-10);
      }
      for (const auto member :
           {&BaseStress::sigma_by_y, &BaseStress::tau_by_x, &BaseStress::tau_by_y, &BaseStress::sigma_by_x}) {
        EXPECT_NEAR(a.base.*member, b.base.*member, 1e-10);
        EXPECT_NEAR(a.base_integral.*member, b.base_integral.*member, 1e-10);
        EXPECT_NEAR(a.base_slope.*member, b.base_slope.*member, 1e-10);
      }
    }
  }
}

// Tables are cubics: 1e-6 of a difference of integrals over their distance (layer_table.h).
TEST(LayeredLine, TablesOfEqualLayersAreThoseOfOne) {
  constexpr double nu = 0.48;
  const LayerTable one(nu), two(Rubber{nu, {{0.8, 1, nu}, {0.2, 1, nu}}});
  for (const double width : {1e-3, 0.05, 0.3, 2.0}) {
    const ElementCompliance a = element_compliance(one, 1, width, 20), b = element_compliance(two, 1, width, 20);
    EXPECT_LE((a.yy - b.yy).cwiseAbs().maxCoeff(), 2e-6) << width;
    EXPECT_LE((a.xx - b.xx).cwiseAbs().maxCoeff(), 2e-6) << width;
    EXPECT_LE((a.xy - b.xy).cwiseAbs().maxCoeff(), 2e-6) << width;
  }
  for (const double x : {0.0, 0.31, -2.2, 9.0}) {
    EXPECT_NEAR(one.base(x).tau_by_x, two.base(x).tau_by_x, 1e-6);
    EXPECT_NEAR(one.base(x).sigma_by_x, two.base(x).sigma_by_x, 1e-6);
    EXPECT_NEAR(one.base_integral(x).tau_by_y, two.base_integral(x).tau_by_y, 1e-6);
  }
}

/// What a wave of tractions along x or y does on the finite element layer, by that of forces on single nodes: u_y by
/// f_y, u_x by f_x, and tau at the base by f_x. Tractions are linear between nodes.
std::array<double, 3> by_wave(const LongLayer& layer, double w) {
  const double theta = w * layer.spacing, force = layer.spacing * (2 + std::cos(theta)) / 3;
  std::array<double, 3> sum{layer.yy[0], layer.xx[0], layer.tau_by_x[0]};
  for (Eigen::Index k = 1; k < layer.yy.size(); ++k) {
    const double both = 2 * std::cos(theta * static_cast<double>(k));
    sum[0] += both * layer.yy[k], sum[1] += both * layer.xx[k], sum[2] += both * layer.tau_by_x[k];
  }
  for (double& of : sum) of *= force;
  return sum;
}

// Finite elements with a modulus for each row know no transforms: a cover of 0.075 H at ten times E leaves of the way
// along a traction, of the shear at the base and of the depth what docs/covers.md says.
TEST(LayeredLine, FiniteElementsHalveTheBaseShearBelowACover) {
  Sensor with = sensor_of(cover, 60);
  with.columns = 961, with.rows = 33;
  Sensor without = with;
  without.layers.clear(), without.young = 1;
  const LongLayer covered = long_layer(with, 640), plain = long_layer(without, 640);
  const std::tuple<double, double, double, double> rows[] = {
      {1, 0.44, 0.45, 0.81}, {2, 0.28, 0.48, 0.92}, {4, 0.18, 0.40, 0.93}};
  for (const auto& [a, along, base, depth] : rows) {
    SCOPED_TRACE(a);
    const double w = a / with.thickness;
    const auto [yy, xx, tau] = by_wave(covered, w);
    const auto [yy1, xx1, tau1] = by_wave(plain, w);
    EXPECT_NEAR(xx / 10 / xx1, along, 0.01);  // E = 1 at the surface of either
    EXPECT_NEAR(tau / tau1, base, 0.01);
    EXPECT_NEAR(yy / 10 / yy1, depth, 0.01);
    const LayerTransforms t = stack_transforms(cover, a).plane;
    const double c = 2 * (1 - 0.48 * 0.48) / w;
    EXPECT_NEAR(yy, c * t.yy, 5e-3 * c * t.yy);
    EXPECT_NEAR(xx, c * t.xx, 5e-3 * c * t.xx);
    EXPECT_NEAR(tau, t.tau_by_x, 5e-3);
  }
}

// Under an even traction layers are squeezed and sheared in series, in both models.
TEST(LayeredLine, EvenTractionsSqueezeLayersInSeries) {
  const Layers layers{{0.6, 0.5, 0.3}, {0.3, 3, 0.2}, {0.6, 1, 0.35}};
  double squeeze = 0, shear = 0;
  for (const auto& [t, E, nu] : layers)
    squeeze += t * (1 + nu) * (1 - 2 * nu) / (E * (1 - nu)), shear += 2 * t * (1 + nu) / E;
  Sensor sensor = sensor_of(layers, 30);
  sensor.columns = 121, sensor.rows = 6;
  const auto [yy, xx, tau] = by_wave(long_layer(sensor, 400), 0);
  EXPECT_NEAR(yy, squeeze, 1e-6 * squeeze);
  EXPECT_NEAR(xx, shear, 1e-6 * shear);
  EXPECT_NEAR(tau, 1, 1e-6);
  const ElementCompliance c = element_compliance(LayerTable(rubber(sensor)), sensor.thickness, 0.1, 400);
  EXPECT_NEAR(0.1 * (c.yy[0] + 2 * c.yy.tail(399).sum()), squeeze, 1e-5 * squeeze);
  EXPECT_NEAR(0.1 * (c.xx[0] + 2 * c.xx.tail(399).sum()), shear, 1e-5 * shear);
}

/// Largest differences of P, Q and stresses at inner tactels over their largest, and of S.
struct Difference {
  double P = 0, Q = 0, S = 0, sigma = 0, tau = 0;
};

Difference difference(const ContactSolution& a, const ContactSolution& b) {
  Difference most;
  double P = 0, Q = 0, sigma = 0, tau = 0;
  for (const ContactStep& step : b.steps) {
    const Eigen::Index inner = step.sigma_y.size() - 2;
    P = std::max(P, step.P), Q = std::max(Q, std::abs(step.Q));
    sigma = std::max(sigma, step.sigma_y.segment(1, inner).cwiseAbs().maxCoeff());
    tau = std::max(tau, step.tau_xy.segment(1, inner).cwiseAbs().maxCoeff());
  }
  for (std::size_t k = 0; k < b.steps.size(); ++k) {
    const ContactStep &x = a.steps[k], &y = b.steps[k];
    EXPECT_TRUE(x.converged) << k << ": " << largest(x.residual);
    EXPECT_TRUE(y.converged) << k << " of the mesh: " << largest(y.residual);
    const Eigen::Index inner = y.sigma_y.size() - 2;
    most.P = std::max(most.P, std::abs(x.P - y.P) / P);
    most.Q = std::max(most.Q, std::abs(x.Q - y.Q) / Q);
    most.S = std::max(most.S, std::abs(x.slip_index.value() - y.slip_index.value()));
    most.sigma = std::max(most.sigma, (x.sigma_y - y.sigma_y).segment(1, inner).cwiseAbs().maxCoeff() / sigma);
    most.tau = std::max(most.tau, (x.tau_xy - y.tau_xy).segment(1, inner).cwiseAbs().maxCoeff() / tau);
  }
  return most;
}

/// The same contact on a mesh with a row of elements for each layer or more. Where moduli differ 1e4-fold, the
/// condensation's rounding leaves up to 1e-10 in the balance of base and surface, by the processor's instructions.
ContactSolution on_mesh(Scene scene) {
  scene.sensor.columns = 401, scene.sensor.rows = 25;
  scene.load.indentation_steps = 20;
  ContactSolution solution =
      GapCondensed(condense_cached(scene.sensor, default_cache_directory()), {.tolerance = 1e-9}).solve(scene);
  solution.steps.erase(solution.steps.begin(), solution.steps.begin() + 19);
  return solution;
}

Scene pressed(const Sensor& sensor, double position) {
  return {"", sensor, {Parabola{20}, position}, 0.6, {.indentation = {0.12}, .tangential = {0.02, 0.06}}};
}

/// Prints what is compared, and expects no more than `most`.
void expect_near(const ContactSolution& answer, const ContactSolution& mesh, const Difference& most) {
  const Difference off = difference(answer, mesh);
  std::printf("P %.1e Q %.1e S %.1e sigma %.1e tau %.1e\n", off.P, off.Q, off.S, off.sigma, off.tau);
  for (const auto member : {&Difference::P, &Difference::Q, &Difference::S, &Difference::sigma, &Difference::tau})
    EXPECT_LE(off.*member, most.*member);
}

// Patch and mesh share nothing but a mesh of the side, and that only near the end, where twelve elements see eight
// modes of it. Elsewhere the mesh, whose elements are 0.03 H wide, is off by some 3e-3.
TEST(LayeredLineSlow, PatchesAreTheWholeMesh) {
  for (const Layers& layers : {cover, glue, skin_on_foam})
    for (const double position : {0.7, 8.0}) {
      SCOPED_TRACE(testing::Message() << layers[1].young << " over " << layers[0].young << " at " << position);
      const Scene scene = pressed(sensor_of(layers), position);
      const LayerModel model = layer_model(scene.sensor);
      const ContactSolution mesh = on_mesh(scene);
      expect_near(PatchReference(model, {.elements = 60}).solve(scene), mesh, {0.005, 0.005, 0.002, 0.005, 0.03});
      expect_near(PatchSolver(model).solve(scene), mesh, {0.02, 0.04, 0.01, 0.02, 0.04});
    }
}

// A layer of 0.002 H is a row of elements for the mesh.
void expect_solved(std::initializer_list<Layers> extremes) {
  for (const Layers& layers : extremes) {
    SCOPED_TRACE(testing::Message() << layers[1].young << " over " << layers[0].young);
    const Sensor sensor = sensor_of(layers);
    const LayerModel model = layer_model(sensor);
    EXPECT_TRUE(model.table.coefficients().allFinite() && model.base.rows().allFinite());
    for (const double width : {0.001, 0.02, 0.3}) {
      const ElementCompliance c = element_compliance(model.table, sensor.thickness, width, 12);
      EXPECT_GT(c.yy[0], 0) << width;
      EXPECT_GT(c.xx[0], 0) << width;
      EXPECT_GE(c.xx[0], c.xx[1]) << width;
    }
    const Scene scene = pressed(sensor, 0.7);
    expect_near(PatchSolver(model).solve(scene), on_mesh(scene), {0.03, 0.04, 0.01, 0.03, 0.08});
  }
}
TEST(LayeredLineSlow, ExtremeLayersAreSolved) {
  expect_solved({{{1.497, 1e-4, 0.4999}, {0.003, 1, 0}}, {{0.003, 1e4, 0}, {1.497, 1, 0.4999}}});
}
TEST(LayeredLineNightly, ExtremeLayersAreSolved) {
  expect_solved({{{1.497, 1e4, 0}, {0.003, 1, 0.4999}},
                 {{0.75, 1e-4, 0.4999}, {0.75, 1, 0.3}},
                 {{0.003, 1e-4, 0.4999}, {1.497, 1, 0}}});
}

TEST(LayeredLine, RefusesWhatTablesDoNotServe) {
  const RubberLayer soft{1, 1, 0.4};
  EXPECT_EQ(refused(sensor_of({soft, {1, 1e4, 0.5}})), "");
  EXPECT_EQ(refused(sensor_of({soft, {0.0021, 1, 0.4}})), "");
  EXPECT_EQ(refused(sensor_of(Layers(9, soft))), "sensor.layers: 8 layers at most");
  EXPECT_EQ(refused(sensor_of({soft, {0.0019, 1, 0.4}})),
            "sensor.layers[1].thickness: 0.002 of the sum of all or more");
  EXPECT_EQ(refused(sensor_of({{1, 1.1e4, 0.4}, soft})),
            "sensor.layers[0].young: 1e4 times that of the softest layer or less");
  Sensor other = sensor_of({soft, soft});
  other.young = 3;
  EXPECT_EQ(refused(other), "sensor.young: left out beside sensor.layers");
  Sensor few = sensor_of(Layers(5, soft));
  few.rows = 5;
  EXPECT_EQ(refused(few), "sensor.rows: more mesh nodes through the thickness than sensor.layers");
  EXPECT_THROW(require_compressible(sensor_of({{1, 1, 0.5}, soft})), ValueError);
  EXPECT_THROW(stress_field(sensor_of({soft, soft}), {}), ValueError);
  EXPECT_THROW(SensorFamily({}, false).require(sensor_of({soft, {0.5, 1, 0.45}})), ValueError);
  // A plate carries shear over the root of E' t 2 (1 + nu) h / E = 26 lengths: farther than tables of long sensors.
  const Layers stiff{{1, 1, 0.4}, {0.5, 1000, 0.4}};
  EXPECT_NO_THROW(endless_layer(sensor_of(stiff, 36)));
  EXPECT_THROW(endless_layer(sensor_of(stiff, 36.1)), ValueError);
  EXPECT_NO_THROW(endless_layer(sensor_of(cover, 36.1)));
}

TEST(LayeredLine, EachHasTablesOfItsOwn) {
  const Sensor one = sensor_of({{0.75, 1, 0.4}, {0.75, 4, 0.4}});
  const LayerModel model = endless_layer(one);
  Sensor harder = one;
  harder.young *= 2;
  for (RubberLayer& layer : harder.layers) layer.young *= 2;
  EXPECT_NO_THROW(require_sensor_of(model, harder));
  EXPECT_EQ(layers_text(harder), layers_text(one));
  for (const Layers& layers : {Layers{{0.75, 1, 0.4}, {0.75, 5, 0.4}}, Layers{{0.7, 1, 0.4}, {0.8, 4, 0.4}},
                               Layers{{0.75, 1, 0.3}, {0.75, 4, 0.4}}, Layers{{1.5, 4, 0.4}}}) {
    EXPECT_THROW(require_sensor_of(model, sensor_of(layers)), std::invalid_argument);
    EXPECT_NE(layers_text(sensor_of(layers)), layers_text(one));
  }
}

}  // namespace tactel::fem::layered_line_test
