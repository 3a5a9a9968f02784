// SPDX-License-Identifier: Apache-2.0
#include "hw/tare.h"

#include <gmock/gmock.h>

#include <limits>
#include <random>

namespace tactel::hw::tare_test {

using ::testing::ElementsAre;

/// One channel's readings, i from 0.
template <class Reading>
Tare tared(int count, Reading reading) {
  Tare tare(1);
  for (int i = 0; i < count; ++i) {
    const double value = reading(i);
    tare.add(std::span(&value, 1));
  }
  return tare;
}

TEST(Tare, TheOffsetIsTheMeanOfEachChannel) {
  Tare tare(2);
  EXPECT_THAT(tare.offset(), ElementsAre(0, 0));
  for (int i = 0; i < 101; ++i) tare.add(std::vector<double>{static_cast<double>(i), 7.0});
  EXPECT_EQ(tare.frames(), 101u);
  EXPECT_THAT(tare.offset(), ElementsAre(50, 7));
}

// Steps of 2 between neighbours: 2 sqrt(pi) / 2.
TEST(Tare, NoiseComesFromNeighbours) {
  const ChannelRest rest = tared(1000, [](int i) { return i % 2 == 0 ? 1.0 : -1.0; }).channel(0);
  EXPECT_NEAR(rest.noise, 1.772453850905516, 1e-12);
  EXPECT_EQ(rest.mean, 0);
  EXPECT_TRUE(rest.at_rest());
}

// A converter whose last bit changes once in 100 readings: the noise is below its step, and half the step counts.
TEST(Tare, NoiseBelowTheStepIsHalfAStep) {
  const Tare tare = tared(1000, [](int i) { return i % 100 == 50 ? 3.0 : 1.0; });
  EXPECT_EQ(tare.channel(0).step, 2);
  EXPECT_LT(tare.channel(0).noise, 0.1);
  EXPECT_THAT(tare.noise(), ElementsAre(1));
  EXPECT_THAT(tared(300, [](int) { return 2048.0; }).noise(), ElementsAre(0)) << "nothing is known of a constant";
}

TEST(Tare, ConstantReadingsAreAtRest) {
  const ChannelRest rest = tared(300, [](int) { return 2048.0; }).channel(0);
  EXPECT_EQ(rest.noise, 0);
  EXPECT_EQ(rest.highest - rest.lowest, 0);
  EXPECT_TRUE(rest.at_rest());
}

TEST(Tare, NoiseIsTheStandardDeviationOfWhiteNoise) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(2048, 3);
  EXPECT_NEAR(tared(10000, [&](int) { return noise(random); }).channel(0).noise, 3, 0.1);  // 4 standard errors
}

TEST(Tare, NoiseAloneIsRestAtEveryLength) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(2048, 3);
  for (const int count : {8, 15, 16, 17, 33, 100, 200, 2000})
    for (int sensor = 0; sensor < 1000; ++sensor) {
      const ChannelRest rest = tared(count, [&](int) { return noise(random); }).channel(0);
      ASSERT_TRUE(rest.at_rest()) << count << " frames: " << rest.highest - rest.lowest << " of " << rest.allowed;
    }
}

TEST(Tare, ARampAndAStepAreNoRest) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0, 1);
  for (const int count : {20, 200, 2000}) {
    const auto ramp = tared(count, [&](int i) { return 40.0 * i / count + noise(random); }).channel(0);
    EXPECT_FALSE(ramp.at_rest()) << count;
    const auto step = tared(count, [&](int i) { return (i < 2 * count / 3 ? 0.0 : 40.0) + noise(random); }).channel(0);
    EXPECT_FALSE(step.at_rest()) << count;
    EXPECT_FALSE(tared(count, [&](int i) { return 0.001 * i; }).channel(0).at_rest()) << "without noise, " << count;
  }
}

// A converter whose last bit changes once.
TEST(Tare, OneStepOfTheConverterIsRest) {
  EXPECT_TRUE(tared(200, [](int i) { return i < 150 ? 2048.0 : 2049.0; }).channel(0).at_rest());
}

TEST(Tare, WhatIsNotFiniteIsLeftOut) {
  const double nan = std::nan(""), infinite = std::numeric_limits<double>::infinity();
  const ChannelRest some = tared(200, [&](int i) { return i % 3 == 0 ? nan : i % 3 == 1 ? infinite : 5.0; }).channel(0);
  EXPECT_EQ(some.readings, 66u);
  EXPECT_EQ(some.mean, 5);
  EXPECT_TRUE(some.at_rest());
  const auto moving = tared(200, [&](int i) { return i % 3 == 0 ? 10.0 * i : nan; }).channel(0);
  EXPECT_FALSE(moving.at_rest());
  const ChannelRest none = tared(200, [&](int) { return nan; }).channel(0);
  EXPECT_EQ(none.readings, 0u);
  EXPECT_EQ(none.mean, 0);
}

}  // namespace tactel::hw::tare_test
