// SPDX-License-Identifier: Apache-2.0

// Simulated pads, whose gains, offsets, E, nu and H the calibration does not know. Their frames come from finer cells
// and more increments than the fit and its correction take.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/support/host_threads.h"
#include "host/support/side_by_side.h"
#include "tests/host/calibration/simulated_pad.h"

namespace tactel::host {
namespace {

struct Tally {
  double gains = 0, gains_within = 0, young = 0, poisson = 0, thickness = 0;
};

/// Calibrates so many pads on patches of so many elements; shares within two deviations.
Tally calibrate_pads(std::size_t pads, int elements, const PadAs& as) {
  const std::vector<KnownPress> presses = pad_presses();
  std::vector<SimulatedPad> simulated(pads);
  std::vector<SensorCalibration> found(pads);
  side_by_side(pads, host_threads(), [&](std::size_t k) {
    const SimulatedPad& s = simulated[k] = simulate_pad(static_cast<unsigned>(2000 + k), presses, as);
    CalibrationOptions options{.fit_thickness = true, .rest_noise = s.noise / s.gain.array()};
    options.elements = elements;
    found[k] = calibrate_pad(s.presses, nominal_pad(), options);
  });
  Tally sum;
  double deviation = 0;
  for (std::size_t k = 0; k < pads; ++k) {
    const SimulatedPad& s = simulated[k];
    const SensorCalibration& c = found[k];
    EXPECT_TRUE(c.converged) << k;
    EXPECT_THAT(c.faults, testing::IsEmpty()) << k << ": " << (c.faults.empty() ? "" : c.faults[0].text);
    const auto within = [](const Fitted& fitted, double value) {
      return std::abs(fitted.value - value) <= 2 * fitted.deviation;
    };
    for (Eigen::Index i = 0; i < s.gain.size(); ++i) {
      const Fitted& gain = c.gain[static_cast<std::size_t>(i)];
      sum.gains_within += within(gain, s.gain[i]);
      deviation += gain.deviation / s.gain[i];
      sum.gains += 1;
    }
    sum.young += within(c.young, s.young);
    sum.poisson += within(c.poisson, s.poisson);
    sum.thickness += within(c.thickness, s.thickness);
    printf("E %.4f: %.4f +- %.4f   nu %.4f: %.4f +- %.4f   H %.4f: %.4f +- %.4f\n", s.young, c.young.value,
           c.young.deviation, s.poisson, c.poisson.value, c.poisson.deviation, s.thickness, c.thickness.value,
           c.thickness.deviation);
  }
  printf("%zu pads: %.2f %% of gains within 2 deviations (of %.2f %%), E %.0f, nu %.0f, H %.0f\n", pads,
         100 * sum.gains_within / sum.gains, 100 * deviation / sum.gains, sum.young, sum.poisson, sum.thickness);
  return sum;
}

TEST(PadCalibrationNightly, FindsFiftyPads) {
  const Tally found = calibrate_pads(50, CalibrationOptions{}.elements, {});
  // 95.4 % of a normal distribution. Gains of one pad share the error of E: shares of pads scatter by 3 %.
  EXPECT_GE(found.gains_within, 0.94 * found.gains);
  // Of 50 the number scatters by 1.5: three of these.
  EXPECT_GE(found.young, 43);
  EXPECT_GE(found.poisson, 43);
  EXPECT_GE(found.thickness, 43);
}

}  // namespace
}  // namespace tactel::host
