// SPDX-License-Identifier: Apache-2.0

// The paper's section VI: contacts, records, draws, the study and what reproduce says of it.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "host/studies/paper/real_sensor_study.h"
#include "nn/charge_amplifier.h"
#include "tests/host/networks/network_cases.h"

namespace tactel::host::real_sensor_test {

using tactel::tests::executor;

/// Solved once a process.
const std::vector<fem::ContactSolution>& solved() {
  static const auto solutions = solve_real_contacts(executor(), real_sensor_choice(), real_contacts());
  return solutions;
}

/// One step, one tactel: -1 MPa of normal stress and 0.5 of shear under full load.
fem::ContactSolution one_tactel() {
  fem::ContactSolution solution{.tactel_x = Eigen::VectorXd::Zero(1)};
  solution.steps.resize(1);
  solution.steps[0].sigma_y = Eigen::VectorXd::Constant(1, -1);
  solution.steps[0].tau_xy = Eigen::VectorXd::Constant(1, 0.5);
  return solution;
}

TEST(RealSensorPlan, AllCombinationsOfThePaper) {
  std::set<std::tuple<int, double, double, double>> distinct;
  for (const RealContact& c : real_contacts()) {
    EXPECT_LT(c.angle, c.limit_angle);
    distinct.insert({c.indenter, c.position, c.limit_angle, c.angle});
  }
  EXPECT_EQ(distinct.size(), 105u);  // 7 x 3 x (2 + 3)
  EXPECT_EQ(real_contacts().size(), 105u);
}

// tan 15 = 2 - sqrt 3, tan 30 = 1 / sqrt 3; tan 25 and tan 38 from a table of ten digits.
TEST(RealSensorPlan, SlipIndexIsTheRatioOfTangents) {
  constexpr double tan_25 = 0.4663076582, tan_38 = 0.7812856265;
  EXPECT_EQ((RealContact{0, 0, 25, 0}).slip_index(), 0);
  EXPECT_NEAR((RealContact{0, 0, 25, 15}).slip_index(), (2 - std::sqrt(3)) / tan_25, 1e-9);
  EXPECT_NEAR((RealContact{0, 0, 38, 15}).slip_index(), (2 - std::sqrt(3)) / tan_38, 1e-9);
  EXPECT_NEAR((RealContact{0, 0, 38, 30}).slip_index(), 1 / std::sqrt(3) / tan_38, 1e-9);
}

// The solver meets forces to 1e-9 of the largest (100 times its tolerance in fp64).
TEST(RealSensor, EveryContactCarriesTheForceAtItsAngle) {
  const auto contacts = real_contacts();
  const RealSensorChoice choice = real_sensor_choice();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const fem::ContactStep& full = solved()[i].steps.back();
    SCOPED_TRACE(i);
    EXPECT_NEAR(full.P, choice.normal_force, 1e-9 * choice.normal_force);
    EXPECT_NEAR(full.Q / full.P, std::tan(contacts[i].angle * std::numbers::pi / 180), 1e-9);
    ASSERT_TRUE(full.slip_index);
    EXPECT_NEAR(*full.slip_index, contacts[i].slip_index(), 3e-9);  // over mu, 0.466 at least
    EXPECT_LT(full.indentation, 0.2 * choice.sensor.thickness);     // where the rubber is linear
  }
}

TEST(HandPress, LoadRisesStaysAndFalls) {
  const HandPress press{.start = 3, .rise = 1, .hold = 1.5, .release = 0.5};
  for (const auto& [t, load] :
       {std::pair{0.0, 0.0}, {3.0, 0.0}, {3.25, 0.25}, {4.0, 1.0}, {5.5, 1.0}, {5.75, 0.5}, {6.0, 0.0}, {10.0, 0.0}})
    EXPECT_DOUBLE_EQ(press.load(t), load) << t;
}

TEST(HandPress, HandsDifferAndEndWithinTheRecord) {
  std::set<double> starts;
  for (std::uint32_t number = 0; number < 100; ++number) {
    const HandPress press = hand_press(7, number);
    starts.insert(press.start);
    EXPECT_TRUE(press.start >= 2 && press.start < 5);
    EXPECT_TRUE(press.rise >= 0.5 && press.rise < 1.5);
    EXPECT_TRUE(press.hold >= 1 && press.hold < 2);
    EXPECT_TRUE(press.release >= 0.3 && press.release < 0.7);
    EXPECT_EQ(press.load(Record{}.seconds), 0);
  }
  EXPECT_EQ(starts.size(), 100u);
}

// Two equal steps of load, of which the first makes 0.2 and the second 0.8 of the stress: at a quarter of the load 0.1,
// at three quarters 0.6.
TEST(HandPress, StressGoesThroughTheLoadSteps) {
  fem::ContactSolution solution = one_tactel();
  solution.steps.insert(solution.steps.begin(), solution.steps[0]);
  solution.steps[0].sigma_y *= 0.2, solution.steps[0].tau_xy *= 0.2;
  const auto stress = pressed_record(solution, {.start = 1, .rise = 1, .hold = 1, .release = 1}, {4, 4});
  ASSERT_EQ(stress.size(), 2 * 16u);
  const float expected[16] = {0, 0, 0, 0, 0, .1f, .2f, .6f, 1, 1, 1, 1, 1, .6f, .2f, .1f};
  for (std::size_t k = 0; k < 16; ++k) {
    EXPECT_NEAR(stress[2 * k], -expected[k], 1e-6) << k;  // single precision
    EXPECT_NEAR(stress[2 * k + 1], 0.5 * expected[k], 1e-6) << k;
  }
}

TEST(HandPress, SampleHasTheStrongestCompressionOfAnyTransducer) {
  // Two tactels: normal, normal, shear, shear. Tension, sums and shear do not count.
  const std::vector<float> record{0, 0, 0, 0, -2, -2, 1, 1, 1, -3, -1, 0, 5, -1, -9, 9, 0, 0, 0, 0};
  EXPECT_EQ(highest_normal_sample(record, 4), 2u);
}

/// What the amplifiers and converter of live frames make of a press, at the sample that shows the highest stress.
std::vector<double> sample_of_live_chain(const std::vector<float>& stress, int channels,
                                         const RealSensorChoice& choice) {
  const nn::Converter converter{.bits = choice.chain.bits, .full_scale = choice.chain.range};
  std::vector<nn::ChargeAmplifier> amplifiers(channels, {choice.chain.time_constant, 1 / choice.record.rate});
  std::vector<double> best(channels, 0), now(channels);
  for (std::size_t at = 0; at < stress.size(); at += channels) {
    for (int c = 0; c < channels; ++c) now[c] = (converter(amplifiers[c](stress[at + c])) - 2048) * converter.step();
    const auto normal_end = channels / 2;
    if (*std::min_element(now.begin(), now.begin() + normal_end) <
        *std::min_element(best.begin(), best.begin() + normal_end))
      best = now;
  }
  return best;
}

// Without gains and noise the frames are what the other chain gives, but for a code where single precision rounds
// otherwise, and the sample next to it where that decides which is the highest: within the 0.01 s between two samples
// the amplifiers forget 1 % of 0.1 MPa, 14 codes at most, shear included.
TEST(RealSensor, RecordedFramesAreThoseOfTheLiveChain) {
  RealSensorChoice choice = real_sensor_choice();
  choice.chain.gain_spread = choice.chain.noise = 0;
  const auto records = read_records(executor(), choice, solved(), 5);
  const auto contacts = real_contacts();
  const nn::FrameSet set = recorded_frames(contacts, solved(), records);
  const int channels = 2 * choice.sensor.tactels;
  std::size_t off = 0;
  for (std::uint32_t i = 0; i < contacts.size(); ++i) {
    const auto stress = pressed_record(solved()[i], hand_press(5, i), choice.record);
    const auto expected = sample_of_live_chain(stress, channels, choice);
    for (int c = 0; c < channels; ++c) {
      const double apart = std::abs(double(set.frames(i, c)) - expected[c]) / choice.chain.quantum();
      EXPECT_LT(apart, 14.5) << i << ", " << c;
      off += apart > 0.5;
    }
  }
  EXPECT_LE(off, 105 * 16 / 50u);
}

// A ramp over the time constant leaves 1 - 1/e of the stress; the press that follows is forgotten, and its end reads as
// tension. Contact 0's own press sets how long the ramp is.
TEST(RealSensor, AmplifiersForgetWhileTheHandPresses) {
  RealSensorChoice choice = real_sensor_choice();
  choice.sensor.tactels = 1;
  choice.chain = {.time_constant = 1, .step_time = 0.01};
  const auto records = read_records(executor(), choice, {one_tactel()}, 9);
  const nn::FrameSet set = recorded_frames({RealContact{}}, {one_tactel()}, records);
  const double rise = hand_press(9, 0).rise;
  // The ramp's end lies up to one sample before the reading, in which 1 % is forgotten.
  const double reading = (1 - std::exp(-rise)) / rise;
  EXPECT_NEAR(set.frames(0, 0), -reading, 0.01 * reading);
  EXPECT_NEAR(set.frames(0, 1), 0.5 * reading, 0.005 * reading);
  EXPECT_GT(*std::ranges::max_element(records), 0.3f);  // lifting
}

TEST(RealSensor, OneUncalibratedSensorForAllContactsOfADraw) {
  RealSensorChoice choice = real_sensor_choice();
  choice.sensor.tactels = 1;
  choice.chain = {.gain_spread = 0.2, .instances = 1};
  const auto gains = [&](std::uint64_t seed) {
    const auto records = read_records(executor(), choice, {one_tactel(), one_tactel()}, seed);
    return recorded_frames({RealContact{}, RealContact{}}, {one_tactel(), one_tactel()}, records).frames;
  };
  EXPECT_EQ(gains(1).row(0), gains(1).row(1));
  EXPECT_NE(gains(1).row(0), gains(2).row(0));
}

TEST(RealSensorPlan, DrawsAreDisjoint) {
  std::set<std::vector<std::uint32_t>> distinct;
  for (std::uint64_t number = 1; number <= 20; ++number) {
    const ContactDraw draw = draw_contacts(number, 105);
    EXPECT_EQ(draw.learning.size(), 25u);
    EXPECT_EQ(draw.recall.size(), 11u);
    EXPECT_EQ(draw.unseen.size(), 80u);
    std::set<std::uint32_t> all(draw.learning.begin(), draw.learning.end());
    all.insert(draw.unseen.begin(), draw.unseen.end());
    EXPECT_EQ(all.size(), 105u);  // so they share none
    EXPECT_EQ(*all.rbegin(), 104u);
    EXPECT_TRUE(std::equal(draw.recall.begin(), draw.recall.end(), draw.unseen.begin()));
    distinct.insert(draw.learning);
  }
  EXPECT_EQ(distinct.size(), 20u);
}

// Of 15 degrees S is 0.5746 or 0.3430: half their difference. Of 0 and 30 degrees it is one.
TEST(RealSensorPlan, TheAngleAloneLeavesTwoChoices) {
  const auto contacts = real_contacts();
  const auto errors = errors_by_angle_alone(contacts);
  for (std::size_t i = 0; i < contacts.size(); ++i) EXPECT_NEAR(errors[i], contacts[i].angle == 15 ? 0.11583 : 0, 1e-5);
}

RealSensorOptions few() {
  RealSensorOptions options{.draws = 2, .seeds = 2, .training = {}, .progress = {}};
  options.training.cycle_limit = 20;
  return options;
}

TEST(RealSensorStudy, JudgesEveryDrawAndSeed) {
  const auto study = study_real_sensor(executor(), real_sensor_choice(), few());
  ASSERT_TRUE(study);
  const auto json = real_sensor_json(*study);
  EXPECT_EQ(json["network"], "16-16-8-1");
  EXPECT_LT(json["deepest"], 0.3);
  EXPECT_EQ(study->results.size(), 4u);
  for (const auto& result : study->results) {
    for (const auto* reports : {&result.learning, &result.recalling, &result.unseen}) EXPECT_EQ(reports->size(), 4u);
    EXPECT_EQ(result.learning[0].all.count, 25u);
    EXPECT_EQ(result.recalling[0].all.count, 11u);
    EXPECT_EQ(result.unseen[0].all.count, 80u);
  }
  Page page("", "");
  EXPECT_NO_THROW(report_real_sensor(page, *study));
}

TEST(RealSensorStudy, StopsWhenToldTo) {
  RealSensorOptions options = few();
  options.progress = [](std::size_t, std::size_t all) {
    EXPECT_EQ(all, 4 * 4u);
    return false;
  };
  EXPECT_FALSE(study_real_sensor(executor(), real_sensor_choice(), options));
}

}  // namespace tactel::host::real_sensor_test
