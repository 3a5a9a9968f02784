// SPDX-License-Identifier: Apache-2.0

// The chain of sets and the chain of live frames are the same chain.
#include <gtest/gtest.h>

#include <random>

#include "hw/charge_amplifier.h"
#include "nn/transducer_chain.h"

namespace tactel {
namespace {

constexpr int samples = 300, channels = 4;

nn::RowMatrix<double> random_stress() {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  return nn::RowMatrix<double>::NullaryExpr(samples, channels, [&] { return uniform(random); });
}

// The same exact solution, summed in another order: 300 steps of a few roundings of 1.1e-16 on stresses of 1 MPa.
TEST(MeasuringChains, AmplifiersAgree) {
  const nn::RowMatrix<double> stress = random_stress();
  for (const double time_constant : {0.05, 1.0, 30.0}) {
    const nn::Transducer transducer{.time_constant = time_constant, .step_time = 0.01};
    const auto reading = nn::transducer_chain(transducer, 1, 0, stress);
    for (int channel = 0; channel < channels; ++channel) {
      hw::ChargeAmplifier amplifier(time_constant, 0.01);
      for (int k = 0; k < samples; ++k) ASSERT_NEAR(reading(k, channel), amplifier(stress(k, channel)), 1e-13);
    }
  }
}

// Whole codes: no stress of these is as near to the middle of two as the amplifiers may differ. Half of them are beyond
// the range, on both sides.
TEST(MeasuringChains, ConvertersAgree) {
  const nn::RowMatrix<double> stress = random_stress();
  const nn::Transducer transducer{.time_constant = 1, .step_time = 0.01, .range = 0.5, .bits = 12};
  const auto reading = nn::transducer_chain(transducer, 1, 0, stress);
  EXPECT_EQ(reading.minCoeff(), -0.5);
  EXPECT_EQ(reading.maxCoeff(), 0.5 - transducer.quantum());
  const hw::Converter converter{.bits = 12, .full_scale = 0.5};
  for (int channel = 0; channel < channels; ++channel) {
    hw::ChargeAmplifier amplifier(1, 0.01);
    for (int k = 0; k < samples; ++k) {
      const int code = converter(amplifier(stress(k, channel)));
      ASSERT_EQ(reading(k, channel), (code - converter.zero()) * converter.step()) << k;
    }
  }
}

}  // namespace
}  // namespace tactel
