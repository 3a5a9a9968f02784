// SPDX-License-Identifier: Apache-2.0

// Layers upon layers. Expected numbers are of an independent program that solves 4 n equations for n layers a
// wavenumber, of 25 digits; of the same equations, written below; and closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "fem/layer/layer_transforms.h"
#include "fem/numbers/value_error.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_solver.h"

namespace tactel::fem::layered_pad_test {

using Layers = std::vector<RubberLayer>;
using Numbers = std::array<double, 9>;

Numbers numbers_of(const StackTransforms& t) {
  const LayerTransforms& p = t.plane;
  return {p.yy, p.xx, p.xy, p.sigma_by_y, p.tau_by_x, p.tau_by_y, p.sigma_by_x, t.across, t.across_base};
}

const Layers skin_on_foam{{0.8, 0.2, 0.3}, {0.2, 1, 0.48}}, cover{{0.925, 1, 0.48}, {0.075, 10, 0.48}},
    three{{0.05, 0.1, 0.49}, {0.875, 1, 0.45}, {0.075, 10, 0.4}};

TEST(LayeredPad, TransformsAreThoseOfAnIndependentProgram) {
  const struct {
    Layers layers;
    double a;
    Numbers expected;
  } cases[] = {{skin_on_foam,
                0.3,
                {0.591767074739, 1.64797912457, -0.0846110181649, 0.976962204537, 0.730173768251, 0.138508383528,
                 0.236489051431, 1.03033763857, 0.913507636965}},
               {skin_on_foam,
                2,
                {3.48270007024, 1.41190139979, 0.494030029064, 0.540049950331, -0.0658681873424, 0.274466123597,
                 0.209627802579, 1.74462033539, 0.141404669397}},
               {cover,
                1,
                {2.16608504578, 3.634607552, -1.28862343533, 0.886800184485, 0.0566411662651, 0.409968463701,
                 0.253666031935, 4.76155196209, 0.442271519697}},
               {cover,
                6,
                {8.32980279946, 1.65642469712, 1.62737521496, 0.0317977735302, -0.00941981804036, 0.0268570769514,
                 0.0113231772595, 1.99690961193, 0.00135067055942}},
               {three,
                1,
                {3.23188549455, 3.5875377225, -1.19328256815, 0.946709350676, 0.0386318679289, 0.242028898275,
                 0.249927090178, 5.51346226719, 0.306884969696}},
               {three,
                6,
                {7.82388341573, 1.64238710491, 1.9348803685, 0.0302504140165, -0.00346864700978, 0.00960858794431,
                 0.0110336661711, 2.0074024894, 0.000424482349797}}};
  for (const auto& c : cases) {
    const Numbers found = numbers_of(stack_transforms(c.layers, c.a));
    for (std::size_t k = 0; k < found.size(); ++k)
      EXPECT_NEAR(found[k], c.expected[k], 1e-11 * std::max(1.0, std::abs(c.expected[k]))) << c.a << " " << k;
  }
}

TEST(LayeredPad, EqualLayersAreOneLayer) {
  for (const double nu : {0.0, 0.3, 0.48, 0.4999, 0.5})
    for (const Layers& layers :
         {Layers{{0.8, 1, nu}, {0.2, 1, nu}}, Layers{{0.3, 5, nu}, {0.6, 5, nu}, {0.006, 5, nu}, {2.094, 5, nu}}})
      for (double a = 1e-6; a < 80; a *= 1.7) {
        const Numbers found = numbers_of(stack_transforms(layers, a)),
                      one = numbers_of({layer_transforms(nu, a), std::tanh(a), 1 / std::cosh(a)});
        for (std::size_t k = 0; k < found.size(); ++k)
          EXPECT_NEAR(found[k], one[k], 1e-14) << nu << " " << a << " " << k;
      }
}

/// Displacement and stress over |w| of a layer of unit shear modulus by two exponentials e^(+-s) and as many times s:
/// rows U, W, sigma, tau of u_x = i U, u_z = W; scaled to 1 at the far end.
Eigen::Matrix4d exponentials(double nu, double s, double thickness) {
  Eigen::Matrix4d m;
  for (int k = 0; k < 2; ++k) {
    const double e = k == 0 ? 1 : -1, scale = k == 0 ? std::exp(s - thickness) : std::exp(-s);
    m.col(2 * k) << e, 1, 2 * e, 2;
    m.col(2 * k + 1) << 3 - 4 * nu + e * s, s, 2 * (1 - 2 * nu + e * s), 2 * (e * 2 * (1 - nu) + s);
    m.middleCols<2>(2 * k) *= scale;
  }
  return m;
}

/// The same answers by 4 n equations: continuity of displacement and stress, a base at rest, the loads.
Numbers by_equations(const Layers& layers, double a) {
  const auto n = static_cast<Eigen::Index>(layers.size());
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(4 * n, 4 * n), loads = Eigen::MatrixXd::Zero(4 * n, 2);
  const auto at = [&](Eigen::Index k, bool top) -> Eigen::Matrix4d {
    const RubberLayer& of = layers[static_cast<std::size_t>(k)];
    Eigen::Matrix4d m = exponentials(of.poisson, top ? a * of.thickness : 0, a * of.thickness);
    m.bottomRows<2>() *= of.young / (2 * (1 + of.poisson));
    return m;
  };
  A.topLeftCorner<2, 4>() = at(0, false).topRows<2>();
  for (Eigen::Index k = 0; k + 1 < n; ++k) {
    A.block<4, 4>(4 * k + 2, 4 * k) = at(k, true);
    A.block<4, 4>(4 * k + 2, 4 * k + 4) = -at(k + 1, false);
  }
  A.bottomRightCorner<2, 4>() = at(n - 1, true).bottomRows<2>();
  loads(4 * n - 2, 0) = loads(4 * n - 1, 1) = 1;
  const Eigen::MatrixXd x = A.fullPivLu().solve(loads);
  const double nu = layers.back().poisson, G = layers.back().young / (2 * (1 + nu));
  const Eigen::Matrix2d surface = at(n - 1, true).topRows<2>() * x.bottomRows<4>() * G,
                        base = at(0, false).bottomRows<2>() * x.topRows<4>();
  Eigen::Vector2d across(0, 1);  // displacement and stress, from the base up
  for (const auto& [thickness, young, poisson] : layers) {
    const double shear = young / (2 * (1 + poisson)), c = std::cosh(a * thickness), s = std::sinh(a * thickness);
    across = (Eigen::Matrix2d() << c, s / shear, s * shear, c).finished() * across;
  }
  return {surface(1, 0) / (1 - nu),
          surface(0, 1) / (1 - nu),
          -2 * surface(0, 0),
          base(0, 0),
          base(1, 1),
          base(1, 0),
          -base(0, 1),
          G * across[0] / across[1],
          1 / across[1]};
}

TEST(LayeredPad, TransformsSolveTheEquationsOfAllLayers) {
  const Layers eight{{0.1, 1, 0.3},  {0.05, 20, 0.4}, {0.3, 0.2, 0.49}, {0.002, 300, 0.2},
                     {0.2, 2, 0.45}, {0.1, 0.1, 0.0}, {0.2, 1, 0.48},   {0.048, 5, 0.5}};
  for (const Layers& layers : {skin_on_foam, cover, three, eight, Layers{{0.998, 1e-4, 0.4999}, {0.002, 1, 0}}})
    for (const double a : {0.2, 0.7, 1.9, 5.0, 14.0}) {
      const Numbers found = numbers_of(stack_transforms(layers, a)), expected = by_equations(layers, a);
      for (std::size_t k = 0; k < found.size(); ++k)
        EXPECT_NEAR(found[k], expected[k], 1e-8 * std::max(1.0, std::abs(expected[k]))) << a << " " << k;
    }
}

// A cover of 0.075 H at ten times E: the numbers of docs/covers.md.
TEST(LayeredPad, StiffCoverHalvesTheBaseShear) {
  const std::tuple<double, double, double, double> rows[] = {
      {1, 0.44, 0.45, 0.81}, {2, 0.28, 0.48, 0.92}, {4, 0.18, 0.4, 0.93}};
  for (const auto& [a, along, base, depth] : rows) {
    const LayerTransforms with = stack_transforms(cover, a).plane, one = layer_transforms(0.48, a);
    EXPECT_NEAR(with.xx / 10 / one.xx, along, 0.005) << a;
    EXPECT_NEAR(with.tau_by_x / one.tau_by_x, base, 0.006) << a;
    EXPECT_NEAR(with.yy / 10 / one.yy, depth, 0.006) << a;
  }
}

TEST(LayeredPad, CellsMoveAsThoseOfAnIndependentProgram) {
  // A cell of 0.25 x 0.25, the place at (0.25, 0.5) from its middle, H = 1, the surface's E = 1.
  const struct {
    Layers layers;
    CellInfluence moves;
    PadBaseStress stress;
  } cases[] = {{skin_on_foam,
                {0.0648982530105, 0.0596297866498, 0.0776501816475, 0.0119864225144, 0.00864062147474, 0.0173087645395},
                (PadBaseStress() << -0.00281959413818, -0.00563977888547, 0.0187882238454, 0.00315938131276,
                 0.00126299067183, -0.00361234710982, 0.00126299067183, 0.00505368307389, -0.00722537)
                    .finished()},
               {cover,
                {0.0478864612456, 0.137725363371, 0.191007486855, 0.0354808627462, 0.00111434289856, 0.00230947147659},
                (PadBaseStress() << -0.0026256398366, -0.00525204062349, 0.0218831340555, 0.00245191914508,
                 0.00134456192348, -0.00624973906232, 0.00134456192348, 0.00446856339626, -0.0125011504964)
                    .finished()}};
  for (const auto& c : cases) {
    const PadLayer layer(c.layers);
    const CellInfluence moves = layer.influence(1, 0.25, 0.25, 0.25, 0.5);
    for (const auto member : {&CellInfluence::zz, &CellInfluence::xx, &CellInfluence::yy, &CellInfluence::xy,
                              &CellInfluence::xz, &CellInfluence::yz})
      EXPECT_NEAR(moves.*member, c.moves.*member, 1e-9);
    EXPECT_LE((layer.base_stress(1, 0.25, 0.25, 0.25, 0.5) - c.stress).cwiseAbs().maxCoeff(), 1e-8);
  }
}

TEST(LayeredPad, EqualLayersHaveTheTablesOfOne) {
  const PadLayer one(0.48), two(Layers{{0.8, 1, 0.48}, {0.2, 1, 0.48}});
  for (const double h : {0.01, 0.05, 0.25, 0.7, 2.0}) {
    const std::vector<CellInfluence> a = one.influences(1, h, h, 6), b = two.influences(1, h, h, 6);
    for (std::size_t k = 0; k < a.size(); ++k)
      for (const auto member : {&CellInfluence::zz, &CellInfluence::xx, &CellInfluence::xy, &CellInfluence::xz})
        EXPECT_NEAR(b[k].*member, a[k].*member, 2e-9 * a[0].zz) << h << " " << k;
    EXPECT_LE((two.base_stress(1, h, h, 0.3, 0.1) - one.base_stress(1, h, h, 0.3, 0.1)).cwiseAbs().maxCoeff(), 1e-8);
  }
}

TEST(LayeredPad, ExtremeLayersAreFinitePositiveAndContinuous) {
  for (const Layers& layers :
       {Layers{{0.998, 1e-4, 0.4999}, {0.002, 1, 0}}, Layers{{0.998, 1e4, 0}, {0.002, 1, 0.4999}},
        Layers{{0.5, 1e-4, 0.4999}, {0.5, 1, 0.3}}, Layers{{0.002, 1e-4, 0.4999}, {0.998, 1, 0}},
        Layers{{0.002, 1e4, 0}, {0.998, 1, 0.4999}}}) {
    const PadLayer layer(layers);
    for (const double h : {0.001, 0.02, 0.1, 0.5}) {
      const std::vector<CellInfluence> all = layer.influences(1, h, h, 8);
      EXPECT_TRUE(std::ranges::all_of(all, [](const CellInfluence& c) {
        return std::isfinite(c.zz + c.xx + c.yy + c.xy + c.xz + c.yz);
      })) << h;
      EXPECT_GT(all[0].zz, 0) << h;
      EXPECT_GT(all[0].xx, 0) << h;
      EXPECT_GE(all[0].xx, all[1].xx) << h;
    }
    // What all displace, the half-space's part and the rest, has no step where tables end.
    const Eigen::Array4d far = layer.displacements(layer.reach() * (1 - 1e-9)),
                         beyond = layer.displacements(layer.reach());
    EXPECT_LE((far - beyond).abs().maxCoeff(), 1e-6 * layer.displacements(0).abs().maxCoeff());
  }
}

PadScene scene_on(const Layers& layers) {
  PadScene scene;
  scene.sensor.layers = layers;
  scene.sensor = with_layers(scene.sensor);
  scene.sensor.tactels = {1, 1};
  scene.friction = 5;
  return scene;
}

// Under a face of many thicknesses each layer is squeezed and sheared alone, its sides held by its neighbours: P over
// the area is the depth over the sum of t (1 + nu) (1 - 2 nu) / (E (1 - nu)), Q the way over that of 2 t (1 + nu) / E.
TEST(LayeredPad, WideFaceSqueezesLayersInSeries) {
  PadScene scene = scene_on({{1, 0.5, 0.3}, {0.4, 3, 0.2}, {0.6, 1, 0.35}});
  scene.indenter.shape = Box{{200, 200}};
  scene.load.indentation = {0.1};
  scene.load.drags = {{0.02, 0, 0}};
  double squeeze = 0, shear = 0;
  for (const auto& [t, E, nu] : scene.sensor.layers)
    squeeze += t * (1 + nu) * (1 - 2 * nu) / (E * (1 - nu)), shear += 2 * t * (1 + nu) / E;
  EXPECT_NEAR(softer_in_shear(scene.sensor), shear / (2 * 2 * 1.35 / 1), 1e-12);
  const PadLayer layer = pad_layer(scene);
  const PadSolution solution = PadSolver(layer, {.cells = 12}).solve(scene);
  const PadStep& step = solution.steps.back();
  const double cell = solution.cells.area();
  constexpr int middle = 6 * 12 + 6;
  EXPECT_NEAR(step.normal_force[middle] / cell, 0.1 / squeeze, 0.01 * 0.1 / squeeze);
  EXPECT_NEAR(step.tangential_force(middle, 0) / cell, 0.02 / shear, 0.01 * 0.02 / shear);
  EXPECT_NEAR(step.stress(0, 0), -0.1 / squeeze, 1e-3 * 0.1 / squeeze);
  EXPECT_NEAR(step.stress(0, 1), 0.02 / shear, 1e-3 * 0.02 / shear);
}

TEST(LayeredPad, NeighboursOfOneRubberAreOneLayer) {
  PadSensor sensor;
  sensor.layers = {{1, 2, 0.4}, {0.5, 2, 0.4}, {0.5, 8, 0.4}};
  sensor = with_layers(sensor);
  EXPECT_EQ(sensor.thickness, 2);
  EXPECT_EQ(sensor.young, 8);
  const Rubber two = rubber(sensor);
  ASSERT_EQ(two.layers.size(), 2u);
  EXPECT_EQ(two.layers[0], (RubberLayer{0.75, 0.25, 0.4}));
  sensor.layers = {{1, 2, 0.4}, {1, 2, 0.4}};
  EXPECT_EQ(rubber(with_layers({.layers = sensor.layers})), Rubber{0.4});
}

TEST(LayeredPad, RefusesWhatTablesDoNotServe) {
  const auto refused = [](const PadSensor& sensor) -> std::string {
    try {
      validate(sensor);
    } catch (const ValueError& error) {
      return error.key + ": " + error.allowed;
    }
    return "";
  };
  const auto with = [&](const Layers& layers) { return refused(with_layers({.layers = layers})); };
  const RubberLayer soft{1, 1, 0.4};
  EXPECT_EQ(with({soft, {1, 1e4, 0.5}}), "");
  EXPECT_EQ(with(Layers(8, soft)), "");
  EXPECT_EQ(with({soft, {0.0021, 1, 0.4}}), "");
  EXPECT_EQ(with(Layers(9, soft)), "sensor.layers: 8 layers at most");
  EXPECT_EQ(with({soft, {0.0019, 1, 0.4}}), "sensor.layers[1].thickness: 0.002 of the sum of all or more");
  EXPECT_EQ(with({{1, 1.1e4, 0.4}, soft}), "sensor.layers[0].young: 1e4 times that of the softest layer or less");
  EXPECT_EQ(with({soft, {-1, 1, 0.4}}).find("sensor.layers[1].thickness: a length"), 0u);
  EXPECT_EQ(with({{1, std::nan(""), 0.4}, soft}).find("sensor.layers[0].young: a Young's"), 0u);
  EXPECT_EQ(with({soft, {1, 1, 0.51}}).find("sensor.layers[1].poisson: a Poisson's"), 0u);
  const std::string beside = ": left out beside sensor.layers";
  EXPECT_EQ(refused(with_layers({.thickness = 3, .layers = {soft, soft}})), "sensor.thickness" + beside);
  EXPECT_EQ(refused(with_layers({.young = 3, .layers = {soft, soft}})), "sensor.young" + beside);
  EXPECT_EQ(refused(with_layers({.poisson = 0.3, .layers = {soft, soft}})), "sensor.poisson" + beside);
  const PadSensor sides{.tactels = {1, 1}, .length = 20, .width = 20, .layers = {soft, soft}};
  EXPECT_EQ(refused(with_layers(sides)),
            "sensor.layers: left out where sides are free; or sensor.sides = "
            "\"held\"");
}

}  // namespace tactel::fem::layered_pad_test
