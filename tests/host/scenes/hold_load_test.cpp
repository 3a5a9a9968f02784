// SPDX-License-Identifier: Apache-2.0

// Grips of a sweep file, [load.hold]: what they may be, and that a contact's is a function of seed and number alone.
#include "host/scenes/hold_load.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/host/scenes/sweep_text.h"

namespace tactel::host {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string rubber =
    "[sweep]\ncontacts = 300\nseed = 7\n[sensor]\nkind = \"pad\"\nthickness = 4\n"
    "[indenter]\nshape = \"box\"\nhalf_widths = [15, 15]\n";
const std::string head = rubber + "[load]\nnormal_force = { log_uniform = [3, 25] }\n[load.hold]\n";

constexpr const char* fixed =
    "frames = 40\npress = 8\nweight = 0.5\ndirection = 90\nrest = 5\nmoves = 2\nsize = 2\nturn = 0\nmove_frames = 2\n"
    "pause = 3\nback = 0\nrelax = 0.1\n";

/// Pressed in 4 frames, the weight in 4 more; a move of 2 behind 5 of rest. Halfway a smooth step is at a half.
TEST(HoldLoad, FixedNumbersGiveThePathWorkedByHand) {
  const Hold hold = pads(head + fixed).hold(11);
  ASSERT_EQ(hold.frames.size(), 40u);
  EXPECT_EQ(hold.pressing(), 4);
  EXPECT_FALSE(hold.by_motion);
  const auto y = [&](std::size_t k) { return hold.frames[k - 1].load[1]; };
  EXPECT_EQ(hold.frames[1].P, 0.5);
  EXPECT_EQ(hold.frames[3].P, 1);
  EXPECT_EQ(y(4), 0);
  EXPECT_NEAR(y(6), 0.25, 1e-15);
  EXPECT_NEAR(y(8), 0.5, 1e-15);
  EXPECT_NEAR(y(13), 0.5, 1e-15);
  EXPECT_NEAR(y(14), 1.5, 1e-15);
  EXPECT_NEAR(y(15), 2.5, 1e-15);
  EXPECT_NEAR(y(20), 2.5, 1e-15) << "by force the second move begins at the weight, and leads to where the first did";
  EXPECT_NEAR(y(40), 2.5, 1e-15);
  EXPECT_NEAR(hold.frames[39].P, 1 - 0.1 * (1 - std::exp(-31 / (32 / 3.0))), 1e-12);
  EXPECT_TRUE(hold.face.waves.empty());
  const Hold moved = pads(head + "by = \"motion\"\n" + fixed).hold(11);
  EXPECT_NEAR(moved.frames[39].load[1], 4.5, 1e-15) << "by motion one goes on from the other";
  std::string back = fixed;
  back.replace(back.find("back = 0"), 8, "back = 1");
  EXPECT_NEAR(pads(head + back).hold(11).frames[39].load[1], 0.5, 1e-15);
}

TEST(HoldLoad, APartOfAMoveTurns) {
  std::string text = fixed;
  text.replace(text.find("turn = 0"), 8, "turn = -0.6");
  const auto load = pads(head + text).hold(0).frames[39].load;
  EXPECT_NEAR(load[1], 0.5 + 2 * 0.8, 1e-15);
  EXPECT_NEAR(load[2], -2 * 0.6, 1e-15);
}

TEST(HoldLoad, DependsOnSeedAndNumberAlone) {
  const std::string uneven =
      "unevenness = { rms = { log_uniform = [0.01, 0.1] }, length = { uniform = [3, 8] } }\n[load]";
  std::string text = head;
  text.replace(text.find("[load]"), 6, uneven);
  const PadSource sweep = pads(text), again = pads(text);
  const auto same = [](const Hold& a, const Hold& b) {
    return a.rms == b.rms && a.tilt == b.tilt && a.frames.back().load == b.frames.back().load &&
           a.face.height(1, 2) == b.face.height(1, 2);
  };
  sweep.hold(3);
  EXPECT_TRUE(same(sweep.hold(20), again.hold(20)));
  EXPECT_FALSE(same(sweep.hold(20), sweep.hold(21)));
  EXPECT_EQ(sweep.contact(9).scene.load.normal_force, pads(head).contact(9).scene.load.normal_force)
      << "a face changes no other number";
  EXPECT_EQ(sweep.hold(9).frames.back().load, pads(head).hold(9).frames.back().load);
}

TEST(HoldLoad, RefusesWithPlaceKeyAndWhatIsAllowed) {
  const auto refuses = [](const std::string& keys, const std::string& key, const std::string& allowed) {
    EXPECT_THAT(message_of<PadSource>(head + keys),
                AllOf(HasSubstr("sweep.toml:"), HasSubstr("load.hold." + key), HasSubstr(allowed)));
  };
  refuses("frames = 5", "frames", "20 to 1000");
  refuses("press = 400", "press", "load.hold.frames");
  refuses("by = \"hand\"", "by", "\"force\" or \"motion\"");
  refuses("size = -1", "size", "0 to 100");
  refuses("turn = { uniform = [0, 2] }", "turn", "-1 to 1");
  refuses("back = 2", "back", "a probability, 0 to 1");
  refuses("sise = 2", "sise", "did you mean size?");
  EXPECT_THAT(message_of<PadSource>(rubber + "[load]\nindentation = 0.2\n[load.hold]\n"),
              AllOf(HasSubstr("load.hold"), HasSubstr("one normal_force, in N")));
  EXPECT_THAT(message_of<PadSource>(rubber + "[load]\nnormal_force = 2\ntwist = [3]\n[load.hold]\n"),
              AllOf(HasSubstr("load.twist"), HasSubstr("left out, because load.hold is given too")));
  EXPECT_THAT(message_of<PadSource>(rubber + "[[load]]\nnormal_force = 2\n[load.hold]\n[[load]]\nnormal_force = 2\n"),
              AllOf(HasSubstr("load.hold"), HasSubstr("in every [[load]], or in none")));
  EXPECT_THAT(message_of<PadSource>(rubber + "unevenness = { rms = 0.1, length = 3 }\n[load]\nnormal_force = 2\n"),
              AllOf(HasSubstr("indenter.unevenness"), HasSubstr("[load.hold]")));
  EXPECT_THAT(message_of<PadSource>(rubber + "unevenness = 0.1\n[load]\nnormal_force = 2\n[load.hold]\n"),
              AllOf(HasSubstr("indenter.unevenness"), HasSubstr("{ rms = ..., length = ... }")));
  std::string own = head;
  own.replace(own.find("thickness = 4"), 13, "thickness = { uniform = [3, 5] }");
  EXPECT_THAT(message_of<PadSource>(own), AllOf(HasSubstr("sweep.sensors"), HasSubstr("which grips share")));
}

}  // namespace
}  // namespace tactel::host
