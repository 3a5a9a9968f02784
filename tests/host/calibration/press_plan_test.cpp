// SPDX-License-Identifier: Apache-2.0

// Planned presses beside random ones: what the plan expects, and what a calibration of simulated sensors finds.
#include "host/calibration/press_plan.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <numbers>
#include <numeric>

#include "fem/value_error.h"
#include "host/calibration/press_candidates.h"
#include "tests/host/calibration/simulated_sensor.h"

namespace tactel::host {
namespace {

using Eigen::Index;

fem::Scene nominal_scene(int count) {
  return {.sensor = {.young = nominal_young, .poisson = nominal_poisson, .tactels = count}, .friction = 0.6};
}

/// The usual candidates, on the nominal sensor.
const std::vector<PressCandidate>& candidates() {
  static const std::vector<PressCandidate> usual = usual_candidates(nominal_scene(tactels));
  return usual;
}

/// Another list on another sensor: two rods and a rounded flat on eight tactels, where examples/eight_tactels.toml has
/// them.
std::vector<PressCandidate> other_candidates() {
  fem::Scene scene = nominal_scene(8);
  scene.model = fem::SurfaceModel::patch;
  scene.sensor.tactel_span = 17.5;
  std::vector<PressCandidate> all;
  for (const fem::Shape& shape : {fem::Shape{fem::Cylinder{4}}, {fem::Cylinder{25}}, {fem::RoundedFlat{1.5, 8}}})
    for (int place = -6; place <= 6; ++place)
      for (const double depth : {0.08, 0.14, 0.2})
        for (const double drag : {0.0, 0.05, -0.1}) {
          scene.indenter = {shape, 1.4 * place};
          scene.load = {};
          scene.load.indentation = {depth};
          if (drag != 0) scene.load.tangential = {drag / 3, drag * 2 / 3, drag};
          all.push_back({"", scene, planned_timing(fem::load_path(scene.load).steps.size())});
        }
  return all;
}

std::vector<KnownPress> known(const std::vector<PressCandidate>& all, const std::vector<std::size_t>& set) {
  std::vector<KnownPress> presses;
  presses.reserve(set.size());
  for (const std::size_t i : set)
    presses.push_back({.name = "candidate " + std::to_string(i),
                       .scene = all[i].scene,
                       .readings = {},
                       .P = {},
                       .timing = all[i].timing});
  return presses;
}

PlanOptions options() {
  PlanOptions options;
  options.fit.elements = elements;
  return options;
}

/// Deviations and true errors of calibrations, over sensors.
struct Found {
  std::vector<double> gain_deviation, young_deviation, poisson_deviation;
  std::vector<double> gain_error, young_error, poisson_error;

  void add(const fem::SensorFamily& of, const Simulated& s) {
    const SensorCalibration c = calibrate_sensor(of, s.presses, nominal(), {.elements = elements});
    EXPECT_TRUE(c.converged);
    for (Index i = 0; i < s.gain.size(); ++i) {
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
void compare(const fem::SensorFamily& of, const std::vector<PressCandidate>& all, int sensors, double slack) {
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), 0);
  const double noise = 0.01 * largest_stress(known(all, order));
  const PressPlan plan = plan_presses(of, all, options());
  Found planned, random;
  std::mt19937 draw(11);
  for (int k = 0; k < sensors; ++k) {
    const auto seed = static_cast<unsigned>(500 + k);
    planned.add(of, simulate_sensor(seed, known(all, plan.chosen), noise));
    std::ranges::shuffle(order, draw);
    random.add(of, simulate_sensor(seed, known(all, {order.begin(), order.begin() + 20}), noise));
  }
  const auto check = [](const char* what, const std::vector<double>& plan, const std::vector<double>& other,
                        double most) {
    printf("%s: ten planned %.5f, twenty random %.5f\n", what, median(plan), median(other));
    EXPECT_LE(median(plan), most * median(other)) << what;
  };
  // Deviations of E and nu differ by less than their own uncertainty, the noise of the residuals: 5 %. Of E ten presses
  // know less, as each has one error of the gauge.
  check("deviation of gains", planned.gain_deviation, random.gain_deviation, 1);
  check("deviation of E", planned.young_deviation, random.young_deviation, 1.05 * std::numbers::sqrt2);
  check("deviation of nu", planned.poisson_deviation, random.poisson_deviation, 1.05);
  check("error of gains", planned.gain_error, random.gain_error, 1);
  check("error of E", planned.young_error, random.young_error, slack * std::numbers::sqrt2);
  check("error of nu", planned.poisson_error, random.poisson_error, slack);
}

// Medians of ten errors scatter by 40 %, of two hundred by 9 %; the slack is two of these.
TEST(PressPlanNightly, TenPlannedPressesAreAsGoodAsTwentyRandomOnes) { compare(family(), candidates(), 10, 1.8); }
TEST(PressPlanNightly, TenPlannedPressesAreAsGoodAsTwentyRandomOnesOverManySensors) {
  compare(family(), candidates(), 200, 1.18);
}
TEST(PressPlanNightly, AlsoOfAnotherListOnAnotherSensor) {
  compare(fem::SensorFamily({.poisson_low = 0.4, .poisson_high = 0.49, .tactels = 8}, false), other_candidates(), 200,
          1.18);
}

/// What the plan expects of ten presses is what a calibration of the nominal sensor reports.
void expect_deviations_of_the_fit(const CalibrationOptions& fit, const std::vector<int>& numbers) {
  PlanOptions own = options();
  own.fit = fit;
  own.noise.setConstant(2 * tactels, 0.03);  // beside it the model's error, which a plan does not know, is small
  std::vector<PressCandidate> few;
  std::vector<KnownPress> presses;
  for (std::size_t i = 4; i < candidates().size(); i += 33) few.push_back(candidates()[i]);
  own.presses = static_cast<int>(few.size());
  const PressPlan plan = plan_presses(family(), few, own);
  own.fit.noise.setConstant(2 * tactels, 30);
  for (const PressCandidate& candidate : few) {
    const LinePress model(family(), candidate.scene, candidate.timing, nominal(), own.fit.elements);
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
  const double of_fit[] = {found.young.deviation / found.young.value,
                           found.poisson.deviation,
                           found.thickness.deviation,
                           found.shift.deviation,
                           found.shift_y.deviation,
                           found.time_constant.deviation / found.time_constant.value};
  for (int k = 0; k < sensor_numbers; ++k)
    if (std::ranges::find(numbers, k) != numbers.end())
      EXPECT_NEAR(plan.planned.number[k], of_fit[k], 0.01 * of_fit[k]) << sensor_table[k].fitted;
    else
      EXPECT_TRUE(std::isnan(plan.planned.number[k])) << sensor_table[k].fitted;
}

TEST(PressPlan, ExpectsTheDeviationsThatTheCalibrationReports) {
  expect_deviations_of_the_fit({}, {young_number, poisson_number});
}

TEST(PressPlan, ExpectsThemWithEveryNumberFitted) {
  CalibrationOptions fit;
  fit.fit_thickness = fit.fit_shift = fit.fit_time_constant = true;
  fit.time_constant = 2;
  fit.friction_deviation = 0.2;
  expect_deviations_of_the_fit(fit,
                               {young_number, poisson_number, thickness_number, shift_number, time_constant_number});
}

TEST(PressPlan, SaysWhatNoPlanFinds) {
  PlanOptions own = options();
  own.forces = false;
  own.presses = 2;
  std::vector<PressCandidate> middle;
  for (const PressCandidate& candidate : candidates())
    if (std::abs(candidate.scene.indenter.position) < 3 && candidate.scene.load.tangential.empty())
      middle.push_back(candidate);
  const PressPlan plan = plan_presses(family(), middle, own);
  EXPECT_THAT(plan.lost, testing::Contains(testing::HasSubstr("No plan finds sensor.young")));
  EXPECT_THAT(plan.lost, testing::Contains(testing::HasSubstr("loads the normal stress of tactel 0 enough")));
  EXPECT_THAT(plan.lost, testing::Not(testing::Contains(testing::HasSubstr("normal stress of tactel 10 "))));
  EXPECT_TRUE(std::isnan(plan.planned.number[young_number]));
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
