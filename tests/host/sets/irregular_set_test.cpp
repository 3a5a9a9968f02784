// SPDX-License-Identifier: Apache-2.0

// Sets of irregular paths with the rows of their pressing, and the histories that networks take from them.
#include <gtest/gtest.h>

#include "host/contact/lines/solve_on_rung.h"
#include "host/sets/set_simulator.h"
#include "host/support/errors.h"
#include "tests/host/device/test_device.h"
#include "tests/host/sets/same_bytes.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::irregular_set_test {

const std::string sweep_text = R"(
[sweep]
contacts = 40
seed = 11
press_rows = true
[sensor]
tactel_span = 18
[contact]
friction = { uniform = [0.1, 1.0] }
[indenter]
shape = "parabola"
radius = { log_uniform = [3, 60] }
position = { uniform = [-3, 3] }
[load]
indentation = { uniform = [0.08, 0.2] }
[load.irregular]
presses = { choice = [1, 2] }
press_steps = { uniform = [2, 5] }
strokes = { uniform = [1, 3] }
stroke = { log_uniform = [0.02, 0.2] }
stroke_steps = { uniform = [2, 5] }
reversal = 0.5
backward = 0.5
pause = 0.2
release = 0.4
)";

class IrregularSet : public testing::Test {
 protected:
  SceneSource source(const std::string& text) { return SceneSource::read(folder_.write("sweep.toml", text)); }
  static std::string replaced(std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  }
  ScratchFolder folder_;
  Executor executor_{device()};
};

TEST_F(IrregularSet, AnyRangeGivesTheSameRowsAndTheyBeginWithThePressing) {
  const SceneSource sweep = source(sweep_text);
  const SetSimulator simulator(executor_, sweep, {});
  const ContactSet whole = simulator.simulate(0, 40);
  EXPECT_TRUE(whole.press_rows);
  EXPECT_EQ(whole.unsolved, 0u);
  expect_ranges_make(whole, simulator, {{0, 7}, {7, 1}, {8, 32}});
  for (std::size_t row = 0; row < whole.rows(); ++row)
    ASSERT_TRUE(whole.step[row] == 0 || (row > 0 && whole.contact[row] == whole.contact[row - 1])) << row;
  write_contact_set(folder_ / "set.h5", whole);
  EXPECT_TRUE(read_contact_set(folder_ / "set.h5").press_rows);
  EXPECT_TRUE(ContactSetReader(folder_ / "set.h5").read(3, 4).press_rows);
  // without the rows of the pressing: the others, bit for bit
  const SceneSource later = source(replaced(sweep_text, "press_rows = true", "press_rows = false"));
  const ContactSet fewer = SetSimulator(executor_, later, {}).simulate(0, 40);
  EXPECT_FALSE(fewer.press_rows);
  std::size_t at = 0;
  for (std::size_t k = 0; k < fewer.rows(); ++k, ++at) {
    while (whole.contact[at] != fewer.contact[k] || whole.step[at] != fewer.step[k]) ++at;
    EXPECT_EQ(whole.slip_index[at], fewer.slip_index[k]);
  }
  EXPECT_LT(fewer.rows(), whole.rows());
}

/// Load and reload with reversals, by a solver that shares no path code with the kernel but the list of increments:
/// as RunsAsItStandsAndOnAPatch of the examples, on the finest patch.
TEST_F(IrregularSet, PathsAreSolvedAsByTheReference) {
  const SceneSource sweep = source(sweep_text);
  std::vector<fem::Scene> scenes;
  for (std::uint64_t k = 0; k < 6; ++k) scenes.push_back(sweep.contact(k).scene);
  const auto fine = solve_on_rung(executor_, scenes, rung_named("patch-24"));
  const auto exact = solve_on_rung(executor_, scenes, rung_named("reference"));
  std::vector<double> differences;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    ASSERT_EQ(fine[i].steps.size(), fem::load_path(scenes[i].load).steps.size());
    for (std::size_t k = 0; k < fine[i].steps.size(); ++k) {
      ASSERT_EQ(fine[i].steps[k].slip_index.has_value(), exact[i].steps[k].slip_index.has_value());
      if (fine[i].steps[k].slip_index)
        differences.push_back(std::abs(*fine[i].steps[k].slip_index - *exact[i].steps[k].slip_index));
    }
  }
  std::ranges::sort(differences);
  ASSERT_GT(differences.size(), 50u);
  EXPECT_LT(differences[differences.size() * 9 / 10], 0.02);
}

/// Twice the stiffness doubles every stress: the same S, and under scaling by frame the same inputs, bit for bit.
TEST_F(IrregularSet, StiffnessScalesNothingThatANetworkSees) {
  const auto inputs = [&](const std::string& young) {
    const SceneSource sweep = source(replaced(sweep_text, "tactel_span = 18", "tactel_span = 18\nyoung = " + young));
    const ContactSet set = SetSimulator(executor_, sweep, {}).simulate(0, 40);
    const nn::FrameSet formed = nn::with_history(set.frames_with_answers(), {.frames = 4, .stride = 1, .change = 0.1});
    return std::pair(nn::scale_frames<float>(nn::fit_scaling(nn::ScalingKind::frame, formed), formed.frames),
                     set.slip_index);
  };
  const auto [one, s] = inputs("2.0");
  const auto [twice, same] = inputs("4.0");
  EXPECT_EQ(s, same);
  EXPECT_EQ(one, twice);
  EXPECT_GT(one.rightCols(42).cwiseAbs().maxCoeff(), 0.1f);  // there are frames of the past
}

TEST_F(IrregularSet, GainsStayAlongAContactAndDifferBetweenContacts) {
  const std::string gains = sweep_text + "[transducer]\ngain_spread = { uniform = [0.05, 0.2] }\n";
  const SceneSource with = source(gains);
  const ContactSet read = SetSimulator(executor_, with, {}).simulate(0, 40);
  const SceneSource without = source(sweep_text);
  const ContactSet bare = SetSimulator(executor_, without, {}).simulate(0, 40);
  ASSERT_EQ(read.rows(), bare.rows());
  constexpr int channel = 10;  // under the middle
  std::vector<double> of_contact(40, 0);
  for (std::size_t row = 0; row < read.rows(); ++row) {
    const std::size_t at = row * static_cast<std::size_t>(read.inputs) + channel;
    if (std::abs(bare.frames[at]) < 1e-3f) continue;
    const double gain = read.frames[at] / bare.frames[at];
    double& known = of_contact[read.contact[row]];
    if (known != 0) {
      EXPECT_NEAR(gain, known, 4e-7) << "contact " << read.contact[row];  // two roundings
    }
    known = gain;
  }
  std::ranges::sort(of_contact);
  EXPECT_GT(of_contact[35] - of_contact[5], 0.1);
}

TEST_F(IrregularSet, RefusesFilesThatSayAnythingElse) {
  const SceneSource sweep = source(sweep_text);
  const std::string path = folder_ / "set.h5";
  ContactSet set = SetSimulator(executor_, sweep, {}).simulate(0, 3);
  write_contact_set(path, set);
  std::string bytes = text_of(path);
  const std::size_t at = bytes.find("press_rows");
  ASSERT_NE(at, std::string::npos);
  const std::size_t value = bytes.find("true", at);
  ASSERT_NE(value, std::string::npos);
  bytes.replace(value, 4, "yes!");
  folder_.write("crafted.h5", bytes);
  EXPECT_THROW(read_contact_set(folder_ / "crafted.h5"), ConfigError);
}

}  // namespace tactel::host::irregular_set_test
