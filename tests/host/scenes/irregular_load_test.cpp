// SPDX-License-Identifier: Apache-2.0

// Irregular load paths of a sweep file: what they may be, and that a contact's is a function of seed and number alone.
#include "host/scenes/irregular_load.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/scenes/scene_source.h"
#include "tests/host/scenes/sweep_text.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::irregular_load_test {

using testing::AllOf;
using testing::Ge;
using testing::HasSubstr;
using testing::Le;

const std::string head =
    "[sweep]\ncontacts = 300\nseed = 7\n[indenter]\nshape = \"parabola\"\nradius = 10\n"
    "[load]\nindentation = { uniform = [0.05, 0.2] }\n";

std::vector<fem::LoadStep> path(const SceneSource& sweep, std::uint64_t k) {
  return fem::load_path(sweep.contact(k).scene.load).steps;
}

/// Every number fixed: two presses of depth d and d / 2, each with one stroke of 0.1 mm; only the sizes are random.
TEST(IrregularLoad, FixedNumbersGiveThePathWorkedByHand) {
  const SceneSource sweep = source(head +
                                   "[load.irregular]\npresses = 2\npress_depth = 0.5\npress_steps = 3\nstrokes = 2\n"
                                   "stroke = 0.1\nstroke_steps = 4\nreversal = 1\nrelease = 1\nrelease_to = 0.25\n"
                                   "release_steps = 2\n");
  const fem::Load load = sweep.contact(5).scene.load;
  EXPECT_EQ(load.indentation.size(), 3u);
  EXPECT_EQ(load.indentation_steps, 1);
  const double depth = load.indentation.back();
  const auto steps = path(sweep, 5);
  // a press of 3; 2 + 4 and 2 + 4 of its strokes; 3 of the release; again 3, 6 and 6
  ASSERT_EQ(steps.size(), 3u + 6 + 6 + 3 + 3 + 6 + 6);
  const auto at = [&](std::size_t k) { return std::pair(steps[k - 1].normal, steps[k - 1].tangential); };
  EXPECT_EQ(at(3), std::pair(depth, 0.0));
  EXPECT_EQ(at(5), std::pair(0.25 * depth, 0.0));
  EXPECT_EQ(at(9), std::pair(0.25 * depth, 0.1));
  EXPECT_EQ(at(11), std::pair(0.25 * depth, 0.1));  // a release to where it is
  EXPECT_EQ(at(15), std::pair(0.25 * depth, 0.0));  // the second stroke goes back
  EXPECT_EQ(at(18), std::pair(0.0, 0.0));
  EXPECT_EQ(at(21), std::pair(0.5 * depth, 0.0));
  EXPECT_EQ(at(23), std::pair(0.125 * depth, 0.0));
  EXPECT_EQ(at(27), std::pair(0.125 * depth, 0.1));
  EXPECT_EQ(at(33), std::pair(0.125 * depth, 0.0));
}

const std::string random =
    "[load.irregular]\npresses = { choice = [1, 2] }\npress_steps = { uniform = [2, 5] }\nstrokes = { uniform = [1, 3] "
    "}\n"
    "stroke = { log_uniform = [0.05, 0.3] }\nstroke_steps = { uniform = [2, 6] }\nbackward = 0.5\nreversal = 0.3\n"
    "pause = 0.2\nrelease = 0.3\nrelease_to = { uniform = [0.5, 0.8] }\n";

// 300 paths of some 15 steps: a share of 0.5 (or 0.2) spreads by 0.03 at most, four of these.
TEST(IrregularLoad, NumbersAndSizesOfStepsVaryWithinTheirBounds) {
  const SceneSource sweep = source(head + random);
  int forward = 0, pauses = 0, drags = 0;
  std::set<std::size_t> lengths;
  for (std::uint64_t k = 0; k < 300; ++k) {
    const fem::Load load = sweep.contact(k).scene.load;
    const double depth = load.indentation.back();
    EXPECT_THAT(load.indentation.size(), AllOf(Ge(2u), Le(5u)));
    EXPECT_THAT(depth, AllOf(Ge(0.05), Le(0.2)));
    for (std::size_t i = 1; i < load.indentation.size(); ++i) EXPECT_GT(load.indentation[i], load.indentation[i - 1]);
    const auto steps = path(sweep, k);
    lengths.insert(steps.size());
    bool first = true;
    for (std::size_t i = load.indentation.size(); i < steps.size(); ++i) {
      EXPECT_THAT(steps[i].normal, AllOf(Ge(0), Le(depth)));
      const double moved = steps[i].tangential - steps[i - 1].tangential;
      EXPECT_LT(std::abs(moved), 0.3);
      const bool pause = steps[i] == steps[i - 1];
      if (moved != 0 && first) forward += moved > 0, first = false;
      drags += moved != 0, pauses += pause;
    }
  }
  EXPECT_GT(lengths.size(), 15u);
  EXPECT_NEAR(forward / 300.0, 0.5, 0.12);
  EXPECT_NEAR(pauses / static_cast<double>(drags), 0.2, 0.03);
}

TEST(IrregularLoad, DependsOnSeedAndNumberAlone) {
  const SceneSource sweep = source(head + random), again = source(head + random);
  const SceneSource other = source(std::string(head).replace(head.find("seed = 7"), 8, "seed = 8") + random);
  EXPECT_EQ(path(again, 123), path(sweep, 123));  // after others or alone
  EXPECT_NE(path(sweep, 124), path(sweep, 123));
  EXPECT_NE(path(other, 123), path(sweep, 123));
  // and changes no number of the contact that it would draw without one
  const SceneSource plain = source(head);
  EXPECT_EQ(plain.contact(9).scene.load.indentation.back(), sweep.contact(9).scene.load.indentation.back());
}

TEST(IrregularLoad, GoesWithForcesAndSeveralTables) {
  const SceneSource sweep = source(
      "[sweep]\ncontacts = 100\n[indenter]\nshape = \"parabola\"\nradius = 10\n[[load]]\nnormal_force = 0.5\n"
      "[load.irregular]\nstrokes = 3\n[[load]]\nindentation = 0.1\ntangential_step = 0.01\ntangential_steps = 2\n");
  int irregular = 0;
  for (std::uint64_t k = 0; k < 100; ++k) {
    const fem::Load load = sweep.contact(k).scene.load;
    if (load.normal_force.empty()) continue;
    ++irregular;
    EXPECT_EQ(load.normal_force.back(), 0.5);
    EXPECT_EQ(load.moves.size(), 18u);
    for (const fem::LoadStep& step : fem::load_path(load).steps) EXPECT_TRUE(step.normal_is_force);
  }
  EXPECT_NEAR(irregular, 50, 20);  // four standard deviations
}

TEST(IrregularLoad, RefusesWithPlaceKeyAndWhatIsAllowed) {
  const auto refuses = [](const std::string& keys, const std::string& key, const std::string& allowed) {
    const std::string message = message_of(head + "[load.irregular]\n" + keys);
    EXPECT_THAT(message, AllOf(HasSubstr("sweep.toml"), HasSubstr("load.irregular" + key), HasSubstr(allowed)));
  };
  refuses("stroke = -0.1", ".stroke", "0 or more");
  refuses("stroke = { uniform = [-0.1, 0.2] }", ".stroke", "0 or more");
  refuses("stroke = \"long\"", ".stroke", "a length in mm");
  refuses("stroke_steps = 0", ".stroke_steps", "1 to 100");
  refuses("presses = { choice = [0, 1] }", ".presses", "1 to 100");
  refuses("pause = 1.5", ".pause", "a probability, 0 to 1");
  refuses("reversal = { uniform = [0, 1] }", ".reversal", "a probability, 0 to 1");
  refuses("release_to = 2.5", ".release_to", "0 to 2");
  refuses("strokes = 100\nstroke_steps = 100", "", "at most 1000 load steps");
  refuses("stokes = 2", ".stokes", "strokes");
  EXPECT_THAT(message_of(head + "tangential_step = 0.1\n[load.irregular]\nstrokes = 2"),
              AllOf(HasSubstr("load.tangential_step"), HasSubstr("left out")));
  EXPECT_THAT(message_of(head + "irregular = 3"), HasSubstr("a table"));
  EXPECT_THAT(message_of("[sweep]\ncontacts = 3\n[indenter]\nshape = \"flat\"\nhalf_width = 2\n[load]\nindentation = "
                         "[0.1, 0.2]\n[load.irregular]\nstrokes = 2"),
              HasSubstr("one indentation or normal_force"));
  EXPECT_THAT(message_of("[sweep]\ncontacts = 3\npress_rows = 1\n" + head.substr(head.find("[indenter]"))),
              AllOf(HasSubstr("sweep.press_rows"), HasSubstr("true")));
}

/// A path deeper than the rubber is thick is the contact's error.
TEST(IrregularLoad, NamesTheContactWhoseNumbersContradict) {
  const SceneSource sweep = source(
      "[sweep]\ncontacts = 3\n[indenter]\nshape = \"parabola\"\nradius = 10\n[load]\nindentation = 1.2\n"
      "[load.irregular]\nrelease = 1\nrelease_to = 1.5\nrelease_steps = 1\n");
  EXPECT_THAT([&] { sweep.contact(2); }, testing::ThrowsMessage<ValueError>(
                                             AllOf(HasSubstr("below the rubber's thickness"), HasSubstr("contact 2"))));
}

}  // namespace tactel::host::irregular_load_test
