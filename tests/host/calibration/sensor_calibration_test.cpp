// SPDX-License-Identifier: Apache-2.0

// Simulated sensors, whose gains, offsets, E and nu the calibration does not know. Their frames come from the sweeps on
// tables of their own layer, each press on its own patch; the calibration's come from a family of layers.
#include "host/calibration/sensor_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "fem/value_error.h"
#include "tests/host/calibration/simulated_sensor.h"

namespace tactel::host {
namespace {

using Eigen::Index;

/// Twenty presses and drags of two cylinders along the array.
std::vector<KnownPress> presses() {
  std::vector<KnownPress> all;
  for (int k = 0; k < 20; ++k) {
    KnownPress press;
    press.name = "press " + std::to_string(k + 1);
    press.scene.sensor.poisson = nominal_poisson;
    press.scene.sensor.young = nominal_young;
    press.scene.indenter = {fem::Cylinder{k % 2 ? 6.0 : 15.0}, -9.0 + 18.0 * k / 19};
    press.scene.friction = 0.6;
    press.scene.load.indentation = {0.1 + 0.02 * (k % 4)};
    press.scene.load.indentation_steps = 2;
    press.scene.load.tangential = {0.02, 0.05, 0.08};
    all.push_back(press);
  }
  return all;
}

Simulated simulate(unsigned seed, double noise = 0.01) {
  std::vector<KnownPress> all = presses();
  return simulate_sensor(seed, all, noise * largest_stress(all));
}

SensorCalibration calibrate(const Simulated& s, CalibrationOptions options = {}) {
  options.elements = elements;
  return calibrate_sensor(family(), s.presses, nominal(), options);
}

/// S by the sums of the tactels' stresses; of readings by these gains and offsets against the exact stresses: rms over
/// all drags.
double error_of_S(const Simulated& s, const Eigen::VectorXd& gain, const Eigen::VectorXd& offset) {
  double sum = 0;
  int n = 0;
  for (int k = 0; k < 20; ++k) {
    const Truth& t = truth(s.poisson, s.presses[k]);
    for (Index row = 2; row < t.frame.rows(); ++row, ++n) {
      const Eigen::VectorXd stress = (s.presses[k].readings.row(row).transpose() - offset).cwiseProduct(gain);
      const auto S = [](const auto& frame) { return -frame.tail(tactels).sum() / frame.head(tactels).sum() / 0.6; };
      sum += std::pow(S(stress) - S(t.frame.row(row)), 2);
    }
  }
  return std::sqrt(sum / n);
}

/// Shares and errors over many sensors.
void check_sensors(int sensors) {
  int gains = 0, within = 0, young_within = 0;
  double error_true = 0, error_calibrated = 0, error_factory = 0;
  for (int k = 0; k < sensors; ++k) {
    const Simulated s = simulate(static_cast<unsigned>(100 + k));
    const SensorCalibration c = calibrate(s);
    EXPECT_TRUE(c.converged) << k;
    EXPECT_THAT(c.faults, testing::IsEmpty()) << k << ": " << (c.faults.empty() ? "" : c.faults[0].text);
    Eigen::VectorXd gain(2 * tactels), offset(2 * tactels);
    for (Index i = 0; i < 2 * tactels; ++i) {
      const Fitted& g = c.gain[static_cast<std::size_t>(i)];
      within += std::abs(g.value - s.gain[i]) <= 2 * g.deviation;
      ++gains;
      gain[i] = g.value, offset[i] = c.offset[static_cast<std::size_t>(i)].value;
    }
    young_within += std::abs(c.young.value - s.young) <= 2 * c.young.deviation;
    error_true += error_of_S(s, s.gain, s.offset);
    error_calibrated += error_of_S(s, gain, offset);
    error_factory += error_of_S(s, Eigen::VectorXd::Constant(2 * tactels, 0.001), offset);
  }
  const double share = static_cast<double>(within) / gains;
  printf(
      "%d sensors: %.4f of gains and %d of E within 2 deviations; error of S: true %.4f, calibrated %.4f, factory "
      "gains %.4f\n",
      sensors, share, young_within, error_true / sensors, error_calibrated / sensors, error_factory / sensors);
  // 95.4 % of a normal distribution; gains of one sensor share the error of E.
  EXPECT_GE(share, sensors < 100 ? 0.92 : 0.95);
  EXPECT_LE(error_calibrated, 1.1 * error_true);
  EXPECT_GT(error_factory, 2 * error_true);
}

TEST(SensorCalibration, FindsGainsOfSimulatedSensors) { check_sensors(8); }
TEST(SensorCalibrationNightly, FindsGainsOfTwoHundredSensors) { check_sensors(200); }

TEST(SensorCalibration, DeadAndSwappedChannelsAreNamed) {
  Simulated s = simulate(1);
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (KnownPress& press : s.presses) {
    press.readings.col(3).setConstant(7);
    for (double& x : press.readings.col(30)) x = 2000 + 3 * normal(random);
    press.readings.col(8).swap(press.readings.col(12));
  }
  const SensorCalibration c = calibrate(s);
  std::map<int, CalibrationFault::Kind> faults;
  for (const CalibrationFault& fault : c.faults) faults[fault.channel] = fault.kind;
  EXPECT_EQ(faults.size(), 3u);
  EXPECT_EQ(faults[3], CalibrationFault::Kind::dead_channel);
  EXPECT_EQ(faults[30], CalibrationFault::Kind::dead_channel);
  EXPECT_EQ(faults[8], CalibrationFault::Kind::swapped_channels);
  for (const int channel : {3, 8, 12, 30}) EXPECT_TRUE(std::isnan(c.gain[static_cast<std::size_t>(channel)].value));
  EXPECT_NEAR(c.gain[10].value, s.gain[10], 4 * c.gain[10].deviation);
}

TEST(SensorCalibration, AWrongPressIsNamedAndLeftOut) {
  Simulated s = simulate(2);
  s.presses[6].scene.indenter = {fem::Wedge{150}, s.presses[6].scene.indenter.position + 1};
  const SensorCalibration c = calibrate(s);
  ASSERT_EQ(c.faults.size(), 1u);
  EXPECT_EQ(c.faults[0].kind, CalibrationFault::Kind::wrong_press);
  EXPECT_EQ(c.faults[0].press, 6);
  EXPECT_THAT(c.faults[0].text, testing::HasSubstr("press 7"));
  EXPECT_NEAR(c.young.value, s.young, 4 * c.young.deviation);
}

TEST(SensorCalibration, SaturatedReadingsAreLeftOut) {
  Simulated s = simulate(3);
  CalibrationOptions options;
  const double low = s.presses[10].readings.minCoeff();
  options.lowest_reading = low + 0.1 * (2048 - low);
  for (KnownPress& press : s.presses) press.readings = press.readings.cwiseMax(options.lowest_reading);
  const SensorCalibration c = calibrate(s, options);
  ASSERT_FALSE(c.faults.empty());
  for (const CalibrationFault& fault : c.faults) EXPECT_EQ(fault.kind, CalibrationFault::Kind::saturated);
  EXPECT_NEAR(c.young.value, s.young, 4 * c.young.deviation);
}

TEST(SensorCalibration, AllPressesWithAnotherIndenter) {
  Simulated s = simulate(2);
  CalibrationOptions options;
  options.noise = s.noise / s.gain.array();
  for (KnownPress& press : s.presses) std::get<fem::Cylinder>(press.scene.indenter.shape).radius *= 0.3;
  const SensorCalibration c = calibrate(s, options);
  EXPECT_TRUE(std::ranges::any_of(
      c.faults, [](const CalibrationFault& fault) { return fault.kind == CalibrationFault::Kind::wrong_indenter; }));
}

TEST(SensorCalibration, WithoutForcesYoungIsHeld) {
  Simulated s = simulate(4);
  for (KnownPress& press : s.presses) press.P.resize(0);
  const SensorCalibration c = calibrate(s);
  EXPECT_EQ(c.young.value, nominal_young);
  EXPECT_EQ(c.young.deviation, 0);
  ASSERT_FALSE(c.held.empty());
  EXPECT_THAT(c.held[0], testing::HasSubstr("sensor.young is held"));
  // Gains are those of the nominal E: stress over E is what the readings tell.
  EXPECT_NEAR(c.gain[10].value / s.gain[10], nominal_young / s.young, 0.02);
}

TEST(SensorCalibration, WrongSizesAreRefused) {
  Simulated s = simulate(4);
  s.presses[2].readings.conservativeResize(4, 2 * tactels);
  s.presses[2].P.resize(0);
  EXPECT_THROW(calibrate(s), ValueError);
  EXPECT_THROW(calibrate_sensor(family(), {}, nominal()), ValueError);
}

}  // namespace
}  // namespace tactel::host
