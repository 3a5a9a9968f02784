// SPDX-License-Identifier: Apache-2.0

// The converter of sets and that of live frames are the same.
#include <gtest/gtest.h>

#include <random>

#include "nn/charge_amplifier.h"
#include "nn/transducer_chain.h"

namespace tactel::measuring_chains_test {

constexpr int samples = 300, channels = 4;

nn::RowMatrix<double> random_stress() {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  return nn::RowMatrix<double>::NullaryExpr(samples, channels, [&] { return uniform(random); });
}

// Whole codes: no stress of these is as near to the middle of two as the amplifiers may differ. Half of them are beyond
// the range, on both sides.
TEST(MeasuringChains, ConvertersAgree) {
  const nn::RowMatrix<double> stress = random_stress();
  const nn::Transducer transducer{.time_constant = 1, .step_time = 0.01, .range = 0.5, .bits = 12};
  const auto reading = nn::transducer_chain(transducer, 1, 0, stress);
  EXPECT_EQ(reading.minCoeff(), -0.5);
  EXPECT_EQ(reading.maxCoeff(), 0.5 - transducer.quantum());
  const nn::Converter converter{.bits = 12, .full_scale = 0.5};
  for (int channel = 0; channel < channels; ++channel) {
    nn::ChargeAmplifier amplifier(1, 0.01);
    for (int k = 0; k < samples; ++k) {
      const int code = converter(amplifier(stress(k, channel)));
      ASSERT_EQ(reading(k, channel), (code - converter.zero()) * converter.step()) << k;
    }
  }
}

}  // namespace tactel::measuring_chains_test
