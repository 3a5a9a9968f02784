// SPDX-License-Identifier: Apache-2.0
#include "nn/charge_amplifier.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tactel::nn::charge_amplifier_test {

// The recursion is exact for such inputs; what remains is the rounding of 300 steps (300 x 1.1e-16).
constexpr double rounding = 1e-13;

TEST(ChargeAmplifier, AStepDecaysWithTheTimeConstant) {
  for (const double dt : {0.01, 0.5}) {
    ChargeAmplifier amplifier(1.0, dt);
    const double first = amplifier(2.0);  // the input rises linearly within the first sample
    EXPECT_NEAR(first, 2.0 * (1 - std::exp(-dt)) / dt, rounding);
    for (int i = 1; i <= 300; ++i) ASSERT_NEAR(amplifier(2.0), first * std::exp(-i * dt), rounding) << i;
  }
}

TEST(ChargeAmplifier, ARampLevelsOffAtSlopeTimesTimeConstant) {
  const double dt = 0.01, slope = 3.0, time_constant = 0.7;
  ChargeAmplifier amplifier(time_constant, dt);
  for (int i = 1; i <= 300; ++i) {
    const double expected = slope * time_constant * (1 - std::exp(-i * dt / time_constant));
    ASSERT_NEAR(amplifier(slope * i * dt), expected, rounding) << i;
  }
}

TEST(ChargeAmplifier, WithoutDecayGivesItsInput) {
  ChargeAmplifier amplifier(std::numeric_limits<double>::infinity(), 0.01);
  for (const double x : {0.0, 1.0, -0.5, 0.25}) EXPECT_EQ(amplifier(x), x);
}

TEST(Converter, TwelveBitsOfBothSigns) {
  const Converter converter{.bits = 12, .full_scale = 2.048};
  EXPECT_DOUBLE_EQ(converter.step(), 0.001);
  EXPECT_EQ(converter(0), 2048);
  EXPECT_EQ(converter(0.0104), 2058);
  EXPECT_EQ(converter(-0.0106), 2037);
  EXPECT_EQ(converter(2.047), 4095);
  EXPECT_EQ(converter(-2.048), 0);
  EXPECT_EQ(converter(100), 4095);
  EXPECT_EQ(converter(-std::numeric_limits<double>::infinity()), 0);
  EXPECT_EQ(converter(std::nan("")), 2048);
}

TEST(Converter, ErrsByHalfAStepAtMost) {
  const Converter converter{.bits = 12, .full_scale = 0.7};
  for (double stress = -0.699; stress < 0.699; stress += 0.00137)
    ASSERT_LE(std::abs((converter(stress) - converter.zero()) * converter.step() - stress),
              0.5 * converter.step() * (1 + 1e-9));
}

}  // namespace tactel::nn::charge_amplifier_test
