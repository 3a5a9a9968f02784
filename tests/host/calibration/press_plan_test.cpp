// SPDX-License-Identifier: Apache-2.0

// Planned presses beside random ones: what the plan expects, and what a calibration of simulated sensors finds.
#include "host/calibration/press_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "fem/value_error.h"
#include "host/calibration/press_candidates.h"
#include "tests/host/calibration/simulated_sensor.h"

namespace tactel::host {
namespace {

using Eigen::Index;

/// The usual candidates, on the nominal sensor.
const std::vector<PressCandidate>& candidates() {
  static const std::vector<PressCandidate> usual = [] {
    fem::Scene scene;
    scene.sensor.poisson = nominal_poisson;
    scene.sensor.young = nominal_young;
    scene.friction = 0.6;
    return usual_candidates(scene);
  }();
  return usual;
}

KnownPress known(std::size_t candidate) {
  return {.name = "candidate " + std::to_string(candidate),
          .scene = candidates()[candidate].scene,
          .readings = {},
          .P = {},
          .timing = candidates()[candidate].timing};
}

std::vector<KnownPress> known(const std::vector<std::size_t>& set) {
  std::vector<KnownPress> presses;
  presses.reserve(set.size());
  for (const std::size_t candidate : set) presses.push_back(known(candidate));
  return presses;
}

PlanOptions options() {
  PlanOptions options;
  options.fit.elements = elements;
  return options;
}

const PressPlan& plan_of_ten() {
  static const PressPlan plan = plan_presses(family(), candidates(), options());
  return plan;
}

/// Deviations and true errors of calibrations, over sensors.
struct Found {
  std::vector<double> gain_deviation, young_deviation, poisson_deviation;
  std::vector<double> gain_error, young_error, poisson_error;

  void add(const Simulated& s) {
    CalibrationOptions fit;
    fit.elements = elements;
    const SensorCalibration c = calibrate_sensor(family(), s.presses, nominal(), fit);
    EXPECT_TRUE(c.converged);
    for (Index i = 0; i < 2 * tactels; ++i) {
      const Fitted& gain = c.gain[static_cast<std::size_t>(i)];
      if (std::isnan(gain.value)) {  // no press loads it: it counts as not known at all
        gain_deviation.push_back(1), gain_error.push_back(1);
        continue;
      }
      gain_deviation.push_back(gain.deviation / gain.value);
      gain_error.push_back(std::abs(gain.value / s.gain[i] - 1));
    }
    young_deviation.push_back(c.young.deviation / c.young.value);
    young_error.push_back(std::abs(c.young.value / s.young - 1));
    poisson_deviation.push_back(c.poisson.deviation);
    poisson_error.push_back(std::abs(c.poisson.value - s.poisson));
  }
};

double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

/// Ten planned presses against twenty random ones, drawn anew for each sensor. `slack`: of medians of the true errors
/// of E and nu, of which each sensor has one only.
void compare(int sensors, double slack) {
  std::vector<KnownPress> all;
  for (std::size_t i = 0; i < candidates().size(); ++i) all.push_back(known(i));
  const double noise = 0.01 * largest_stress(all);
  Found planned, random;
  std::mt19937 draw(11);
  std::vector<std::size_t> order(candidates().size());
  std::iota(order.begin(), order.end(), 0);
  for (int k = 0; k < sensors; ++k) {
    const auto seed = static_cast<unsigned>(500 + k);
    planned.add(simulate_sensor(seed, known(plan_of_ten().chosen), noise));
    std::ranges::shuffle(order, draw);
    random.add(simulate_sensor(seed, known({order.begin(), order.begin() + 20}), noise));
  }
  const auto check = [](const char* what, const std::vector<double>& plan, const std::vector<double>& other,
                        double most) {
    printf("%s: ten planned %.5f, twenty random %.5f\n", what, median(plan), median(other));
    EXPECT_LE(median(plan), most * median(other)) << what;
  };
  // Deviations of E and nu differ by less than their own uncertainty, the noise of the residuals: 5 %.
  check("deviation of gains", planned.gain_deviation, random.gain_deviation, 1);
  check("deviation of E", planned.young_deviation, random.young_deviation, 1.05);
  check("deviation of nu", planned.poisson_deviation, random.poisson_deviation, 1.05);
  check("error of gains", planned.gain_error, random.gain_error, 1);
  check("error of E", planned.young_error, random.young_error, slack);
  check("error of nu", planned.poisson_error, random.poisson_error, slack);
}

// Medians of ten errors scatter by 40 %, of two hundred by 9 %; the slack is two of these.
TEST(PressPlan, TenPlannedPressesAreAsGoodAsTwentyRandomOnes) { compare(10, 1.8); }
TEST(PressPlanNightly, TenPlannedPressesAreAsGoodAsTwentyRandomOnesOverManySensors) { compare(200, 1.18); }

/// What the plan expects of ten presses is what a calibration of the nominal sensor reports.
void expect_deviations_of_the_fit(const CalibrationOptions& fit, const std::vector<int>& numbers) {
  PlanOptions own = options();
  own.fit = fit;
  own.fit.elements = elements;
  own.draws = 1;
  own.noise.setConstant(2 * tactels, 0.003);
  std::vector<PressCandidate> few;
  std::vector<KnownPress> presses;
  for (std::size_t i = 4; i < candidates().size(); i += 33) few.push_back(candidates()[i]);
  own.presses = static_cast<int>(few.size());
  const PressPlan plan = plan_presses(family(), few, own);
  own.fit.noise.setConstant(2 * tactels, 3);
  for (const PressCandidate& candidate : few) {
    const PressModel model(family(), candidate.scene, candidate.timing, nominal(), elements);
    SensorState state = nominal();
    state.log_time_constant = std::log(fit.time_constant);
    const PressFrames frames = model.at(state, candidate.scene.friction);
    presses.push_back({"press", candidate.scene, (frames.frame / 0.001).array() + 2048, frames.P, candidate.timing});
  }
  const SensorCalibration found = calibrate_sensor(family(), presses, nominal(), own.fit);
  ASSERT_TRUE(found.converged);
  int compared = 0;
  for (Index c = 0; c < 2 * tactels; ++c) {
    const Fitted& gain = found.gain[static_cast<std::size_t>(c)];
    if (std::isnan(gain.value) || plan.planned.gain[c] > 0.5) continue;  // the plan's weak information counts there
    EXPECT_NEAR(gain.deviation / gain.value, plan.planned.gain[c], 0.01 * plan.planned.gain[c]) << c;
    ++compared;
  }
  EXPECT_GT(compared, tactels);
  const double of_fit[] = {found.young.deviation / found.young.value, found.poisson.deviation,
                           found.thickness.deviation, found.shift.deviation,
                           found.time_constant.deviation / found.time_constant.value};
  for (int k = 0; k < sensor_numbers; ++k)
    if (std::ranges::find(numbers, k) != numbers.end())
      EXPECT_NEAR(plan.planned.number[k], of_fit[k], 0.01 * of_fit[k]) << sensor_names[k];
    else
      EXPECT_TRUE(std::isnan(plan.planned.number[k])) << sensor_names[k];
}

TEST(PressPlan, ExpectsTheDeviationsThatTheCalibrationReports) { expect_deviations_of_the_fit({}, {0, 1}); }

TEST(PressPlan, ExpectsThemWithEveryNumberFitted) {
  CalibrationOptions fit;
  fit.fit_thickness = fit.fit_shift = fit.fit_time_constant = true;
  fit.time_constant = 2;
  fit.friction_deviation = 0.2;
  expect_deviations_of_the_fit(fit, {0, 1, 2, 3, 4});
}

TEST(PressPlan, SaysWhatNoPlanFinds) {
  PlanOptions own = options();
  own.forces = false;
  own.presses = 2;
  own.draws = 1;
  std::vector<PressCandidate> middle;
  for (const PressCandidate& candidate : candidates())
    if (std::abs(candidate.scene.indenter.position) < 3 && candidate.scene.load.tangential.empty())
      middle.push_back(candidate);
  const PressPlan plan = plan_presses(family(), middle, own);
  EXPECT_THAT(plan.lost, testing::Contains(testing::HasSubstr("No plan finds sensor.young")));
  EXPECT_THAT(plan.lost, testing::Contains(testing::HasSubstr("loads the normal stress of tactel 0 enough")));
  EXPECT_THAT(plan.lost, testing::Not(testing::Contains(testing::HasSubstr("normal stress of tactel 10 "))));
  EXPECT_TRUE(std::isnan(plan.planned.number[0]));
}

TEST(PressPlan, WrongOptionsAreRefused) {
  PlanOptions own = options();
  own.presses = static_cast<int>(candidates().size()) + 1;
  EXPECT_THROW(plan_presses(family(), candidates(), own), ValueError);
  EXPECT_THROW(plan_presses(family(), {}, options()), ValueError);
  own = options();
  own.noise.setConstant(3, 0.1);
  EXPECT_THROW(plan_presses(family(), candidates(), own), ValueError);
}

}  // namespace
}  // namespace tactel::host
