// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <tactel/infer.h>

#include <cmath>

#include "nn/infer/network_file.h"
#include "tests/host/live/shear_network.h"
#include "tests/host/networks/bounded_model.h"
#include "tests/thrown_message.h"

namespace tactel {
namespace {

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
  const auto bounded = testing::bounded_model("8-6-3", nn::ScalingKind::frame);
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
  const SlipEstimator network = estimator_of(testing::bounded_model("8-6-3", nn::ScalingKind::frame));
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

}  // namespace
}  // namespace tactel
