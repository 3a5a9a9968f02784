// Sets of contacts on patches: the rows of a contact depend on the contact alone, and are those of its own solution.
#include <gtest/gtest.h>

#include "host/contact/solve_on_rung.h"
#include "host/sets/set_simulator.h"
#include "tests/host/device/test_device.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host {
namespace {

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

TEST_F(PatchSet, AnyRangeGivesTheSameRows) {
  const SetSimulator simulator(executor_, source_, {});
  const ContactSet whole = simulator.simulate(0, 60);
  std::size_t row = 0;
  for (const auto& [first, count] : {std::pair{0, 7}, {7, 1}, {8, 52}}) {
    const ContactSet part = simulator.simulate(first, count);
    for (std::size_t k = 0; k < part.slip_index.size(); ++k, ++row) {
      ASSERT_EQ(part.contact[k], whole.contact[row]);
      EXPECT_EQ(part.slip_index[k], whole.slip_index[row]);
      EXPECT_TRUE(std::equal(part.frames.begin() + static_cast<std::ptrdiff_t>(k * part.inputs),
                             part.frames.begin() + static_cast<std::ptrdiff_t>((k + 1) * part.inputs),
                             whole.frames.begin() + static_cast<std::ptrdiff_t>(row * part.inputs)));
    }
  }
  EXPECT_EQ(row, whole.slip_index.size());
}

/// The flats are wider than the sensor: the mesh answers them.
TEST_F(PatchSet, RowsAreThoseOfTheSolutions) {
  const SetSimulator simulator(executor_, source_, {});
  const ContactSet set = simulator.simulate(0, 60);
  std::vector<fem::Scene> scenes;
  for (std::uint64_t k = 0; k < 60; ++k) scenes.push_back(source_.contact(k).scene);
  const auto solutions = solve_on_rung(executor_, scenes, usual_patch());
  int on_mesh = 0;
  std::size_t row = 0;
  for (std::uint64_t k = 0; k < 60; ++k) {
    on_mesh += solutions[k].surface_width.size() == 0;
    for (std::size_t step = 1; step < solutions[k].steps.size(); ++step) {  // from full indentation on
      const fem::ContactStep& expected = solutions[k].steps[step];
      if (!expected.slip_index) continue;
      ASSERT_EQ(set.contact[row], k);
      ASSERT_EQ(set.step[row], step);
      EXPECT_EQ(set.slip_index[row], static_cast<float>(*expected.slip_index)) << "contact " << k;
      EXPECT_EQ(set.normal_force[row], static_cast<float>(expected.P)) << "contact " << k;
      EXPECT_EQ(set.frames[row * set.inputs + 10], static_cast<float>(expected.sigma_y[10])) << "contact " << k;
      ++row;
    }
  }
  EXPECT_EQ(row, set.slip_index.size());
  EXPECT_GT(on_mesh, 0);
  EXPECT_LT(on_mesh, 20);
}

/// A file that names no model and a rung on patches.
TEST_F(PatchSet, ARungIsTakenWhateverTheFileSays) {
  SceneSource source = SceneSource::read(folder_.write("usual.toml",
                                                       "[sweep]\ncontacts = 5\n[indenter]\nshape = "
                                                       "\"parabola\"\nradius = 10\n[load]\nindentation "
                                                       "= 0.1\ntangential = [0.05]\n"));
  SetOptions options;
  options.patch = rung_named("patch-8");
  const ContactSet patches = SetSimulator(executor_, source, options).simulate(0, 5);
  const ContactSet meshes = SetSimulator(executor_, source, {}).simulate(0, 5);
  ASSERT_EQ(patches.slip_index.size(), meshes.slip_index.size());
  EXPECT_LE(patches.contact_nodes[0], 8);
  EXPECT_NEAR(patches.slip_index[0], meshes.slip_index[0], 0.05);  // the mesh has three nodes in contact, or four
}

}  // namespace
}  // namespace tactel::host
