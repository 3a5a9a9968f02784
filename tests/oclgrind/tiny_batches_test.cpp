// SPDX-License-Identifier: Apache-2.0

// Every kernel that computes, on a few items, for oclgrind, which looks at each access to memory (scripts/sanitize
// oclgrind). Answers are checked, too: what the kernels then did is what they do elsewhere. Executors are no statics:
// oclgrind's own are gone before them.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include "fem/gap/gap_reference.h"
#include "fem/layer/patch_solver.h"
#include "fem/pad/pad_step.h"
#include "host/contact/lines/gap_sweep.h"
#include "host/contact/lines/patch_contact.h"
#include "host/contact/pads/pad_contact.h"
#include "host/contact/pads/pad_search.h"
#include "host/contact/pads/pad_step.h"
#include "host/device/opencl.h"
#include "host/networks/forward.h"
#include "host/networks/train_batch.h"
#include "host/networks/train_online.h"
#include "host/sets/transducer_chain.h"
#include "kernels/shared/pad_step_layout.h"
#include "tests/host/contact/contact_cases.h"
#include "tests/host/networks/bounded_model.h"
#include "tests/host/networks/network_cases.h"
#include "tests/host/sets/transducer_cases.h"

namespace {
cl_uint lanes_fp32 = 1;
}

/// oclgrind's device has no vectors of its own; kernels shall run as on a processor that has. The program's symbol
/// comes before the library's.
extern "C" cl_int clGetDeviceInfo(cl_device_id device, cl_device_info what, size_t size, void* value,
                                  size_t* size_out) {
  static const auto library = reinterpret_cast<decltype(&clGetDeviceInfo)>(dlsym(RTLD_NEXT, "clGetDeviceInfo"));
  const cl_int code = library(device, what, size, value, size_out);
  const bool fp64 = what == CL_DEVICE_NATIVE_VECTOR_WIDTH_DOUBLE;
  if (value && (fp64 || what == CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT))
    *static_cast<cl_uint*>(value) = fp64 ? (lanes_fp32 + 1) / 2 : lanes_fp32;
  return code;
}

namespace {

using namespace tactel;
using namespace tactel::host;
using fem::base_force_difference;
using tactel::tests::all_parts;
using tactel::tests::bumps;
using tactel::tests::largest_difference;
using tactel::tests::TransducerCase;

/// By lanes in fp32: a GPU's, and those of AVX-512.
struct TinyBatches : ::testing::TestWithParam<int> {
  Device device = [] {
    lanes_fp32 = static_cast<cl_uint>(GetParam());
    return Device();
  }();
  Executor executor{device, {.threads = 1}};
};

INSTANTIATE_TEST_SUITE_P(Lanes, TinyBatches, ::testing::Values(1, 16));

/// A sensor of few nodes; scenes that touch one node, some, and all of them.
std::vector<fem::Scene> few_scenes(bool by_force, double friction) {
  const fem::Sensor sensor{.length = 6, .columns = 9, .rows = 3, .tactels = 4};
  std::vector<fem::Scene> scenes;
  for (const fem::Shape& shape : {fem::Shape(fem::Parabola{10}), fem::Shape(fem::Wedge{120}), fem::Shape(fem::Flat{})})
    scenes.push_back({"", sensor, {shape, 0.0}, friction, {}});
  for (fem::Scene& scene : scenes) {
    scene.load.indentation_steps = 2;
    scene.load.tangential = {0.05, -0.05};
    if (!by_force) continue;
    scene.load.indentation.clear();
    scene.load.normal_force = {0.2};
  }
  if (by_force && friction > 0) scenes.back().load.tangential.clear(), scenes.back().load.angle = 10.0;
  return scenes;
}

/// Tolerances as in gap_sweep_test: what the sweeps' own tolerance leaves.
template <class Real>
void expect_contacts(Executor& executor, bool by_force, double friction) {
  const auto scenes = few_scenes(by_force, friction);
  const GapSweep<Real> sweep(executor, scenes.front().sensor);
  auto batch = sweep.prepare(scenes);
  batch.run();
  fem::GapReference reference(scenes.front().sensor);
  for (std::size_t i = 0; i < scenes.size(); ++i)
    EXPECT_LE(base_force_difference(batch.solution(i), reference.solve(scenes[i])), sizeof(Real) == 4 ? 1e-3 : 1e-8)
        << i;
}

TEST_P(TinyBatches, GapSweepByDepthFp32) { expect_contacts<float>(executor, false, 0.4); }
TEST_P(TinyBatches, GapSweepByDepthFp64) { expect_contacts<double>(executor, false, 0.4); }
TEST_P(TinyBatches, GapSweepByForceFp32) { expect_contacts<float>(executor, true, 0.4); }
TEST_P(TinyBatches, GapSweepByForceFp64) { expect_contacts<double>(executor, true, 0.4); }
TEST_P(TinyBatches, GapSweepFrictionless) {  // a program of its own
  expect_contacts<float>(executor, false, 0);
  expect_contacts<double>(executor, true, 0);
}

/// Shapes with terms and points of their own, too; at an end of the sensor, too.
std::vector<fem::Scene> few_patches(bool by_force, double friction) {
  auto scenes = few_scenes(by_force, friction);
  for (const fem::Shape& shape : {fem::Shape(fem::Taylor{{1, 3}, 5.0, 0.4}),
                                  fem::Shape(fem::Profile{{-1, -0.2, 0.5, 1.5}, {0.05, 0, 0.01, 0.1}, 0.0, ""}),
                                  fem::Shape(fem::Cylinder{8}), fem::Shape(fem::Exponential{0.1, 1})}) {
    scenes.push_back(scenes.front());
    scenes.back().indenter = {shape, scenes.size() % 2 ? 0.0 : 2.4};
  }
  return scenes;
}

/// `tables`: a LayerModel or a SensorFamily. Tolerance: of P and Q over their sum, as in patch_contact_test and
/// patch_sensors_test.
template <class Real, class Tables>
void expect_patches(Executor& executor, const Tables& tables, std::span<const fem::Scene> scenes, double tolerance,
                    int elements = 8) {
  const double sweeps_to = scenes.front().load.normal_force.empty() ? 1e-3 : sizeof(Real) == 8 ? 1e-11 : 1e-5;
  const PatchContact<Real> contact(
      executor, tables,
      {.elements = elements, .tolerance = sweeps_to, .accept = 2e-2, .most_sweeps = 2000, .most_growths = 0});
  auto batch = contact.prepare(scenes);
  batch.run();
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const auto model = contact.model_of(scenes[i].sensor);
    const fem::PatchSolver twin(
        *model, {.elements = elements, .tolerance = sweeps_to, .accept = 2e-2, .most_sweeps = 2000, .most_growths = 0});
    const fem::ContactStep found = batch.solution(i).steps.back(), expected = twin.solve(scenes[i]).steps.back();
    const double sum = expected.P + std::abs(expected.Q);
    EXPECT_NEAR(found.P, expected.P, tolerance * sum) << i;
    EXPECT_NEAR(found.Q, expected.Q, tolerance * sum) << i;
  }
}

template <class Real>
void expect_patches(Executor& executor, bool by_force, double friction, int elements = 8) {
  const auto scenes = few_patches(by_force, friction);
  const fem::LayerModel model = fem::layer_model(scenes.front().sensor);
  expect_patches<Real>(executor, model, scenes, sizeof(Real) == 4 ? 3e-5 : 1e-9, elements);
}

TEST_P(TinyBatches, PatchContactByDepth) {
  expect_patches<float>(executor, false, 0.4);
  expect_patches<double>(executor, false, 0.4);
}
TEST_P(TinyBatches, PatchContactByForce) {
  expect_patches<float>(executor, true, 0.4);
  expect_patches<double>(executor, true, 0.4);
}
TEST_P(TinyBatches, PatchContactFrictionless) {  // a program of its own
  expect_patches<float>(executor, false, 0);
  expect_patches<double>(executor, true, 0);
}
TEST_P(TinyBatches, PatchContactOfManyElements) {  // arrays and sweeps of their own beyond 12 and beyond 16
  for (const int elements : {12, 16, 24}) expect_patches<float>(executor, false, 0.4, elements);
}

/// A sensor for each scene: tables of the family, and pressing, drag and release as the frames of a history need them.
TEST_P(TinyBatches, PatchContactOnSensors) {
  const fem::SensorFamily family({.poisson_low = 0.3, .poisson_high = 0.499, .longest = 14, .tactels = 4});
  for (const bool by_force : {false, true}) {
    auto scenes = few_patches(by_force, 0.4);
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      fem::Sensor& sensor = scenes[i].sensor;
      sensor.poisson = 0.31 + 0.02 * static_cast<double>(i);
      sensor.thickness = 0.5 + 0.05 * static_cast<double>(i);
      if (!by_force)
        scenes[i].load.moves = {{0.15, 0.02}, {0.1, 0.04}, {0.12, -0.01}}, scenes[i].load.tangential.clear();
    }
    expect_patches<float>(executor, family, scenes, 1e-4);
    expect_patches<double>(executor, family, scenes, 1e-8);
  }
}

/// Tolerances as in forward_test. 35 frames: whole tiles and a ragged end.
template <class Real>
void expect_recall(Executor& executor, const nn::InputScaling& scaling) {
  const nn::Topology topology = nn::Topology::parse("6-5-3-1");
  const std::vector networks{nn::Weights<Real>(nn::initial_weights(topology, 1)),
                             nn::Weights<Real>(nn::initial_weights(topology, 2))};
  const nn::RowMatrix<float> frames = bumps(35, 6, 4).frames;
  const double tolerance = sizeof(Real) == 4 ? 1e-6 : 1e-14;
  Forward<Real> forward(executor, networks, scaling);
  forward.run(DeviceFrames(executor.device(), frames));
  for (std::size_t i = 0; i < networks.size(); ++i) {
    const nn::Recall<double> truth = nn::recall(nn::Weights<double>(networks[i]), scaling, frames);
    EXPECT_LT((forward.result(i).slip_index.template cast<double>() - truth.slip_index).cwiseAbs().maxCoeff(),
              tolerance);
  }
}

TEST_P(TinyBatches, Forward) {
  for (const nn::InputScaling& scaling :
       {nn::InputScaling{nn::ScalingKind::set, 1.3f}, nn::InputScaling{nn::ScalingKind::frame, 1.0f},
        nn::InputScaling{nn::ScalingKind::frame, 1.0f, 3}}) {
    expect_recall<float>(executor, scaling);
    expect_recall<double>(executor, scaling);
  }
}

/// Each frame's bound is that of the twin, whose S and quantiles differ by the tolerance above: within it, but where a
/// class's edge lies between.
TEST_P(TinyBatches, ForwardBound) {
  const nn::Model model = tactel::tests::bounded_model("6-5-3", nn::ScalingKind::frame);
  const nn::Bound* const bound = &*model.bound;
  const nn::RowMatrix<float> frames = bumps(35, 6, 4).frames;
  Forward<float> forward(executor, std::span(&model.weights, 1), model.scaling, std::span(&bound, 1));
  const nn::Recall<float> found = forward.recall(frames);
  const auto truth = tactel::tests::bounds_of(model, nn::recall(model.weights, model.scaling, frames), frames);
  int near = 0;
  for (std::size_t row = 0; row < truth.size(); ++row) {
    near += std::abs(found.bounds[row].upper - truth[row].upper) < 2e-6;
    EXPECT_EQ(found.bounds[row].unlike, truth[row].unlike) << row;
  }
  EXPECT_GE(near, 33);
}

/// On a pad: without and with mirror images, measured, of all kinds of heights.
std::vector<fem::PadScene> few_pads() {
  const fem::HeightMap map{.pitch = 0.4, .heights = Eigen::MatrixXd{{0.2, 0.1, 0.3}, {0.1, 0.0, 0.2}, {0.2, 0.2, 0.4}}};
  std::vector<fem::PadScene> scenes;
  for (const fem::PadShape& shape :
       {fem::PadShape(fem::Sphere{}), fem::PadShape(fem::Box{{1, 2}, 0}), fem::PadShape(fem::Punch{1, 0.5}),
        fem::PadShape(fem::Cone{}), fem::PadShape(fem::LyingCylinder{}), fem::PadShape(map)}) {
    fem::PadScene scene;
    scene.indenter.shape = shape;
    scene.load.drags = {{0.02, 0.01, 0.02}};
    scenes.push_back(scene);
  }
  scenes[2].indenter.tilt = 2;
  return scenes;
}

/// Sides within a cell of the search, P to what its sweeps leave: as in pad_search_test.
template <class Real>
void expect_pad_searches(Executor& executor) {
  auto scenes = few_pads();
  const fem::PadLayer layer(scenes.front().sensor.poisson);
  scenes.back().load = {.indentation = {}, .normal_force = {0.2}};
  const auto found = PadSearch<Real>(executor).find(scenes);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::PadSearch twin = fem::find_pad_contact(scenes[i], layer);
    EXPECT_NEAR(found[i].contact.x.left, twin.contact.x.left, -0.25 * twin.contact.x.left) << i;
    EXPECT_NEAR(found[i].P, twin.P, 5e-3 * twin.P) << i;
  }
}

TEST_P(TinyBatches, PadSearch) {
  expect_pad_searches<float>(executor);
  expect_pad_searches<double>(executor);
}

/// Tables that a group shares, and a lane's own; friction that differs from cell to cell, and markers. Tolerance: what
/// the sweeps leave, as in pad_contact_test.
TEST_P(TinyBatches, PadContact) {
  auto scenes = few_pads();
  scenes.resize(2);
  scenes.front().set_friction({{{0.2, 0.5}}, 1});
  for (fem::PadScene& scene : scenes) scene.markers = Markers{.counts = {2, 1}, .depth = 0.5};
  for (const int vectors : {1, 2}) {
    const PadContact<float> contact(executor, {.cells = 8, .tolerance = 1e-2, .accept = 0.3, .vectors = vectors});
    const fem::PadSolver twin(*contact.layer({scenes.front().sensor.poisson}), {.cells = 8});
    std::vector<fem::PadScene> many(10 * static_cast<std::size_t>(lanes_fp32) * vectors / 16 + 1, scenes.front());
    many.push_back(scenes.back());
    auto batch = contact.prepare(many);
    batch.run();
    for (const std::size_t i : {std::size_t{0}, many.size() - 1}) {
      const fem::PadStep found = batch.solution(i).steps.back(),
                         expected = twin.solve_on(batch.cells(i), batch.scene(i)).steps.back();
      EXPECT_NEAR(found.P, expected.P, 1e-2 * expected.P) << i;
      EXPECT_NEAR(found.Q.norm(), expected.Q.norm(), 2e-2 * expected.P) << i;
      EXPECT_EQ(found.markers.rows(), 2) << i;
    }
  }
}

/// A table of all pairs of each scene's cells, in memory that runs borrow. Tolerance: as above.
TEST_P(TinyBatches, PadContactWithFreeSides) {
  fem::PadScene scene = few_pads().front();
  scene.sensor.length = 8, scene.sensor.width = 7;
  scene.indenter.position = {3, 1};
  scene.set_friction({{{0.2, 0.5}}, 6});
  const PadContact<float> contact(executor, {.cells = 8, .tolerance = 1e-2, .accept = 0.3});
  const fem::PadSolver twin(*contact.layer({scene.sensor.poisson}), {.cells = 8});
  auto batch = contact.prepare({&scene, 1});
  batch.run();
  const fem::PadStep found = batch.solution(0).steps.back(),
                     expected = twin.solve_on(batch.cells(0), batch.scene(0)).steps.back();
  EXPECT_NEAR(found.P, expected.P, 1e-2 * expected.P);
  EXPECT_NEAR(found.Q.norm(), expected.Q.norm(), 2e-2 * expected.P);
  EXPECT_LT((found.stress - expected.stress).cwiseAbs().maxCoeff(), 1e-2 * expected.stress.cwiseAbs().maxCoeff());
}

/// By motion, then by wrench, on the smallest grid, where friction differs from cell to cell; a contact more than a
/// vector has. Tolerance: as above.
TEST_P(TinyBatches, PadStep) {
  const fem::PadSensor pad{.tactels = {3, 1}};
  const fem::PadIndenter ball{.shape = fem::Sphere{.radius = 5}};
  const std::size_t count = static_cast<std::size_t>(lanes_fp32) + 1;
  PadStepper<float> steps(executor, pad, count, std::array{0.4}, {.cells = 4, .cell = 0.6, .tolerance = 1e-2});
  fem::SteppedContact twin(fem::PadLayer(pad.poisson), pad, steps.cells(), 0.4, {});
  const fem::PadSurface surface = fem::pad_surface(steps.cells(), ball, {0, 0}, 0);
  for (std::size_t c = 0; c < count; ++c) steps.set_surface(c, surface);
  twin.set_surface(surface);
  const auto of_all = [&](std::array<double, 4> one) {
    std::vector<double> all;
    for (std::size_t c = 0; c < count; ++c) all.insert(all.end(), one.begin(), one.end());
    return all;
  };
  const auto expect_force = [&](const fem::PadWrench& expected) {
    for (const std::size_t c : {std::size_t{0}, count - 1})
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_NEAR(steps.results()[c * STEP_RESULT_ROWS + k], expected[static_cast<Eigen::Index>(k)],
                    2e-2 * expected[0]);
  };
  steps.move(of_all({0.1, 0, 0, 0})), twin.move(0.1, {0, 0, 0});
  const Eigen::VectorXd mu = Eigen::VectorXd::LinSpaced(16, 0.1, 0.5);
  std::vector<double> map;
  for (std::size_t c = 0; c < count; ++c) map.insert(map.end(), mu.begin(), mu.end());
  steps.set_friction(map), twin.set_friction(mu);
  steps.move(of_all({0.1, 0.02, 0.01, 0.01}));
  const fem::PadWrench force = twin.move(0.1, {0.02, 0.01, 0.01}).force;
  expect_force(force);
  EXPECT_EQ(steps.frames().size(), 9 * count);
  steps.press(of_all({1.1 * force[0], force[1], force[2], force[3]}));
  expect_force({1.1 * force[0], force[1], force[2], force[3]});
}

template <class Real>
struct Learning {
  Learning(Executor& executor, const char* topology, int rows)
      : topology(nn::Topology::parse(topology)),
        set(bumps(rows, this->topology.inputs(), 3)),
        inputs(executor.device(), set, scaling(), std::vector<SetVariant>{{0, 0}, {0.1, 5}}) {}
  nn::InputScaling scaling() const { return nn::fit_scaling(nn::ScalingKind::set, set); }

  nn::Topology topology;
  nn::FrameSet set;
  LearningInputs<Real> inputs;
};

const std::vector<OnlineMember> members{{7, 0}, {8, 1}, {9, 0}};

/// A few cycles only: rounding has not spread, so that one tolerance does for each precision. 11 rows: a block of
/// patterns and a ragged end.
template <class Real>
void expect_online(Executor& executor, const char* topology) {
  const Learning<Real> c(executor, topology, 11);
  TrainOnline<Real> device(executor, c.topology, c.inputs, members, {});
  device.run(2);
  device.run(1);
  const auto shown = nn::training_set<double>(c.set, c.scaling());
  nn::OnlineState<double> reference(nn::initial_weights(c.topology, 7));
  nn::train_online(reference, shown, {}, 7, 3);
  EXPECT_LT(largest_difference(device.state(0).weights.values, reference.weights.values),
            sizeof(Real) == 4 ? 1e-5 : 1e-12);
  EXPECT_EQ(device.report(1).cycle, 3u);
}

TEST_P(TinyBatches, TrainOnline) {
  for (const char* topology : {"6-5-1", "6-5-3-1"}) {
    expect_online<float>(executor, topology);
    expect_online<double>(executor, topology);
  }
}

TEST_P(TinyBatches, TrainGroup) {
  Executor gpu(executor.device().as_gpu(), {.threads = 1});
  for (const char* topology : {"6-5-1", "6-5-3-1"}) expect_online<float>(gpu, topology);
}

/// Batches inside a work-item, and slices of larger ones (more than TrainBatch::slice patterns), with ragged ends.
template <class Real>
void expect_batches(Executor& executor, nn::BatchRule rule) {
  for (const auto& [rows, batch] : {std::pair{11, 4}, {140, 135}}) {
    const Learning<Real> c(executor, "6-5-3-1", rows);
    const nn::BatchOptions options{.rule = rule, .batch = batch, .rate = 0.05};
    TrainBatch<Real> device(executor, c.topology, c.inputs, members, options);
    ASSERT_TRUE(device.train_epoch());
    const auto shown = nn::training_set<double>(c.set, c.scaling());
    nn::BatchState<double> reference(nn::initial_weights(c.topology, 7));
    nn::train_epoch(reference, shown, options, 7);
    EXPECT_LT(largest_difference(device.state(0).weights.values, reference.weights.values),
              sizeof(Real) == 4 ? 1e-4 : 1e-12)
        << rows << " rows";
  }
}

TEST_P(TinyBatches, TrainBatchByDelta) {
  expect_batches<float>(executor, nn::BatchRule::delta);
  expect_batches<double>(executor, nn::BatchRule::delta);
}
TEST_P(TinyBatches, TrainBatchByAdam) {
  expect_batches<float>(executor, nn::BatchRule::adam);
  expect_batches<double>(executor, nn::BatchRule::adam);
}

TEST_P(TinyBatches, TrainGroupBatch) {
  Executor gpu(executor.device().as_gpu(), {.threads = 1});
  expect_batches<float>(gpu, nn::BatchRule::adam);
}

/// Tolerance as in transducer_chain_test. 6 channels: a part of a vector.
TEST_P(TinyBatches, TransducerChain) {
  // Clang inlines functions that return vectors of 16 with `llvm.experimental.noalias.scope.decl`, which oclgrind 21.10
  // does not know.
  if (lanes_fp32 > 1) GTEST_SKIP();
  const TransducerCase some(5, 6);
  nn::Transducer faults = all_parts;
  faults.shift_spread = 0.2, faults.crosstalk = 0.1, faults.dead = 0.2, faults.lag = 0.2, faults.lag_time = 0.3;
  faults.noise_of_largest = 0.02, faults.gain_spread_from = 0;
  for (const nn::Transducer& t : {all_parts, faults, tactel::tests::skin_parts}) {
    std::vector<float> signal = some.stress;
    TransducerChain(executor, t, 11, 6).run(some.contacts, signal);
    EXPECT_LT(largest_difference(signal, some.by_twin(t, 6)), 3e-6);
  }
}

}  // namespace
