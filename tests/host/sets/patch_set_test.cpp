// SPDX-License-Identifier: Apache-2.0

// Sets of contacts on patches: the rows of a contact depend on the contact alone, and are those of its own solution.
#include <gtest/gtest.h>

#include <algorithm>
#include <thread>
#include <vector>

#include "host/contact/lines/solve_on_rung.h"
#include "host/sets/set_simulator.h"
#include "tests/host/device/test_device.h"
#include "tests/host/sets/same_bytes.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::patch_set_test {

constexpr const char* sweep_text = R"(
[sweep]
contacts = 60
seed = 11
[sensor]
model = "patch"
[contact]
friction = { log_uniform = [0.1, 1.2] }
[[indenter]]
shape = "wedge"
edge_angle = { uniform = [120, 170] }
position = { uniform = [-9, 9] }
[[indenter]]
shape = "parabola"
radius = { log_uniform = [1, 60] }
[[indenter]]
shape = "flat"
weight = 0.2
[load]
indentation = { uniform = [0.05, 0.2] }
indentation_steps = 2
tangential = [{ uniform = [0, 0.05] }, { uniform = [0.05, 0.2] }]
)";

class PatchSet : public testing::Test {
 protected:
  PatchSet() : source_(SceneSource::read(folder_.write("sweep.toml", sweep_text))), executor_(device()) {}
  ScratchFolder folder_;
  const SceneSource source_;
  Executor executor_;
};

// Elements are laid for the deepest step, the fourth of each press.
TEST_F(PatchSet, RowsOnFewElementsAreMarked) {
  const SceneSource source = SceneSource::read(folder_.write(
      "presses.toml",
      "[sweep]\ncontacts = 8\npress_rows = true\n[indenter]\nshape = \"wedge\"\nedge_angle = 160\n[load]\n"
      "indentation = 0.15\n[load.irregular]\npress_steps = 4\nstroke = 0.01\nstroke_steps = 1\n"));
  const ContactSet set = SetSimulator(executor_, source, {.patch = rung_named("patch-12")}).simulate(0, 8);
  std::size_t marked = 0;
  for (std::size_t row = 0; row < set.rows(); ++row) {
    const bool few = set.status[row] == coarse_row;
    marked += few;
    EXPECT_EQ(few, set.contact_nodes[row] < fem::least_elements) << row;
    EXPECT_FALSE(few && set.step[row] >= 3) << row;
  }
  EXPECT_GT(marked, 0u);
  EXPECT_EQ(set.coarse, marked);
}

// Some contacts on a covered line, some on one without a cover. Expected: each scene solved alone.
TEST_F(PatchSet, LayersAreThoseOfTheScenes) {
  const SceneSource source = SceneSource::read(folder_.write(
      "layers.toml",
      "[sweep]\ncontacts = 24\n[indenter]\nshape = \"parabola\"\nradius = { uniform = [5, 20] }\n"
      "[load]\nindentation = 0.12\ntangential = [0.02, 0.05]\n[[sensor]]\nyoung = 0.5\n[[sensor]]\n"
      "[[sensor.layers]]\nthickness = 1.4\nyoung = 0.5\n[[sensor.layers]]\nthickness = 0.1\nyoung = 5\n"));
  const Rung rung = rung_named("patch-12");
  const ContactSet set = SetSimulator(executor_, source, {.patch = rung}).simulate(0, 24);
  std::size_t covered = 0;
  for (std::size_t row = 0; row < set.rows(); ++row) {
    const fem::Scene scene = source.contact(set.contact[row]).scene;
    const fem::ContactStep step = solve_on_rung(executor_, std::span(&scene, 1), rung)[0].steps[set.step[row]];
    EXPECT_NEAR(set.normal_force[row], step.P, 1e-5 * step.P) << row;
    EXPECT_NEAR(set.slip_index[row], *step.slip_index, 1e-4) << row;
    covered += !scene.sensor.layers.empty();
  }
  EXPECT_GT(covered, 6u);
  EXPECT_LT(covered, set.rows() - 6);
}

// As a GPU has them: one lane, work-groups of 64 with a ragged end, and memory of its own. On patches, and on a mesh.
TEST_F(PatchSet, OnAGpuTheBytesAreTheSame) {
  Executor gpu{device().as_gpu()};
  std::string mesh = sweep_text;
  mesh.replace(mesh.find("model = \"patch\""), 15, "columns = 41\nrows = 6\ntactels = 5");
  const SceneSource on_mesh = SceneSource::read(folder_.write("mesh.toml", mesh));
  for (const auto& [source, options] :
       {std::pair(&source_, SetOptions{.patch = rung_named("patch-8")}), std::pair(&on_mesh, SetOptions{})}) {
    const ContactSet expected = SetSimulator(executor_, *source, options).simulate(0, 70),
                     found = SetSimulator(gpu, *source, options).simulate(0, 70);
    EXPECT_GT(expected.rows(), 70u);
    expect_same_bytes(found, expected);
  }
}

// Threads of a GPU's set take chunks side by side.
// Rounds after the first take buffers that another chunk gave back.
TEST_F(PatchSet, ChunksSideBySideOnAGpuHaveTheSameBytes) {
  constexpr std::size_t chunks = 6, contacts = 50, rounds = 10;
  Executor gpu{device().as_gpu()};
  const SetOptions options{.patch = rung_named("patch-8")};
  const SetSimulator expected(executor_, source_, options), found(gpu, source_, options);
  std::vector<ContactSet> sets(chunks);
  for (std::size_t round = 0; round < rounds; ++round) {
    std::vector<std::jthread> threads;
    for (std::size_t k = 0; k < chunks; ++k)
      threads.emplace_back([&, k] { sets[k] = found.simulate(k * contacts, contacts); });
  }
  for (std::size_t k = 0; k < chunks; ++k) expect_same_bytes(sets[k], expected.simulate(k * contacts, contacts));
}

// Two sensors, then the one Poisson's ratio of own sensors. Every message ends before the next one.
TEST_F(PatchSet, TheLogHearsHowManyTablesAreMade) {
  const auto heard = [&](const std::string& sensors) {
    std::vector<std::string> all;
    const LogSink sink = [&](LogLevel level, std::string_view message) {
      if (level == LogLevel::busy) all.emplace_back(message);
    };
    Executor executor{Device("", sink)};
    const std::string text = "[sweep]\ncontacts = 2\n" + sensors +
                             "[indenter]\nshape = \"parabola\"\nradius = 2\n[load]\nindentation = 0.1\n";
    const SceneSource source = SceneSource::read(folder_.write("sensors.toml", text));
    const SetSimulator simulator(executor, source, {});
    EXPECT_EQ(2 * std::ranges::count(all, ""), std::ssize(all));
    std::erase_if(all, [](const std::string& message) { return !message.starts_with("tables"); });
    return all;
  };
  const auto expected = [](int count) {
    std::vector<std::string> all;
    all.reserve(count);
    for (int k = 0; k < count; ++k)
      all.push_back("tables of sensors, " + std::to_string(k) + " of " + std::to_string(count));
    return all;
  };
  EXPECT_EQ(heard("[[sensor]]\n[[sensor]]\npoisson = 0.4\n"), expected(2));
  EXPECT_EQ(heard("[sensor]\nthickness = { uniform = [1, 2] }\n"), expected(1));
}

TEST_F(PatchSet, AnyRangeGivesTheSameRows) {
  const SetSimulator simulator(executor_, source_, {});
  expect_ranges_make(simulator.simulate(0, 60), simulator, {{0, 7}, {7, 1}, {8, 52}});
}

/// S as a set has it: rounding of Q / (mu P) beyond 1 is cut.
float in_range(double slip_index) { return static_cast<float>(std::clamp(slip_index, -1.0, 1.0)); }

/// The flats are wider than the sensor.
TEST_F(PatchSet, RowsAreThoseOfTheSolutions) {
  const SetSimulator simulator(executor_, source_, {});
  const ContactSet set = simulator.simulate(0, 60);
  std::vector<fem::Scene> scenes;
  for (std::uint64_t k = 0; k < 60; ++k) scenes.push_back(source_.contact(k).scene);
  const auto solutions = solve_on_rung(executor_, scenes, usual_patch());
  std::size_t row = 0;
  for (std::uint64_t k = 0; k < 60; ++k) {
    for (std::size_t step = 1; step < solutions[k].steps.size(); ++step) {  // from full indentation on
      const fem::ContactStep& expected = solutions[k].steps[step];
      if (!expected.slip_index) continue;
      ASSERT_EQ(set.contact[row], k);
      ASSERT_EQ(set.step[row], step);
      EXPECT_EQ(set.slip_index[row], in_range(*expected.slip_index)) << "contact " << k;
      EXPECT_EQ(set.normal_force[row], static_cast<float>(expected.P)) << "contact " << k;
      EXPECT_EQ(set.frames[row * set.inputs + 10], static_cast<float>(expected.sigma_y[10])) << "contact " << k;
      ++row;
    }
  }
  EXPECT_EQ(row, set.slip_index.size());
}

constexpr const char* thin_text = R"(
[sweep]
contacts = 4
seed = 3
[sensor]
model = "patch"
length = 60
thickness = 1
poisson = 0.499
tactel_span = 50
[contact]
friction = { log_uniform = [0.1, 0.6] }
[[indenter]]
shape = "parabola"
radius = { log_uniform = [1, 800] }
[load]
indentation = 0.05
tangential = [0.1, 0.3]
)";

/// Wide contacts on thin rubber are solved on linear elements, as solve does, and count among the fallbacks.
TEST_F(PatchSet, WideContactsOnThinRubberHaveLinearElements) {
  const SceneSource source = SceneSource::read(folder_.write("thin.toml", thin_text));
  const ContactSet set = SetSimulator(executor_, source, {}).simulate(0, 4);
  std::vector<fem::Scene> scenes;
  for (std::uint64_t k = 0; k < 4; ++k) scenes.push_back(source.contact(k).scene);
  const auto solutions = solve_on_rung(executor_, scenes, usual_patch());
  const auto linear = std::ranges::count_if(solutions, &fem::ContactSolution::linear_elements);
  EXPECT_EQ(set.fell_back, linear);
  EXPECT_GT(linear, 0);
  EXPECT_LT(linear, 4);
  ASSERT_EQ(set.slip_index.size(), 12u);
  for (std::size_t row = 0; row < 12; ++row) {
    const fem::ContactStep& expected = solutions[set.contact[row]].steps[set.step[row]];
    EXPECT_EQ(set.slip_index[row], in_range(*expected.slip_index)) << row;
    EXPECT_EQ(set.normal_force[row], static_cast<float>(expected.P)) << row;
  }
}

/// A file that names no model and a rung on patches.
TEST_F(PatchSet, ARungIsTakenWhateverTheFileSays) {
  SceneSource source = SceneSource::read(folder_.write("usual.toml",
                                                       "[sweep]\ncontacts = 5\n[indenter]\nshape = "
                                                       "\"parabola\"\nradius = 10\n[load]\nindentation "
                                                       "= 0.1\ntangential = [0.05]\n"));
  const ContactSet patches = SetSimulator(executor_, source, {.patch = rung_named("patch-8")}).simulate(0, 5);
  const ContactSet meshes = SetSimulator(executor_, source, {}).simulate(0, 5);
  ASSERT_EQ(patches.slip_index.size(), meshes.slip_index.size());
  EXPECT_LE(patches.contact_nodes[0], 8);
  EXPECT_NEAR(patches.slip_index[0], meshes.slip_index[0], 0.05);  // the mesh has three nodes in contact, or four
}

/// A rung on meshes, of a file that asks for patches: three or four of the mesh's nodes touch, ten elements of a patch.
TEST_F(PatchSet, ARungOnAMeshOverridesTheFile) {
  const std::string load = "[indenter]\nshape = \"parabola\"\nradius = 10\n[load]\nindentation = 0.1\n";
  const std::string head = "[sweep]\ncontacts = 5\n[sensor]\nmodel = ";
  SceneSource on_patches = SceneSource::read(folder_.write("patch.toml", head + "\"patch\"\n" + load));
  SceneSource on_mesh = SceneSource::read(folder_.write("mesh.toml", head + "\"mesh\"\n" + load));
  on_patches.model_on(rung_named("mesh-81"));
  on_mesh.model_on(rung_named("mesh-81"));
  EXPECT_EQ(on_patches.model(), fem::SurfaceModel::mesh);
  const ContactSet set = SetSimulator(executor_, on_patches, {}).simulate(0, 5);
  const ContactSet expected = SetSimulator(executor_, on_mesh, {}).simulate(0, 5);
  EXPECT_EQ(set.contact_nodes, expected.contact_nodes);
  EXPECT_EQ(set.frames, expected.frames);
  on_mesh.model_on(rung_named("patch-8"));
  EXPECT_EQ(on_mesh.model(), fem::SurfaceModel::patch);
}

/// Every contact on a sensor of its own.
class OwnSensors : public testing::Test {
 protected:
  static std::string text() {
    std::string text = sweep_text;
    const std::string model = "model = \"patch\"\n";
    return text.replace(text.find(model), model.size(),
                        "poisson = { uniform = [0.4, 0.49] }\nthickness = { uniform = [1.2, 1.8] }\n"
                        "young = { log_uniform = [1, 4] }\nlength = { uniform = [18, 22] }\n");
  }
  OwnSensors() : source_(SceneSource::read(folder_.write("sweep.toml", text()))), executor_(device()) {}
  ScratchFolder folder_;
  const SceneSource source_;
  Executor executor_;
};

TEST_F(OwnSensors, AnyRangeGivesTheSameRows) {
  const SetSimulator simulator(executor_, source_, {});
  const ContactSet whole = simulator.simulate(0, 60);
  EXPECT_EQ(whole.unsolved, 0u);
  expect_ranges_make(whole, simulator, {{0, 7}, {7, 1}, {8, 52}});
}

/// What the model of each sensor, with a condensation of its own, says of the same contact.
TEST_F(OwnSensors, RowsAreThoseOfTheModelOfEach) {
  const ContactSet set = SetSimulator(executor_, source_, {}).simulate(0, 20);
  std::vector<fem::Scene> scenes;
  for (std::uint64_t k = 0; k < 20; ++k) scenes.push_back(source_.contact(k).scene);
  const auto expected = solve_on_rung(executor_, scenes, usual_patch());
  for (std::size_t row = 0; row < set.rows(); ++row) {
    const fem::Scene& scene = scenes[set.contact[row]];
    const fem::ContactStep& step = expected[set.contact[row]].steps[set.step[row]];
    EXPECT_EQ(set.poisson[row], static_cast<float>(scene.sensor.poisson));
    EXPECT_EQ(set.young[row], static_cast<float>(scene.sensor.young));
    EXPECT_EQ(set.length[row], static_cast<float>(scene.sensor.length));
    EXPECT_NEAR(set.slip_index[row], *step.slip_index, 5e-3) << "contact " << set.contact[row];
    EXPECT_NEAR(set.normal_force[row], step.P, 1e-2 * step.P) << "contact " << set.contact[row];
  }
}

TEST_F(OwnSensors, AreColumnsOfTheFile) {
  ContactSet set = SetSimulator(executor_, source_, {}).simulate(0, 10);
  set.contacts = 10;
  const std::filesystem::path path = folder_ / "own.h5";
  write_contact_set(path, set);
  const ContactSet read = read_contact_set(path);
  EXPECT_TRUE(read.sensors);
  EXPECT_EQ(read.poisson, set.poisson);
  EXPECT_EQ(read.thickness, set.thickness);
  EXPECT_EQ(read.young, set.young);
  EXPECT_EQ(read.length, set.length);
  EXPECT_EQ(read.residual, set.residual);
}

}  // namespace tactel::host::patch_set_test
