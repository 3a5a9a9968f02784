// SPDX-License-Identifier: Apache-2.0

// tactel::simulate beside the rooms that it hides: the same bits.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tactel/simulate.h>

#include <cmath>
#include <tuple>

#include "fem/scenes/scene.h"
#include "host/answers/solve.h"
#include "host/contact/lines/solve_on_rung.h"
#include "host/networks/network_training.h"
#include "host/scenes/scene_file.h"
#include "host/scenes/sweep_file.h"
#include "host/sets/set_simulator.h"
#include "host/training/train_request.h"
#include "nn/infer/network_file.h"
#include "tests/host/networks/network_cases.h"
#include "tests/scratch.h"
#include "tests/thrown_message.h"

namespace simulate_test {

using namespace tactel;
using tactel::tests::executor;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A file of these lines that lives as long as the object.
class SmallFile {
 public:
  SmallFile(const std::string& name, const std::string& text) : path_(folder_.write(name, text)) {}
  std::string path() const { return path_; }

 private:
  tactel::ScratchFolder folder_;
  std::string path_;
};

const char* const sweep_text =
    "[sweep]\ncontacts = 30\nseed = 3\n[indenter]\nshape = \"parabola\"\nradius = { log_uniform = [2, 50] }\n"
    "[contact]\nfriction = { uniform = [0.2, 1.0] }\n[load]\nindentation = 0.15\ntangential_step = 0.05\n"
    "tangential_steps = 6\n";

const auto message_of = [](const auto& call) { return thrown_message<InputError>(call); };

void expect_same(const std::vector<double>& a, const Eigen::VectorXd& b) {
  ASSERT_EQ(a.size(), static_cast<std::size_t>(b.size()));
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i], b[static_cast<Eigen::Index>(i)]) << i;
}

void expect_same(const Path& path, const host::SolveOutcome& outcome) {
  ASSERT_EQ(path.steps.size(), outcome.solution.steps.size());
  for (std::size_t k = 0; k < path.steps.size(); ++k) {
    const Step& step = path.steps[k];
    const fem::ContactStep& twin = outcome.solution.steps[k];
    EXPECT_EQ(step.P, twin.P);
    EXPECT_EQ(step.Q, twin.Q);
    EXPECT_EQ(step.slip_index, twin.slip_index.value());
    EXPECT_EQ(step.converged, twin.converged);
    expect_same(step.sigma_y, twin.sigma_y);
    expect_same(step.tau_xy, twin.tau_xy);
    expect_same(step.normal_force, twin.normal_force);
    EXPECT_EQ(step.status.size(), twin.status.size());
  }
  expect_same(path.surface_x, outcome.solution.surface_x);
  expect_same(path.tactel_x, outcome.solution.tactel_x);
  EXPECT_EQ(path.model, host::model_name(outcome));
}

Scene some_scene(double friction = 0.5) { return {.friction = friction, .load = press(0.1).drag(0.05, 3)}; }

fem::Scene same_scene(double friction = 0.5) {
  return {.friction = friction,
          .load = {.indentation = {0.1}, .tangential_step = 0.05, .tangential_steps = 3},
          .model = fem::SurfaceModel::patch};
}

TEST(SceneApi, ReadsScenesAsTheProgramDoes) {
  const SmallFile file(
      "mesh.toml",
      "title = \"t\"\n[sensor]\ncolumns = 81\nelement = \"q4i\"\nyoung = 1.5\n[indenter]\n"
      "shape = \"taylor\"\npowers = [1, 3]\nscale = 5\nposition = 1\n[contact]\nfriction = \"bonded\"\n"
      "[load]\nnormal_force = 1.0\nangle = 10\n");
  const Scene scene = read_scene(file.path());
  ASSERT_TRUE(scene.sensor.mesh);
  EXPECT_EQ(scene.sensor.mesh->columns, 81);
  EXPECT_EQ(scene.sensor.mesh->element, Element::q4i);
  EXPECT_EQ(scene.sensor.young, 1.5);
  EXPECT_EQ(std::get<Taylor>(scene.indenter.shape).powers, (std::vector<int>{1, 3}));
  EXPECT_EQ(scene.indenter.position, 1);
  EXPECT_EQ(scene.friction, bonded);
  EXPECT_EQ(scene.load.angle, 10);
  EXPECT_TRUE(scene.load.indentation.empty());
  EXPECT_EQ(message_of([&] { validate(scene); }), "no error");
}

TEST(SceneApi, LayersTakeThePlaceOfTheirSum) {
  Scene scene = some_scene();
  scene.sensor = {};
  scene.sensor.layers = {{1.25, 1, 0.45}, {0.25, 10, 0.48}};
  const SmallFile file("layers.toml", tactel::toml(scene));
  const Sensor sensor = read_scene(file.path()).sensor;
  EXPECT_EQ(sensor.layers, scene.sensor.layers);
  EXPECT_EQ(std::tuple(sensor.thickness, sensor.young, sensor.poisson), std::tuple(1.5, 10.0, 0.48));
  scene.sensor.young = 3;
  EXPECT_THAT(message_of([&] { validate(scene); }), HasSubstr("sensor.young"));
}

TEST(SceneApi, SamplesAFunction) {
  const Indenter own{sampled([](double x) { return x * x / 20; }, -6, 6, 1201), 0.5};
  const std::vector<double> x = {-3, -0.25, 0.5, 1.7, 6.4, 8};
  const std::vector<double> y = heights(own, x), parabola = heights({Parabola{10}, 0.5}, x);
  for (std::size_t i = 0; i + 1 < x.size(); ++i) EXPECT_NEAR(y[i], parabola[i], 1e-5) << x[i];  // chords of 0.01 mm
  EXPECT_TRUE(std::isinf(y.back()));
}

TEST(SceneApi, NamesPlaceProblemAndFix) {
  Scene scene = some_scene();
  scene.sensor.poisson = 0.7;
  try {
    validate(scene);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.place, "sensor.poisson");
    EXPECT_THAT(error.problem, HasSubstr("0.7"));
    EXPECT_THAT(error.fix, HasSubstr("0.5"));
  }
  const SmallFile file("wrong.toml", "[indenter]\nshape = \"parabola\"\nraduis = 3\n[load]\nindentation = 0.1\n");
  const std::string message = message_of([&] { read_scene(file.path()); });
  EXPECT_THAT(message, HasSubstr(file.path() + ":3: indenter.raduis"));
  EXPECT_THAT(message, HasSubstr("radius"));
}

TEST(SolveApi, GivesTheBitsOfTheProgram) {
  for (const char* rung : {"", "mesh-41"}) {
    const host::SolveOptions options{.rung = rung};
    expect_same(solve(some_scene(), {.rung = rung}), host::solve(same_scene(), options));
  }
  Scene meshed = some_scene();
  meshed.sensor.mesh = Mesh{};
  fem::Scene twin = same_scene();
  twin.model = fem::SurfaceModel::mesh;
  const Path path = solve(meshed, {.solver = "reference", .estimate_error = true});  // the old word
  expect_same(path, host::solve(twin, {.solver = "full-mesh"}));
  ASSERT_TRUE(path.error);
  EXPECT_GT(path.error->S, 0);
  EXPECT_EQ(path.error->finer, "81 x 21");
}

TEST(SolveApi, RefusesOptionsThatCannotBe) {
  EXPECT_THAT(message_of([] { solve(some_scene(), {.rung = "patch-13"}); }), HasSubstr("rung"));
  EXPECT_THAT(message_of([] { solve(some_scene(), {.precision = "fp16"}); }),
              HasSubstr("precision: fp16; must be fp32"));
  EXPECT_THAT(message_of([] { solve(some_scene(), {.accuracy = 0.1, .rung = "paper"}); }), HasSubstr("accuracy"));
  EXPECT_THAT(message_of([] { solve_many(std::span<const Scene>(), {.solver = "reference"}); }), HasSubstr("solver"));
}

// Many scenes give the bits of their rung, wherever they stand, and NaN behind the end of a path.
TEST(SolveApi, WarnsOfOtherUnits) {
  Scene pascal = some_scene(0.5);
  pascal.sensor.young = 2e6;
  const std::string warning = "sensor.young = 2e+06 MPa: usual are 0.01 to 100 MPa; check the unit";
  EXPECT_EQ(solve(pascal).warnings, std::vector{warning});
  EXPECT_EQ(solve_many(std::vector{some_scene(0.5), pascal}).warnings, std::vector{"scenes[1]: " + warning});
  const SmallFile file("sweep.toml", std::string(sweep_text) + "[sensor]\nyoung = 2e6\n");
  EXPECT_EQ(Sweep(file.path()).warnings(), std::vector{warning});
}

TEST(SolveApi, SolvesManyAsTheirRung) {
  std::vector<Scene> scenes = {some_scene(0.5), some_scene(0.3), some_scene(0.5), some_scene(0)};
  scenes[1].load = press(0.1);
  scenes[2].sensor.mesh = Mesh{};
  const Paths paths = solve_many(scenes);
  ASSERT_EQ(paths.scenes, 4u);
  ASSERT_EQ(paths.steps, 4u);
  ASSERT_EQ(paths.tactels, 21u);
  EXPECT_EQ(paths.rung, "");
  const std::vector<fem::Scene> patches = {same_scene()};
  const auto patch = host::solve_on_rung(executor(), patches, host::usual_patch(), false).front();
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(paths.P[k], patch.steps[k].P);
    EXPECT_EQ(paths.slip_index[k], patch.steps[k].slip_index.value());
    for (std::size_t t = 0; t < 21; ++t) {
      EXPECT_EQ(paths.sigma_y[k * 21 + t], patch.steps[k].sigma_y[static_cast<Eigen::Index>(t)]);
      EXPECT_EQ(paths.tau_xy[k * 21 + t], patch.steps[k].tau_xy[static_cast<Eigen::Index>(t)]);
    }
    EXPECT_EQ(paths.converged[k], 1);
  }
  EXPECT_EQ(paths.steps_made, (std::vector<std::uint32_t>{4, 1, 4, 4}));
  EXPECT_TRUE(std::isnan(paths.P[4 + 1]) && std::isnan(paths.sigma_y[(4 + 1) * 21]));
  EXPECT_TRUE(std::isnan(paths.slip_index[12]));                                      // mu P = 0
  EXPECT_NEAR(paths.P[8], solve(scenes[2], {.precision = "fp32"}).steps[0].P, 1e-4);  // on its own mesh
  EXPECT_EQ(solve_many(std::span(scenes).first(1), {.rung = "mesh-41"}).rung, "mesh-41");
  EXPECT_EQ(solve_many(std::span<const Scene>()).steps, 0u);
  scenes[3].friction = -1;
  EXPECT_THAT(message_of([&] { solve_many(scenes); }), HasSubstr("scenes[3].contact.friction"));
}

// A requested residual is accepted by one scene and by many alike, on patches and meshes: the same sweeps, the same
// bits.
TEST(SolveApi, ARequestedToleranceMeansTheSameForOneAndMany) {
  std::vector<Scene> scenes(1, some_scene(0.5));
  for (const char* rung : {"patch-12", "mesh-41"}) {
    const Paths many = solve_many(scenes, {.rung = rung, .tolerance = 5e-3});
    const Path one = solve(scenes[0], {.rung = rung, .tolerance = 5e-3});
    for (std::size_t k = 0; k < many.steps; ++k) EXPECT_EQ(many.P[k], one.steps[k].P) << rung;
  }
}

// Steps are those that the load asks for, whatever increments the rung takes between them.
TEST(SolveApi, GivesTheStepsThatTheLoadAsksForOnEveryRung) {
  std::vector<Scene> scenes = {some_scene(0.5), some_scene(0.5)};
  scenes[0].load = press(0.15).drag(0.05, 3);
  scenes[1].load = press(0.15, 2);
  scenes[1].load.indentation = {0.05, 0.15};  // each in two steps
  for (const char* rung : {"patch-12", "mesh-41", "mesh-161"}) {
    const Paths paths = solve_many(scenes, {.rung = rung});
    EXPECT_EQ(paths.steps_made, (std::vector<std::uint32_t>{4, 4})) << rung;
    EXPECT_EQ(paths.steps, 4u) << rung;
    const auto near = [](double depth) { return DoubleNear(depth, 1e-7); };  // fp32
    EXPECT_THAT(std::vector(paths.indentation.begin() + 4, paths.indentation.end()),
                ElementsAre(near(0.025), near(0.05), near(0.1), near(0.15)))
        << rung;
    EXPECT_NEAR(paths.P[0], paths.P[7], 0.02 * paths.P[0]) << rung;  // one depth, by different increments
  }
}

// A path whose length is not known before it slides widens the arrays; those of others keep their places.
TEST(SolveApi, WidensTheArraysForADragUntilSliding) {
  std::vector<Scene> scenes = {some_scene(0.5), some_scene(0.5)};
  scenes[0].load = press(0.15).drag(0.05, 2);
  scenes[1].load = press(0.15).drag_until_sliding(0.004);
  const Paths paths = solve_many(scenes);
  const std::uint32_t steps = paths.steps_made[1];
  ASSERT_GT(steps, 40u);
  EXPECT_EQ(paths.steps, steps);
  EXPECT_EQ(paths.steps_made[0], 3u);
  EXPECT_EQ(paths.sliding, (std::vector<std::uint8_t>{0, 1}));
  EXPECT_TRUE(std::isnan(paths.P[3]) && std::isnan(paths.sigma_y[3 * 21]));
  EXPECT_FLOAT_EQ(static_cast<float>(paths.slip_index[2 * steps - 1]), 1.0f);
  const Paths alone = solve_many(std::span(scenes).first(1));
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(alone.slip_index[k], paths.slip_index[k]);
}

// A contact across the whole sensor beside others.
TEST(SolveApi, SolvesContactsAcrossTheWholeSensor) {
  std::vector<Scene> scenes(3, some_scene(0.5));
  scenes[1].indenter.shape = Flat{};  // wider than the sensor
  const Paths paths = solve_many(scenes);
  const std::vector<fem::Scene> flat = [] {
    fem::Scene scene = same_scene();
    scene.indenter.shape = fem::Flat{};
    return std::vector{scene};
  }();
  const auto expected = host::solve_on_rung(executor(), flat, host::usual_patch(), false).front();
  ASSERT_EQ(expected.surface_width.size(), 12);
  for (std::size_t k = 0; k < paths.steps; ++k) {
    EXPECT_EQ(paths.P[k], paths.P[2 * paths.steps + k]);
    EXPECT_EQ(paths.P[paths.steps + k], expected.steps[k].P);
  }
}

TEST(SweepApi, GivesTheRowsOfTheProgram) {
  const SmallFile file("sweep.toml", sweep_text);
  const Sweep sweep(file.path());
  EXPECT_EQ(sweep.contacts(), 30u);
  EXPECT_TRUE(sweep.endless());
  std::vector<std::uint64_t> told;
  const Set set = sweep.generate({}, {}, [&](std::uint64_t done, std::uint64_t) { return told.push_back(done), true; });
  host::Sweep twin = host::read_sweep(file.path());
  std::get<host::SceneSource>(twin.source).model_on(host::usual_patch());
  const host::SetOptions options{.precision = host::usual_patch().precision,
                                 .tolerance = host::usual_patch().tolerance,
                                 .patch = host::usual_patch()};
  const host::ContactSet rows = host::SetSimulator(executor(), twin.source, options).simulate(0, 30);
  EXPECT_EQ(set.frames, rows.frames);
  EXPECT_EQ(set.slip_index, rows.slip_index);
  EXPECT_EQ(set.contact, rows.contact);
  EXPECT_EQ(set.rows(), 30u * 7u);
  EXPECT_EQ(told, (std::vector<std::uint64_t>{0, 30}));
  EXPECT_EQ(sweep.scene(4).friction, twin.lines("sweep").contact(4).scene.friction);
  EXPECT_THROW(sweep.generate({}, {}, [](std::uint64_t, std::uint64_t) { return false; }), Cancelled);

  SweepBatches batches(sweep, 12);
  Set batch;
  std::vector<float> joined;
  for (int k = 0; k < 3; ++k) {
    ASSERT_TRUE(batches.next(batch));
    joined.insert(joined.end(), batch.frames.begin(), batch.frames.end());
  }
  ASSERT_GT(joined.size(), set.frames.size());
  joined.resize(set.frames.size());
  EXPECT_EQ(joined, set.frames);
}

TEST(SweepApi, WritesSetsThatTheProgramReads) {
  const SmallFile file("sweep.toml", sweep_text), saved("set.h5", "");
  const Set set = Sweep(file.path()).generate(4);
  write_set(set, saved.path());
  const host::ContactSet twin = host::read_contact_set(saved.path());
  EXPECT_EQ(twin.frames, set.frames);
  EXPECT_EQ(twin.slip_index, set.slip_index);
  EXPECT_EQ(twin.sweep, sweep_text);
  EXPECT_EQ(twin.seed, 3u);
  EXPECT_EQ(twin.contacts, 4u);
  EXPECT_THAT(twin.rung, HasSubstr("patch-12"));
  const Set again = read_set(saved.path());
  EXPECT_EQ(again.frames, set.frames);
  EXPECT_EQ(again.indenter_names, set.indenter_names);
  EXPECT_EQ(again.parameter_names, set.parameter_names);
  ASSERT_EQ(set.parameters.size(), 4 * set.parameter_names.size());
  EXPECT_EQ(again.tangential, set.tangential);
  Set wrong = set;
  wrong.parameters.pop_back();
  EXPECT_THAT(message_of([&] { write_set(wrong, saved.path()); }), HasSubstr("parameters"));
  EXPECT_THAT(message_of([&] { write_set(set, "/no/such/folder/set.h5"); }),
              HasSubstr("/no/such/folder/set.h5: cannot be written"));
}

TEST(SweepApi, TakesAnotherSeed) {
  const SmallFile file("sweep.toml", sweep_text);
  std::string other = sweep_text;
  other.replace(other.find("seed = 3"), 8, "seed = 8");
  const SmallFile second("other.toml", other);
  EXPECT_EQ(Sweep(file.path(), 8).generate(5).frames, Sweep(second.path()).generate(5).frames);
  EXPECT_NE(Sweep(file.path(), 8).generate(5).frames, Sweep(file.path()).generate(5).frames);
  EXPECT_THAT(message_of([&] { Sweep("none.toml"); }), HasSubstr("none.toml"));
}

TEST(TrainApi, TrainsTheNetworksOfTheProgram) {
  const SmallFile file("sweep.toml", sweep_text);
  const Set set = Sweep(file.path()).generate();
  const TrainOptions options{.networks = {"42-6-1"}, .seeds = 2, .noises = {0.1}, .cycles = 4};
  const std::vector<Network> networks = train(set, options);
  ASSERT_EQ(networks.size(), 2u);
  EXPECT_EQ(networks[1].topology(), "42-6-1");
  EXPECT_EQ(networks[1].seed(), 2u);

  host::TrainRequest request;
  request.networks = options.networks, request.noises = {0.1}, request.seeds = 2, request.cycles = 4;
  nn::FrameSet frames{nn::RowMatrix<float>(set.rows(), 42), nn::Vector<float>(set.rows()), {}, {}};
  std::ranges::copy(set.frames, frames.frames.data());
  std::ranges::copy(set.slip_index, frames.slip_index.data());
  frames.shape_class = set.indenter, frames.friction = set.friction;
  frames.contact_nodes.assign(set.contact_nodes.begin(), set.contact_nodes.end());
  host::NetworkTraining<float> twin(executor(), frames, host::plan_of(request));
  twin.run();
  for (std::size_t i = 0; i < 2; ++i) {
    const nn::ErrorSummary own = twin.recall_learning_set()[i].all;
    EXPECT_EQ(networks[i].onnx(), infer::network_bytes(twin.model(i, "set", own))) << i;
  }

  const SmallFile saved("net.onnx", "");
  networks[1].to_onnx(saved.path());
  EXPECT_EQ(Network::load(saved.path()).onnx(), networks[1].onnx());
  const Errors own = errors(networks[1].estimator(), set);
  EXPECT_EQ(own.rows, set.rows());
  EXPECT_GT(own.mean, 0);
  EXPECT_LE(own.mean, own.largest);
  EXPECT_EQ(networks[1].learning_errors().rows, set.rows());
}

TEST(TrainApiNightly, TrainsBoundsAndHistory) {
  std::string text = sweep_text;
  text.replace(text.find("seed = 3"), 8, "seed = 3\npress_rows = true");
  const SmallFile file("presses.toml", text);
  const Set set = Sweep(file.path()).generate();
  ASSERT_TRUE(set.press_rows);
  const TrainOptions options{.networks = {"84-6-1"},
                             .schedule = "batch",
                             .cycles = 4,
                             .bound = true,
                             .level = 0.9,
                             .history = "2:1",
                             .history_change = 0.05};
  const Network network = train(set, options).at(0);
  const SlipEstimator estimator = network.estimator();
  EXPECT_EQ(estimator.inputs(), 84u);
  EXPECT_EQ(estimator.frames(), 2u);
  EXPECT_EQ(network.topology(), "84-6-3");
  EXPECT_NEAR(errors(estimator, set).mean, network.learning_errors().mean, 1e-5);
  const TrainOptions leaky{.networks = {"42-5-1_leaky-relu"}, .schedule = "batch", .cycles = 2};
  const Network rectifiers = train(set, leaky).at(0);
  EXPECT_EQ(rectifiers.topology(), "42-5-1_leaky-relu");
  EXPECT_NEAR(errors(rectifiers.estimator(), set).mean, rectifiers.learning_errors().mean, 1e-5);
  EXPECT_THAT(message_of([&] { train(set, {.networks = {"42-5-1_leaky-relu"}}); }), HasSubstr("batch"));
  EXPECT_THAT(message_of([&] { train(set, {.networks = {"42-5-1"}, .bound = true}); }), HasSubstr("bound"));
  const SmallFile plain("plain.toml", sweep_text);
  const Set pressed = Sweep(plain.path()).generate();
  EXPECT_THAT(message_of([&] { train(pressed, options); }), HasSubstr("press_rows"));
  EXPECT_THAT(message_of([&] { errors(estimator, pressed); }), HasSubstr("press_rows"));
}

TEST(TrainApi, KeepsTheBestWeightsOfAValidationSet) {
  const SmallFile file("sweep.toml", sweep_text);
  const Set set = Sweep(file.path()).generate();
  Set against = set;
  for (float& s : against.slip_index) s = 1 - s;
  const TrainOptions options{.networks = {"42-5-1"},
                             .schedule = "cosine",
                             .loss = "absolute",
                             .cycles = 100,
                             .batch = 8,
                             .average = 0.5,
                             .validation = &against,
                             .patience = 4};
  const Network early = train(set, options).at(0);
  EXPECT_LT(early.cycles(), 96u);
  TrainOptions endless = options;
  endless.patience = std::nullopt;
  EXPECT_EQ(train(set, endless).at(0).cycles(), early.cycles());  // its error only rises from there
  TrainOptions alone = options;
  alone.validation = nullptr;
  EXPECT_THAT(message_of([&] { train(set, alone); }), HasSubstr("patience"));
}

TEST(TrainApi, RefusesWhatCannotTrain) {
  const SmallFile file("sweep.toml", sweep_text);
  Set set = Sweep(file.path()).generate(3);
  EXPECT_THAT(message_of([&] { train(set, {.networks = {"40-5-1"}}); }), HasSubstr("network: 40-5-1"));
  EXPECT_THAT(message_of([&] { train(set, {.networks = {"42-5-1"}, .schedule = "never"}); }), HasSubstr("schedule"));
  EXPECT_THAT(message_of([&] { train(set, {.networks = {"42-5-1"}, .optimizer = "adam"}); }), HasSubstr("optimizer"));
  EXPECT_THAT(message_of([&] { train({}, {.networks = {"42-5-1"}}); }), HasSubstr("0 rows"));
  set.friction.pop_back();
  EXPECT_THAT(message_of([&] { train(set, {.networks = {"42-5-1"}}); }), HasSubstr("set: "));
}

}  // namespace simulate_test
