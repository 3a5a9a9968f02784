// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <tactel/infer.h>

#include <cmath>
#include <random>

#include "nn/infer/network_file.h"
#include "tests/host/live/shear_network.h"
#include "tests/host/networks/bounded_model.h"
#include "tests/thrown_message.h"

namespace tactel::alarm_test {

using ::testing::HasSubstr;
using ::testing::IsNan;

SlipEstimator estimator_of(const nn::Model& model) {
  const std::string file = infer::network_bytes(model);
  return SlipEstimator::parse(std::as_bytes(std::span(file)));
}

AlarmAnswer answer_of(float s, float width = 0) {
  return {.answer = {s, s, AnswerStatus::ok, {s - width, s}, 0, 0, {}}};
}

// Begins at the threshold, holds down to 0.05 below it and over a frame without answer, and begins again at it alone.
TEST(Alarm, HasHysteresis) {
  Alarm alarm(estimator_of(shear_network()), {.at = 0.8f});
  const float values[] = {0.5f, 0.79f, 0.8f, 0.76f, NAN, 0.751f, 0.74f, 0.79f, 1.0f, NAN, 0.1f};
  const bool on[] = {false, false, true, true, true, true, false, false, true, true, false};
  for (std::size_t i = 0; i < std::size(values); ++i) EXPECT_EQ(alarm.judge(answer_of(values[i])).on, on[i]) << i;
}

// Intervals of at most 0.5 begin an alarm; it goes on at wider ones. A wide one above the threshold cannot tell.
TEST(Alarm, AWideIntervalCannotTell) {
  const auto bounded = tests::bounded_model("8-6-3", nn::ScalingKind::frame);
  Alarm alarm(estimator_of(bounded), {.at = 0.8f, .widest = 0.5f});
  const float values[] = {0.875f, 0.875f, 0.875f, 0.6875f, 0.875f, 0.5f, 0.875f};
  const float widths[] = {0.625f, 0.5f, 0.625f, 0.625f, NAN, 0.875f, 0.25f};
  const bool on[] = {false, true, true, false, false, false, true};
  const bool cannot_tell[] = {true, false, false, false, true, false, false};
  for (std::size_t i = 0; i < std::size(values); ++i) {
    const AlarmAnswer judged = alarm.judge(answer_of(values[i], widths[i]));
    EXPECT_EQ(judged.on, on[i]) << i;
    EXPECT_EQ(judged.cannot_tell, cannot_tell[i]) << i;
  }
}

// By the network above: S of each frame is known, and touch looks at the two normal stresses alone.
TEST(Alarm, JudgesFramesOfLinesAndPads) {
  for (const int axes : {2, 3}) {
    const SlipEstimator network = estimator_of(shear_network(axes));
    EXPECT_EQ(network.tactels(), 2u);
    EXPECT_FALSE(network.has_bound());
    Alarm alarm(network, {.at = 0.8f, .touch = 0.1});
    ASSERT_EQ(alarm.inputs(), static_cast<std::size_t>(2 * axes));
    const auto next = [&](float normal, float s) {
      std::vector<float> frame(alarm.inputs());
      frame[1] = normal, frame[2] = shear_of(s);
      return alarm.next(frame);
    };
    const AlarmAnswer below = next(-0.2f, 0.7f);
    EXPECT_NEAR(below.answer.slip_index, 0.7f, 1e-6);
    EXPECT_EQ(below.acted_on, below.answer.slip_index);
    EXPECT_TRUE(std::isnan(below.answer.slip_upper));
    EXPECT_EQ(below.contact, true);
    EXPECT_FALSE(below.on);
    EXPECT_TRUE(next(-0.2f, 0.81f).on);
    EXPECT_TRUE(next(-0.2f, 0.76f).on);
    const AlarmAnswer nothing = next(-0.2f, NAN);
    EXPECT_EQ(nothing.answer.status, AnswerStatus::not_finite);
    EXPECT_EQ(nothing.contact, true);
    EXPECT_TRUE(nothing.on);
    EXPECT_TRUE(nothing.cannot_tell);
    const AlarmAnswer short_of = alarm.next(std::vector<float>(3));
    EXPECT_EQ(short_of.answer.status, AnswerStatus::wrong_size);
    EXPECT_EQ(short_of.contact, std::nullopt);
    EXPECT_TRUE(short_of.on);
    const AlarmAnswer released = next(-0.0999f, 0.9f);
    EXPECT_EQ(released.contact, false);
    EXPECT_THAT(released.answer.slip_index, IsNan());
    EXPECT_EQ(released.acted_on, 0);
    EXPECT_FALSE(released.on);
    EXPECT_TRUE(next(0.1f, 0.9f).on) << "a pull of 0.1 MPa touches";
  }
}

// What is unlike the learning set asks for the alarm, whatever its S, and an S below ends it; `ignore_unlike` leaves it
// to S. Both say that it cannot tell. Without contact there is nothing to tell.
TEST(Alarm, AnUnlikeFrameCannotTell) {
  const SlipEstimator network = estimator_of(tests::bounded_model("8-6-3", nn::ScalingKind::frame));
  Alarm alarm(network, {.at = 0.8f}), ignoring(network, {.at = 0.8f, .ignore_unlike = true}),
      never(network, {.at = INFINITY});
  const float values[] = {0.1f, 0.1f, 0.1f, 0.9f, 0.1f};
  const bool unlike[] = {false, true, false, true, false};
  for (std::size_t i = 0; i < std::size(values); ++i) {
    AlarmAnswer answer = answer_of(values[i]);
    answer.answer.unlike = unlike[i];
    const AlarmAnswer judged = alarm.judge(answer);
    EXPECT_EQ(judged.on, unlike[i]) << i;
    EXPECT_EQ(judged.cannot_tell, unlike[i]) << i;
    EXPECT_EQ(ignoring.judge(answer).on, values[i] > 0.8f) << i;
    EXPECT_EQ(ignoring.judge(answer).cannot_tell, unlike[i]) << i;
    EXPECT_FALSE(never.judge(answer).on);
    EXPECT_EQ(never.judge(answer).cannot_tell, unlike[i]) << i;
    answer.contact = false;
    EXPECT_FALSE(alarm.judge(answer).on || alarm.judge(answer).cannot_tell) << i;
  }
}

// Three frames in a row: a lower one begins the row anew, one without an answer leaves it. It ends at once.
TEST(Alarm, BeginsAfterFramesInARow) {
  Alarm alarm(estimator_of(shear_network()), {.at = 0.8f, .hold = 3});
  const float values[] = {0.9f, 0.9f, 0.78f, 0.9f, NAN, 0.9f, 0.9f, 0.9f, NAN, 0.1f, 0.9f};
  const bool on[] = {false, false, false, false, false, false, true, true, true, false, false};
  for (std::size_t i = 0; i < std::size(values); ++i) {
    const AlarmAnswer judged = alarm.judge(answer_of(values[i]));
    EXPECT_EQ(judged.on, on[i]) << i;
    EXPECT_EQ(judged.cannot_tell, std::isnan(values[i])) << i;
  }
  alarm.judge(answer_of(0.9f));
  alarm.clear();
  EXPECT_FALSE(alarm.judge(answer_of(0.9f)).on) << "the first after clear()";
}

// Peaks of 0.1 to 2 MPa were learnt: below there is no contact, unless touch says so; above 20 MPa the answer says it.
TEST(Alarm, KnowsThePeaksThatItsNetworkLearnt) {
  nn::Model model = shear_network();
  model.learnt = {.smallest_peak = 0.1f, .largest_peak = 2};
  const SlipEstimator network = estimator_of(model);
  EXPECT_EQ(network.smallest_peak(), 0.1f);
  Alarm alarm(network, {.at = 0.8f}), all(network, {.at = 0.8f, .touch = 0}),
      light(network, {.at = 0.8f, .touch = 0.01});
  const auto frame = [](float normal) { return std::vector<float>{0, normal, shear_of(0.9f), 0}; };
  EXPECT_EQ(alarm.next(frame(-0.09f)).contact, false);
  EXPECT_FALSE(alarm.next(frame(-0.09f)).on);
  EXPECT_TRUE(alarm.next(frame(-0.11f)).on);
  EXPECT_EQ(all.next(frame(-0.09f)).contact, std::nullopt);
  EXPECT_EQ(light.next(frame(-0.09f)).contact, true);
  EXPECT_EQ(alarm.next(frame(-19.9f)).answer.beyond_learnt, 0u);
  EXPECT_EQ(alarm.next(frame(20.1f)).answer.beyond_learnt, 1u);
  EXPECT_EQ(network.estimate(frame(-20.1f)).beyond_learnt, 1u);
  EXPECT_EQ(network.estimate(frame(NAN)).beyond_learnt, 0u);
  EXPECT_EQ(estimator_of(shear_network()).estimate(frame(-1e9f)).beyond_learnt, 0u) << "nothing is known";
  EXPECT_EQ(estimator_of(shear_network()).smallest_peak(), 0);
}

// S is that of SlipHistory; answer() alone keeps the alarm off; clear() forgets alarm and frames.
TEST(Alarm, TakesAHistory) {
  nn::Model model = shear_network(2, 2);
  model.weights.values[6] = 1;  // the shear of the frame before counts, too
  const SlipEstimator network = estimator_of(model);
  SlipHistory history(network);
  Alarm alarm(network, {.at = 0.8f});
  const auto frame = [](float shear) { return std::vector<float>{-1, -1, shear, 0}; };
  const float high = shear_of(0.9f), held = shear_of(0.77f);
  EXPECT_EQ(alarm.answer(frame(high)).answer.slip_index, history.estimate(frame(high)).slip_index);
  const AlarmAnswer second = alarm.next(frame(held - high));
  EXPECT_NEAR(second.answer.slip_index, 0.77f, 1e-6) << "the sum of both shears";
  EXPECT_EQ(second.answer.slip_index, history.estimate(frame(held - high)).slip_index);
  EXPECT_FALSE(second.on) << "0.77 would hold an alarm";
  EXPECT_TRUE(alarm.next(frame(2 * high)).on);
  alarm.clear();
  const AlarmAnswer again = alarm.next(frame(held));
  EXPECT_NEAR(again.answer.slip_index, 0.77f, 1e-6) << "no frame is before it";
  EXPECT_FALSE(again.on);
  EXPECT_EQ(again.contact, std::nullopt);
}

/// A frame of two tactels with two axes: normal stresses, then shear.
std::vector<float> grip(float normal, float other, float shear = 0) { return {-normal, -other, shear, 0}; }

/// Lets the alarm find the rest of a grip at (0.3, 0.1) MPa, P = 0.4.
void rest_at_a_grip(Alarm& alarm) {
  for (int i = 0; i < 10; ++i) EXPECT_EQ(alarm.next(grip(0.3f, 0.1f)).rest, i == 9) << i;
}

// Differences of 0.012 and 0.016 MPa have the norm 0.02, over P = 0.4: 0.05. It begins there, and ends below 0.05
// / 1.2.
TEST(Alarm, MovedIsTheChangeSinceRest) {
  Alarm alarm(2, 2, {.at = 0.0499f, .touch = 0.01, .signal = AlarmSignal::moved});
  ASSERT_EQ(alarm.inputs(), 4u);
  EXPECT_EQ(alarm.next(grip(0.005f, 0)).contact, false);
  EXPECT_TRUE(alarm.next(grip(0.3f, 0.1f)).cannot_tell) << "no rest is known yet";
  alarm.clear();
  rest_at_a_grip(alarm);
  EXPECT_NEAR(alarm.next(grip(0.3f, 0.1f)).moved, 0, 1e-7);
  const AlarmAnswer said = alarm.next(grip(0.3f - 0.012f, 0.1f, 0.016f));
  EXPECT_NEAR(said.moved, 0.05, 1e-6);
  EXPECT_EQ(said.acted_on, said.moved);
  EXPECT_TRUE(said.on);
  EXPECT_FALSE(said.cannot_tell);
  EXPECT_THAT(said.answer.slip_index, IsNan());
  EXPECT_TRUE(alarm.next(grip(0.3f, 0.1f, 0.0168f)).on) << "0.042 is above 0.0499 / 1.2 = 0.0416";
  EXPECT_FALSE(alarm.next(grip(0.3f, 0.1f, 0.0164f)).on) << "0.041 is below";
}

// A NaN and a frame of another size leave rest and alarm.
TEST(Alarm, AFrameWithoutAnAnswerLeavesTheRest) {
  Alarm alarm(2, 2, {.at = 0.05f, .touch = 0.01, .signal = AlarmSignal::moved});
  for (int i = 0; i < 5; ++i) alarm.next(grip(0.3f, 0.1f));
  EXPECT_EQ(alarm.next(grip(0.3f, NAN)).answer.status, AnswerStatus::not_finite);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(alarm.next(grip(0.3f, 0.1f)).rest, i == 4) << i;
  EXPECT_TRUE(alarm.next(grip(0.3f, 0.1f, 0.04f)).on);
  const AlarmAnswer nothing = alarm.next(grip(0.3f, 0.1f, NAN));
  EXPECT_TRUE(nothing.on && nothing.cannot_tell && nothing.rest == true);
  EXPECT_THAT(nothing.moved, IsNan());
  EXPECT_TRUE(alarm.next(std::vector<float>(3)).on);
  EXPECT_FALSE(alarm.next(grip(0.3f, 0.1f)).on);
}

// Each press has 200 frames to 0.4 MPa and is silent; rest comes when nothing moved for a quarter as long. Three frames
// without contact in a row are a release, two are not.
TEST(Alarm, TouchDownIsSilentAndARegripRestsAnew) {
  Alarm alarm(2, 2, {.at = 0.03f, .touch = 0.01, .signal = AlarmSignal::moved});
  for (const float most : {0.4f, 0.2f}) {
    int rest = 0;
    for (int i = 1; i <= 500; ++i) {
      const float normal = most * static_cast<float>(std::min(i, 200)) / 200;
      const AlarmAnswer said = alarm.next(grip(normal, normal / 3));
      EXPECT_FALSE(said.on) << i;
      EXPECT_EQ(std::isnan(said.moved), said.rest == false) << i;
      if (said.rest == true && rest == 0) rest = i;
    }
    EXPECT_GT(rest, 230);
    EXPECT_LT(rest, 260);
    EXPECT_TRUE(alarm.next(grip(most, most / 3, 0.1f)).on);
    for (int i = 0; i < 2; ++i) EXPECT_FALSE(alarm.next(grip(0, 0)).on);
    EXPECT_EQ(alarm.next(grip(most, most / 3)).rest, true);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(alarm.next(grip(0, 0)).rest, i < 2);
  }
}

// A frame without contact is a release where a lighter touch follows, and a loss of readings where the grip does.
TEST(Alarm, AReleaseOfOneFrameIsALighterTouch) {
  Alarm alarm(2, 2, {.at = 0.03f, .touch = 0.01, .signal = AlarmSignal::moved});
  rest_at_a_grip(alarm);
  alarm.next(grip(0, 0));
  EXPECT_EQ(alarm.next(grip(0.3f, 0.1f)).rest, true);
  alarm.next(grip(0, 0));
  EXPECT_EQ(alarm.next(grip(0.12f, 0.04f)).rest, false);
  EXPECT_FALSE(alarm.next(grip(0.3f, 0.1f, 0.1f)).on);
}

// P of 0.4 MPa doubles: it is another grip, whose rest is 0.9 MPa.
TEST(Alarm, ATighterGripRestsAnew) {
  Alarm alarm(2, 2, {.at = 0.03f, .touch = 0.01, .signal = AlarmSignal::moved});
  rest_at_a_grip(alarm);
  EXPECT_TRUE(alarm.next(grip(0.45f, 0.15f)).on);
  EXPECT_FALSE(alarm.next(grip(0.675f, 0.225f)).on) << "no rest of this grip is known";
  for (int i = 0; i < 20; ++i) alarm.next(grip(0.675f, 0.225f));
  EXPECT_NEAR(alarm.next(grip(0.675f, 0.225f, 0.045f)).moved, 0.05, 1e-6);
}

TEST(Alarm, RestIsSoughtAnewByACall) {
  Alarm alarm(2, 2, {.at = 0.03f, .touch = 0.01, .signal = AlarmSignal::moved});
  rest_at_a_grip(alarm);
  EXPECT_TRUE(alarm.next(grip(0.3f, 0.1f, 0.08f)).on);
  alarm.rest();
  for (int i = 0; i < 10; ++i) {
    const AlarmAnswer said = alarm.next(grip(0.3f, 0.1f, 0.08f));
    EXPECT_FALSE(said.on);
    EXPECT_EQ(said.rest, i == 9) << i;
  }
  EXPECT_NEAR(alarm.next(grip(0.3f, 0.1f, 0.06f)).moved, 0.05, 1e-6);
}

// White noise of 1 % of P on each stress, far above 1 % of P together, hides no rest; its mean is that of the frames.
TEST(Alarm, NoiseIsNoMotion) {
  Alarm alarm(16, 3, {.at = 0.4f, .touch = 0.001, .signal = AlarmSignal::moved});
  std::mt19937 random(4);
  std::normal_distribution<float> noise(0, 0.004f);
  std::vector<float> frame(48);
  float largest = 0;
  for (int i = 0; i < 200; ++i) {
    for (std::size_t k = 0; k < 48; ++k) frame[k] = (k < 16 ? -0.025f : 0.0f) + noise(random);
    const AlarmAnswer said = alarm.next(frame);
    EXPECT_TRUE(i < 30 || said.rest == true) << i;
    if (said.rest == true) largest = std::max(largest, said.moved);
  }
  EXPECT_LT(largest, 0.12f);  // sqrt(48 1.1) 1 % is 0.073, and its spread a tenth of that
}

/// Answers 1 / (1 + exp(-10 shear / P)) of the change of the first tactel's shear since rest; its file has an alarm at
/// 0.75.
nn::Model slid_network() {
  nn::Model model = shear_network();
  model.scaling.kind = nn::ScalingKind::rest, model.scaling.history = model.history.frames = 2;
  model.history.rest = true, model.target = nn::Target::slid;
  model.learnt = {.smallest_peak = 0.01f, .largest_peak = 1, .alarm_at = 0.75f};
  return model;
}

// P at rest is 0.4 MPa: a change of shear by 0.04 ln 3 is an answer of 0.75, and it ends at 0.75 / 1.2 = 0.625, 0.0204
// MPa. The shear of 0.1 MPa at rest is none. Before the rest is found there is no answer, and no alarm.
TEST(Alarm, ANetworkByTheRestHasAThresholdOfItsOwn) {
  const SlipEstimator network = estimator_of(slid_network());
  EXPECT_TRUE(network.needs_rest());
  EXPECT_EQ(network.alarm_at(), 0.75f);
  EXPECT_EQ(network.inputs(), 8u);
  Alarm alarm(network);
  ASSERT_EQ(alarm.inputs(), 4u);
  EXPECT_EQ(alarm.next(grip(0.005f, 0)).contact, false);
  for (int i = 0; i < 10; ++i) {
    const AlarmAnswer said = alarm.next(grip(0.3f, 0.1f, 0.1f));
    EXPECT_EQ(said.rest, i == 9);
    EXPECT_EQ(said.cannot_tell, i < 9);
    EXPECT_EQ(std::isnan(said.answer.slip_index), i < 9);
    EXPECT_FALSE(said.on);
  }
  const auto slides = [&](float shear) { return alarm.next(grip(0.3f, 0.1f, 0.1f + shear)); };
  EXPECT_NEAR(slides(0.02f).answer.slip_index, 1 / (1 + std::exp(-0.5)), 1e-6);
  EXPECT_FALSE(slides(0.043f).on);
  EXPECT_TRUE(slides(0.045f).on);
  EXPECT_TRUE(slides(0.021f).on);
  EXPECT_FALSE(slides(0.02f).on);
  EXPECT_TRUE(slides(0.045f).on);
  alarm.rest();
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(slides(0.2f).on);
  EXPECT_NEAR(slides(0.2f).answer.slip_index, 0.5, 1e-6);
  EXPECT_THAT(thrown_message<InputError>([&] { Alarm(network, {.touch = 0}); }), HasSubstr("touch: 0"));
}

// A network whose output is 10 mu / (mu + 0.5) less 4 of what is told: S by hand.
TEST(Alarm, TellsFriction) {
  nn::Weights<float> weights = nn::initial_weights(nn::Topology({6, 1, 1}, nn::Activation::leaky_relu), 7);
  std::ranges::fill(weights.values, 0.0f);
  weights.values[4] = 1, weights.values[weights.values.size() - 2] = 10, weights.values.back() = -4;
  nn::Model model{weights, {.friction = true}, 7, 0, "", 0, {}};
  model.history.friction = true;
  Alarm alarm(estimator_of(model), {.at = 0.8f, .touch = 0.01});
  ASSERT_EQ(alarm.inputs(), 4u);
  const auto S = [&] { return alarm.next(grip(0.3f, 0.1f)).answer.slip_index; };
  EXPECT_NEAR(S(), 1 / (1 + std::exp(-1.0)), 1e-6) << "not told: 1 / 2";
  alarm.friction(0.75, 0.1);
  EXPECT_NEAR(S(), 1 / (1 + std::exp(-2.0)), 1e-6) << "0.75 / 1.25 = 0.6";
  alarm.friction(0, 0);
  EXPECT_NEAR(S(), 1 / (1 + std::exp(-1.0)), 1e-6);
  EXPECT_THAT(thrown_message<InputError>([&] { alarm.friction(-1, 0.1); }), HasSubstr("friction: -1"));
  EXPECT_THAT(thrown_message<InputError>([&] { alarm.friction(0.5, NAN); }), HasSubstr("spread: nan"));
  EXPECT_THAT(alarm.slides(), IsNan()) << "the file has no range of mu";
  Alarm other(estimator_of(shear_network()), {});
  EXPECT_THAT(thrown_message<InputError>([&] { other.friction(0.5, 0.1); }), HasSubstr("does not take friction"));
}

TEST(Alarm, ReadsFrictionFromASlide) {
  Alarm alarm(estimator_of(friction_network()), {.at = 0.8f, .touch = 0.01});
  alarm.next(grip(0.3f, 0.1f));
  EXPECT_NEAR(alarm.slides(), 0.413, 0.001);
  EXPECT_NEAR(alarm.next(grip(0.3f, 0.1f)).answer.slip_index, 0.97, 1e-3);
  alarm.friction(0.75, 0.1);
  EXPECT_NEAR(alarm.next(grip(0.3f, 0.1f)).answer.slip_index, 1 / (1 + std::exp(-2.0)), 1e-6);
  EXPECT_NEAR(alarm.slides(), 0.413, 0.001);
  EXPECT_TRUE(std::isnan(Alarm(2, 2, {.at = 0.05f, .touch = 0.01, .signal = AlarmSignal::moved}).slides()));
}

// A network gives S beside; the alarm acts on what it is told to.
TEST(Alarm, RestBesideANetwork) {
  Alarm by_slip(estimator_of(shear_network()), {.at = 0.8f, .touch = 0.01, .rest = true}),
      by_moved(estimator_of(shear_network()), {.at = 0.03f, .touch = 0.01, .signal = AlarmSignal::moved});
  for (int i = 0; i < 10; ++i) by_slip.next(grip(0.3f, 0.1f)), by_moved.next(grip(0.3f, 0.1f));
  const std::vector<float> frame = grip(0.3f, 0.1f, 0.04f);
  const AlarmAnswer slip = by_slip.next(frame), moved = by_moved.next(frame);
  EXPECT_EQ(slip.answer.slip_index, moved.answer.slip_index);
  EXPECT_NEAR(slip.moved, 0.1, 1e-6);
  EXPECT_EQ(slip.acted_on, slip.answer.slip_index);
  EXPECT_EQ(moved.acted_on, slip.moved);
  EXPECT_FALSE(slip.on);
  EXPECT_TRUE(moved.on);
}

TEST(Alarm, RefusesRulesOfMovedThatMeanNothing) {
  const auto refused = [](std::size_t tactels, std::size_t axes, const AlarmOptions& options) {
    return thrown_message<InputError>([&] { Alarm(tactels, axes, options); });
  };
  const auto moved = AlarmSignal::moved;
  EXPECT_THAT(refused(2, 2, {.touch = 0.1, .signal = moved}), HasSubstr("at: 0.8"));
  EXPECT_THAT(refused(2, 2, {.at = 0, .touch = 0.1, .signal = moved}), HasSubstr("at: 0.0"));
  EXPECT_THAT(refused(2, 2, {.at = 0.03f, .touch = 0, .signal = moved}), HasSubstr("touch: 0.0"));
  EXPECT_THAT(refused(2, 2, {.at = 0.03f, .touch = 0.1}), HasSubstr("signal: slip; must be left or moved"));
  EXPECT_THAT(refused(0, 2, {.at = 0.03f, .touch = 0.1, .signal = moved}), HasSubstr("tactels: 0"));
  EXPECT_THAT(refused(2, 4, {.at = 0.03f, .touch = 0.1, .signal = moved}), HasSubstr("axes: 4"));
  EXPECT_EQ(refused(2, 1, {.at = 0.03f, .touch = 0.1, .signal = moved}), "no error");
}

TEST(Alarm, RefusesWhatItCannotMean) {
  const auto refused = [](const nn::Model& model, const AlarmOptions& options) {
    return thrown_message<InputError>([&] { Alarm(estimator_of(model), options); });
  };
  nn::Model ratio = shear_network(3);
  ratio.target = nn::Target::force_ratio;
  EXPECT_THAT(refused(shear_network(), {.at = 1.1f}), HasSubstr("at: 1.1"));
  EXPECT_THAT(refused(shear_network(), {.at = NAN}), HasSubstr("at: nan"));
  EXPECT_THAT(refused(shear_network(), {.touch = -1}), HasSubstr("touch: -1"));
  EXPECT_THAT(refused(shear_network(), {.hold = 0}), HasSubstr("hold: 0"));
  EXPECT_THAT(refused(shear_network(), {.widest = 0.4f}), HasSubstr("without a bound"));
  EXPECT_THAT(refused(ratio, {}), HasSubstr("network: estimates force_ratio; give one of S"));
  EXPECT_EQ(refused(ratio, {.at = INFINITY}), "no error");
}

}  // namespace tactel::alarm_test
