// SPDX-License-Identifier: Apache-2.0

// Grips of a sweep file, [load.hold]: what they may be, and that a contact's is a function of seed and number alone.
#include "host/scenes/hold_load.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "tests/host/scenes/sweep_text.h"

namespace tactel::host::hold_load_test {

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

const std::string hand = head + fixed + "rate = 60\n";
/// `fixed` with other numbers under some of its keys.
std::string changed(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

/// The share of a signal's variance that lies at each frequency, by its sums with a sine and a cosine, 0.1 Hz apart.
double strongest_frequency(const std::vector<double>& signal, double rate) {
  double most = 0, at = 0;
  for (int k = 1; 0.1 * k < rate / 2; ++k) {
    const double frequency = 0.1 * k;
    double sine = 0, cosine = 0;
    for (std::size_t i = 0; i < signal.size(); ++i) {
      const double angle = 2 * std::numbers::pi * frequency / rate * static_cast<double>(i);
      sine += signal[i] * std::sin(angle), cosine += signal[i] * std::cos(angle);
    }
    if (const double power = sine * sine + cosine * cosine; power > most) most = power, at = frequency;
  }
  return at;
}

/// 990 frames: the mean square of a tone of 5 Hz or more is off by 1 / (4 pi 5 / 60 990) = 0.1 % at most.
TEST(HoldLoad, ATremorHasItsLineAndItsRms) {
  std::string text = changed(changed(hand, "moves = 2", "moves = 0"), "frames = 40", "frames = 1000");
  text = changed(text, "relax = 0.1", "relax = 0") + "tremor = 0.03\ntremor_share = 0.7\n";
  std::set<double> found;
  for (const std::uint64_t grip : {0, 1, 2}) {
    SCOPED_TRACE(grip);
    const Hold hold = pads(text).hold(grip);
    std::vector<double> x, y, P;
    double along = 0, of_P = 0, xx = 0, xy = 0, yy = 0;
    for (std::size_t k = 10; k < 1000; ++k) {
      const Hold::Frame& frame = hold.frames[k];
      x.push_back(frame.tremor[0]), y.push_back(frame.tremor[1]), P.push_back(frame.P - 1);
      xx += x.back() * x.back() / 990, xy += x.back() * y.back() / 990, yy += y.back() * y.back() / 990;
      of_P += P.back() * P.back() / 990;
    }
    along = (xx + yy) / 2 + std::hypot((xx - yy) / 2, xy);  // the larger principal variance
    EXPECT_NEAR(std::sqrt(xx + yy + of_P) / 0.03, 1, 0.01);
    EXPECT_NEAR(along / (0.03 * 0.03), 0.7, 0.02);
    EXPECT_NEAR(of_P / (0.03 * 0.03), 0.15, 0.01);
    for (const auto* signal : {&x, &y, &P}) {
      const double frequency = strongest_frequency(*signal, 60);
      EXPECT_GE(frequency, 4.9);
      EXPECT_LE(frequency, 12.1);
      found.insert(frequency);
    }
  }
  EXPECT_GT(found.size(), 4u) << "each tone draws its own";
  EXPECT_EQ(pads(text).hold(0).frames[3].tremor[0], 0) << "not while it presses by wrench";
  EXPECT_NEAR(strongest_frequency({0, 1, 0, -1, 0, 1, 0, -1}, 60), 15, 0.1) << "the witness itself";
}

/// The first move begins behind 8 + 5 frames, the second behind 2 + 3 more. A squeeze of 10 frames has reached its
/// ratio in the tenth.
TEST(HoldLoad, AHandSqueezesAndEases) {
  const std::string still = changed(hand, "relax = 0.1", "relax = 0");
  const auto P = [&](const std::string& more, std::size_t k) { return pads(still + more).hold(3).frames[k - 1].P; };
  const std::string tight = "squeeze = 3\nsqueeze_frames = 10\n";
  EXPECT_EQ(P(tight, 13), 1);
  EXPECT_NEAR(P(tight, 14), 1 + 2 * 0.028, 1e-12);
  EXPECT_NEAR(P(tight + "squeeze_start = -3\n", 11), 1 + 2 * 0.028, 1e-12);
  EXPECT_EQ(P(tight + "squeeze_start = 10\n", 23), 1);
  EXPECT_NEAR(P(tight + "squeeze_start = 10\n", 24), 1 + 2 * 0.028, 1e-12);
  EXPECT_NEAR(P(tight, 40), 9, 1e-12);
  EXPECT_NEAR(P("squeeze = 7\nsqueeze_frames = 2\n", 18), 7, 1e-12);
  EXPECT_NEAR(P("squeeze = 7\nsqueeze_frames = 2\n", 40), 10, 1e-12) << "not beyond ten times";
  EXPECT_NEAR(P("squeeze = 0.4\nsqueeze_frames = 2\n", 40), 0.2, 1e-12) << "nor below a fifth";
  const Hold alone = pads(still + tight + "squeeze_alone = 1\n").hold(3);
  EXPECT_NEAR(alone.frames[39].P, 9, 1e-12);
  for (std::size_t k = 8; k < 40; ++k) EXPECT_NEAR(alone.frames[k].load[1], 0.5, 1e-15) << "the object stays";
}

TEST(HoldLoad, ASwingTurnsToEitherSideAboutAPoint) {
  const std::string text =
      changed(hand, "moves = 2", "moves = 1") + "by = \"motion\"\nswing = 40\nswing_radius = 3\nroll = 0.2\n";
  const double degree = std::numbers::pi / 180;
  int left = 0;
  for (std::uint64_t grip = 0; grip < 40; ++grip) {
    const Hold hold = pads(text).hold(grip);
    EXPECT_EQ(hold.frames[12].swing, 0);
    EXPECT_NEAR(std::abs(hold.frames[13].swing), 20 * degree, 1e-12) << "halfway";
    EXPECT_NEAR(std::abs(hold.frames[39].swing), 40 * degree, 1e-12);
    EXPECT_NEAR(std::hypot(hold.pivot[0], hold.pivot[1]), 3, 1e-12);
    EXPECT_NEAR(std::hypot(hold.roll[0], hold.roll[1]), 0.2 / degree, 1e-12);
    left += hold.frames[39].swing > 0;
  }
  EXPECT_GT(left, 8);
  EXPECT_LT(left, 32);
  EXPECT_NEAR(pads(changed(text, "back = 0", "back = 1")).hold(0).frames[39].swing, 0, 1e-15);
}

TEST(HoldLoad, WeightsAddUp) {
  const Hold hold = pads(changed(hand, "size = 2", "size = 0") + "added_weight = 0.2\n").hold(5);
  EXPECT_NEAR(hold.frames[12].load[1], 0.5, 1e-15);
  EXPECT_NEAR(hold.frames[14].load[1], 0.7, 1e-15);
  EXPECT_NEAR(hold.frames[39].load[1], 0.9, 1e-15);
  EXPECT_NEAR(hold.frames[39].load[0], 0, 1e-15);
}

/// Down in 4 frames behind 8 + 5, open in 4 more, open for 3, closed in 4, lifted in 4.
TEST(HoldLoad, AHandGripsAgain) {
  const std::string text = changed(changed(hand, "moves = 2", "moves = 1"), "relax = 0.1", "relax = 0");
  const Hold hold = pads(text + "regrip = 1\nregrip_shift = 2\n").hold(5);
  const auto frame = [&](std::size_t k) { return hold.frames[k - 1]; };
  EXPECT_NEAR(frame(15).load[1], 0.25, 1e-15);
  EXPECT_NEAR(frame(17).load[1], 0, 1e-15);
  EXPECT_EQ(frame(17).P, 1);
  EXPECT_NEAR(frame(19).P, 0.5, 1e-15);
  EXPECT_EQ(std::hypot(frame(20).shift[0], frame(20).shift[1]), 0) << "it touches still";
  for (std::size_t k = 21; k <= 24; ++k) {
    EXPECT_EQ(frame(k).P, 0);
    EXPECT_NEAR(std::hypot(frame(k).shift[0], frame(k).shift[1]), 2, 1e-12);
  }
  EXPECT_NEAR(frame(26).P, 0.5, 1e-15);
  EXPECT_EQ(frame(28).P, 1);
  EXPECT_NEAR(frame(28).load[1], 0, 1e-15);
  EXPECT_NEAR(frame(32).load[1], 0.5, 1e-15);
}

TEST(HoldLoad, ARateAloneChangesNoFrame) {
  const Hold timed = pads(head + "rate = 60\n").hold(4), plain = pads(head).hold(4);
  for (std::size_t k = 0; k < plain.frames.size(); ++k) {
    ASSERT_EQ(timed.frames[k].P, plain.frames[k].P) << k;
    ASSERT_EQ(timed.frames[k].load, plain.frames[k].load) << k;
  }
  EXPECT_GT(pads(head + "rate = 60\n").numbers().size(), pads(head).numbers().size());
  const PadSource middle = pads(hand + "tremor = 0.02\nregrip = 1\n");
  const PadSource told = middle.of_quantiles(std::vector(middle.numbers().size(), 0.5));
  EXPECT_EQ(told.hold(0).frames[20].P, 0) << "a hand's numbers have quantiles, too";
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
  refuses("tremor = 0.1", "tremor", "given with load.hold.rate");
  refuses("regrip = 0.1", "regrip", "given with load.hold.rate");
  refuses("rate = 0", "rate", "1 to 100000");
  refuses("rate = 60\ntremor = 0.01\ntremor_frequency = { uniform = [5, 40] }", "tremor_frequency", "half the rate");
  refuses("rate = 60\nsqueeze = 0", "squeeze", "0.1 to 10");
  refuses("rate = 60\nswing = 20", "swing", "given with by = \"motion\"");
  refuses("rate = 60\nby = \"motion\"\nadded_weight = 0.1", "added_weight", "given with by = \"force\"");
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
  EXPECT_THAT(message_of<PadSource>(rubber + "young = 1\n[load]\nnormal_force = 2\n[load.hold]\n"),
              AllOf(HasSubstr("indenter.young"), HasSubstr("left out with [load.hold]")));
  for (const auto& [map, words] :
       {std::pair{"[[0.5]]", "left out with [load.hold]"}, {"[[{ uniform = [0.1, 0.5] }]]", "must be a plain value"}})
    EXPECT_THAT(message_of<PadSource>(head + "[contact]\nfriction_pitch = 1\nfriction_map = " + map + "\n"),
                AllOf(HasSubstr("contact.friction_map"), HasSubstr(words)));
  std::string creeping = head;
  creeping.insert(creeping.find("thickness = 4"), "relaxation = [[0.2, 0.5]]\n");
  EXPECT_THAT(message_of<PadSource>(creeping),
              AllOf(HasSubstr("sensor.relaxation"), HasSubstr("one [load.hold] rate")));
  using Terms = std::vector<std::array<double, 2>>;
  EXPECT_EQ(pads(creeping + "rate = 60\n").contact(1).scene.sensor.relaxation, (Terms{{0.2, 0.5}}));
  std::string own = head;
  own.replace(own.find("thickness = 4"), 13, "thickness = { uniform = [3, 5] }");
  EXPECT_THAT(message_of<PadSource>(own), AllOf(HasSubstr("sweep.sensors"), HasSubstr("which grips share")));
}

}  // namespace tactel::host::hold_load_test
