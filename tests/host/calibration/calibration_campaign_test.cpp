// SPDX-License-Identifier: Apache-2.0

// How true the deviations of a calibration are: sensors whose frames come from twice the elements of the fit, each
// on tables of its own layer, with an error of the gauge in each press, and with presses that the fit knows wrongly.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/host/calibration/simulated_sensor.h"

namespace tactel::host {
namespace {

struct Case {
  const char* name;
  double noise;  ///< of an averaged reading, over the largest stress
  SimulatedAs as;
};

struct Tally {
  double gains = 0, gains_within = 0, young_within = 0, poisson_within = 0, misfits = 0;
  double young_error = 0, young_deviation = 0;  ///< relative, means of absolute values
};

SimulatedAs with_gauge(double thickness = 1.5, double radius = 1) {
  return {.thickness = thickness,
          .radius = radius,
          .press_force = 0.01,
          .step_force = 0,
          .truth = 2 * CalibrationOptions{}.elements};
}

Tally run(const Case& of, int sensors) {
  const std::vector<KnownPress> all = presses();
  const double noise = of.noise * largest_stress(all);
  Tally sum;
  for (int k = 0; k < sensors; ++k) {
    const Simulated s = simulate_sensor(static_cast<unsigned>(1000 + k), all, noise, of.as);
    const CalibrationOptions options{.rest_noise = s.noise / s.gain.array()};
    const SensorCalibration c = calibrate_sensor(family(), s.presses, nominal(), options);
    EXPECT_TRUE(c.converged) << of.name << ' ' << k;
    sum.gains_within += gains_within(c, s.gain);
    sum.gains += static_cast<double>(c.gain.size());
    sum.young_within += within(c.young, s.young) / static_cast<double>(sensors);
    sum.poisson_within += within(c.poisson, s.poisson) / static_cast<double>(sensors);
    sum.young_error += std::abs(c.young.value / s.young - 1) / sensors;
    sum.young_deviation += c.young.deviation / s.young / sensors;
    sum.misfits += !texts(c, CalibrationFault::Kind::model_misfit).empty();
    if (k == 0)
      for (const std::string& text : texts(c)) printf("%s: %s\n", of.name, text.c_str());
  }
  printf("| %s | %.1f %% | %.1f %% | %.1f %% | %.2f %%, %.2f %% | %.0f of %d |\n", of.name,
         100 * sum.gains_within / sum.gains, 100 * sum.young_within, 100 * sum.poisson_within, 100 * sum.young_error,
         100 * sum.young_deviation, sum.misfits, sensors);
  return sum;
}

const Case honest[] = {{"gauge 1 %", 0.01, with_gauge()}, {"gauge 1 %, noise 0.1 %", 0.001, with_gauge()}};
const Case wrong[] = {{"thickness 10 % larger", 0.01, with_gauge(1.65)},
                      {"thickness 10 % smaller", 0.01, with_gauge(1.35)},
                      {"radii 5 % larger", 0.01, with_gauge(1.5, 1.05)},
                      {"radii 5 % smaller", 0.01, with_gauge(1.5, 0.95)},
                      {"thickness 10 % larger, noise 0.1 %", 0.001, with_gauge(1.65)},
                      {"radii 5 % larger, noise 0.1 %", 0.001, with_gauge(1.5, 1.05)}};

TEST(CalibrationCampaignNightly, OfAFewSensors) {
  const Tally gauge = run(honest[0], 8);
  EXPECT_EQ(gauge.misfits, 0);
  EXPECT_GE(gauge.gains_within, 0.88 * gauge.gains);  // eight sensors, whose gains share the error of E
  for (const Case* of : {&wrong[0], &wrong[2]}) EXPECT_EQ(run(*of, 2).misfits, 2) << of->name;
}

TEST(CalibrationCampaignNightly, DeviationsAreTrue) {
  for (const Case& of : honest) {
    const Tally found = run(of, 200);
    EXPECT_LE(found.misfits, 4);
    EXPECT_GE(found.gains_within, 0.93 * found.gains);
    // 95.4 % of a normal distribution; of 200 the share scatters by 1.5 %: three of these.
    EXPECT_GE(found.young_within, 0.91);
    EXPECT_GE(found.poisson_within, 0.91);
  }
}

TEST(CalibrationCampaignNightly, ModelsThatDoNotFitAreNamed) {
  constexpr int sensors = 34;
  for (const Case& of : wrong) EXPECT_EQ(run(of, sensors).misfits, sensors) << of.name;
}

}  // namespace
}  // namespace tactel::host
