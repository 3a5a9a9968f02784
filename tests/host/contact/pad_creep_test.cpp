// SPDX-License-Identifier: Apache-2.0

// Paths on rubber that creeps: the kernel beside its twin and an independent program, and the bits of scenes alone.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_markers.h"
#include "fem/pad/pad_mix.h"
#include "host/contact/pads/pad_contact.h"
#include "tests/host/contact/pad_launch.h"
#include "tests/host/contact/stepped.h"

namespace tactel::host::pad_creep_test {

/// Scenes whose steps take 0 s to 10 s each, of rubber with so many terms.
std::vector<fem::PadScene> mix(const fem::PadSensor& sensor, std::size_t count, std::size_t terms) {
  const std::vector<std::array<double, 2>> all{{0.15, 0.3}, {0.1, 3}, {0.2, 0.02}, {0.05, 50}};
  fem::PadMix draw(5, &sensor);
  std::vector<fem::PadScene> scenes(count);
  for (std::size_t i = 0; i < count; ++i) {
    fem::PadScene& scene = scenes[i] = draw();
    scene.sensor.relaxation.assign(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(terms));
    double time = 0;
    for (std::size_t k = 0; k < fem::pad_targets(scene.load).size(); ++k)
      scene.load.times.push_back(time += std::array{0.0, 0.01, 0.2, 1.0, 10.0}[(i + k) % 5]);
    if (!fem::has_free_sides(sensor))
      scene.markers = Markers{.counts = {3, 2}, .pitch = {0.7, 0.9}, .depth = 0.3 * scene.sensor.thickness};
    scene.validate();
  }
  return scenes;
}

/// Markers are sums over points of cells, which miss 1 % (tests/host/sets/pad_set_test.cpp).
template <class Real>
void expect_twin(const std::vector<fem::PadScene>& scenes, double tolerance, double close) {
  const auto batch = ran<Real>(scenes, tolerance);
  const fem::PadLayer layer = fem::pad_layer(scenes.front().sensor.poisson);
  const fem::PadSolver twin(layer, {.cells = 8, .tolerance = std::min(1e-7, tolerance)});
  double softest = 1;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::PadSolution a = batch.solution(i);
    fem::PadSolution b = twin.solve_on(batch.cells(i), batch.scene(i));
    fem::see_markers(batch.scene(i), b);
    for (std::size_t k = 0; k < b.steps.size(); ++k) {
      const fem::PadStep &p = a.steps[k], &q = b.steps[k];
      EXPECT_TRUE(p.converged) << i << " " << k << " " << p.residual.largest();
      EXPECT_NEAR(p.P, q.P, close * q.P) << i << " " << k;
      EXPECT_NEAR(p.indentation, q.indentation, close * q.indentation) << i << " " << k;
      EXPECT_LE((p.Q - q.Q).norm(), close * q.P) << i << " " << k;
      EXPECT_NEAR(p.M, q.M, 2 * close * q.P) << i << " " << k;
      EXPECT_NEAR(p.slip_index.value_or(0), q.slip_index.value_or(0), 1e-3 + 10 * close) << i << " " << k;
      EXPECT_NEAR(p.slip_distance, q.slip_distance, 10 * close) << i << " " << k;
      EXPECT_LE((p.straining - q.straining).norm(), 10 * close * q.straining.norm()) << i << " " << k;
      EXPECT_LE((p.stress - q.stress).cwiseAbs().maxCoeff(), (1e-4 + 10 * close) * q.stress.cwiseAbs().maxCoeff());
      softest = std::max(softest, q.straining.col(0).sum() / q.P);
      if (!q.markers.size()) continue;
      EXPECT_LE((p.markers - q.markers).cwiseAbs().maxCoeff(), 1.5e-2 * q.markers.cwiseAbs().maxCoeff()) << i << k;
    }
  }
  EXPECT_GT(softest, 1.1);  // else nothing was tried
}

TEST(PadCreep, AgreesWithItsTwin) { expect_twin<double>(mix(rubber, 12, 2), 1e-10, 1e-7); }
TEST(PadCreep, AgreesWithItsTwinOfOneTermAndFour) {
  for (const std::size_t terms : {1u, 4u}) expect_twin<double>(mix(rubber, 6, terms), 1e-10, 1e-7);
}
TEST(PadCreep, AgreesWithItsTwinInSinglePrecision) { expect_twin<float>(mix(rubber, 40, 2), 1e-3, 2e-3); }
TEST(PadCreep, AgreesWithItsTwinWhereFrictionDiffers) {
  std::vector<fem::PadScene> scenes = mix(rubber, 8, 2);
  for (fem::PadScene& scene : scenes) scene.set_friction({{{0.7, 0.2, 0.5}, {0.1, 0.6, 0.0}, {0.4, 0.3, 0.9}}, 0.7});
  expect_twin<double>(scenes, 1e-10, 1e-7);
}
TEST(PadCreep, AgreesWithItsTwinWhereSidesAreFree) {
  fem::PadSensor block = rubber;
  block.length = 8, block.width = 8;
  expect_twin<double>(mix(block, 3, 1), 1e-9, 1e-6);
}

// Scenes have the bits that they have alone; so have elastic ones beside rubber that creeps.
TEST(PadCreep, ScenesHaveTheBitsThatTheyHaveAlone) {
  std::vector<fem::PadScene> scenes = mix(rubber, 37, 2);
  for (std::size_t i = 0; i < scenes.size(); i += 3) scenes[i].sensor.relaxation.clear(), scenes[i].load.times.clear();
  for (std::size_t i = 1; i < scenes.size(); i += 6) scenes[i].sensor.relaxation.resize(1);
  const auto batch = ran<float>(scenes, 1e-3);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const auto alone = ran<float>({&scenes[i], 1}, 1e-3);
    const fem::PadSolution a = batch.solution(i), b = alone.solution(0);
    for (std::size_t k = 0; k < a.steps.size(); ++k) {
      EXPECT_EQ(a.steps[k].normal_force, b.steps[k].normal_force) << i << " " << k;
      EXPECT_EQ(a.steps[k].tangential_force, b.steps[k].tangential_force) << i << " " << k;
      EXPECT_EQ(a.steps[k].straining, b.steps[k].straining) << i << " " << k;
      EXPECT_EQ(a.steps[k].stress, b.steps[k].stress) << i << " " << k;
      EXPECT_EQ(a.steps[k].markers, b.steps[k].markers) << i << " " << k;
      EXPECT_EQ(a.steps[k].slip_index, b.steps[k].slip_index) << i << " " << k;
    }
  }
}

// The path of tests/fem/pad/pad_creep_test.cpp by an independent program.
TEST(PadCreep, WalksThePathOfAnIndependentProgram) {
  fem::PadScene scene;
  scene.sensor = {.thickness = 2, .young = 1, .poisson = 0.45, .relaxation = {{0.15, 0.3}, {0.10, 3.0}}};
  scene.indenter.shape = fem::Sphere{8}, scene.friction = 0.5;
  scene.load = {.indentation = {0.25}, .indentation_steps = 2, .times = {.1, .2, .3, .4, 1.4, 11.4, 11.5}};
  scene.load.drags = {{.05, .02, .01}, {.1, .04, .03}, {.1, .04, .03}, {.1, .04, .03}, {.1, .1, .05}};
  const fem::PadOptions options{
      .cells = 16, .tolerance = 1e-10, .accept = 1e-7, .pressing_increments = 2, .limit_increments = 0};
  const fem::PadCells cells{.n = 16, .hx = 0.2, .hy = 0.2};
  auto batch = PadContact<double>(executor(), options).prepare(std::span(&scene, 1), std::span(&cells, 1));
  batch.run();
  const fem::PadSolution path = batch.solution(0);
  const std::array<std::array<double, 4>, 7> known{{{.40191226, 0, 0, 0},
                                                    {1.51451775, 0, 0, 0},
                                                    {1.45605529, .20475504, .07974201, .33105},
                                                    {1.41110404, .36077421, .17741192, .62833},
                                                    {1.27601411, .30979240, .15168067, .59629},
                                                    {1.17474593, .28383748, .13892667, .59341},
                                                    {1.17304070, .24750954, .19977479, .78311}}};
  for (std::size_t k = 0; k < known.size(); ++k) {
    EXPECT_NEAR(path.steps[k].P, known[k][0], 2e-8) << k;
    EXPECT_NEAR(path.steps[k].Q[0], known[k][1], 2e-8) << k;
    EXPECT_NEAR(path.steps[k].M, known[k][2], 2e-8) << k;
    EXPECT_NEAR(path.steps[k].slip_index.value_or(0), known[k][3], 1e-3) << k;  // four rounds leave so much
  }
}

// In no time it is elastic, in all time as soft as it ends.
TEST(PadCreep, IsElasticAtBothEndsOfTime) {
  fem::PadScene scene;
  scene.sensor = {.thickness = 2, .young = 1, .poisson = 0.45};
  scene.indenter.shape = fem::Sphere{8}, scene.load = {.indentation = {0.2}};
  std::vector<fem::PadScene> scenes(4, scene);
  for (std::size_t i = 1; i < 4; ++i)
    scenes[i].sensor.relaxation = {{0.15, 0.3}, {0.1, 3}}, scenes[i].load.times = {std::array{0.0, 0.0, 1e-9, 1e9}[i]};
  const auto batch = ran<double>(scenes, 1e-9);
  const double P = batch.solution(0).steps[0].P;
  for (std::size_t i = 1; i < 4; ++i) EXPECT_NEAR(batch.solution(i).steps[0].P, (i == 3 ? 0.75 : 1) * P, 1e-7 * P) << i;
}

}  // namespace tactel::host::pad_creep_test
