// SPDX-License-Identifier: Apache-2.0

// Simulated pads, whose gains, offsets, E, nu and H the calibration does not know. Their frames come from finer cells
// and more increments than the fit and its correction take.
#include <gmock/gmock.h>

#include "fem/angles.h"
#include "fem/value_error.h"
#include "host/calibration/pad_press.h"
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
    EXPECT_THAT(texts(c), testing::IsEmpty()) << k;
    for (Eigen::Index i = 0; i < s.gain.size(); ++i)
      deviation += c.gain[static_cast<std::size_t>(i)].deviation / s.gain[i], sum.gains += 1;
    sum.gains_within += gains_within(c, s.gain);
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

/// For the quick set: 8 cells a side, corrected by 16; frames from 24.
constexpr int few_elements = 16;
const PadAs few_cells{.cells = 24, .drag_increments = 3};

TEST(PadCalibration, FindsTwoPads) {
  const Tally found = calibrate_pads(2, few_elements, few_cells);
  EXPECT_GE(found.gains_within, 0.85 * found.gains);  // of one pad they share the error of E
  // Of six numbers two beyond two deviations have a probability of 3 %.
  EXPECT_GE(found.young + found.poisson + found.thickness, 4);
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

SensorCalibration calibrate(const SimulatedPad& s, CalibrationOptions options = {}) {
  options.elements = few_elements;
  options.rest_noise = s.noise / s.gain.array();
  return calibrate_pad(s.presses, nominal_pad(), options);
}

TEST(PadCalibration, FaultsOfChannelsAreNamed) {
  SimulatedPad s = simulate_pad(3, pad_presses(), few_cells);
  for (KnownPress& press : s.presses) {
    press.readings.col(37).setConstant(20000);
    press.readings.col(17).swap(press.readings.col(40));
  }
  CalibrationOptions options{.fit_thickness = true};
  Eigen::Index row = 0, lowest = 0;
  double least = 1e9;
  for (const KnownPress& press : s.presses)
    if (press.readings.minCoeff() < least) least = press.readings.minCoeff(&row, &lowest);
  options.lowest_reading = least;
  const SensorCalibration c = calibrate(s, options);
  using testing::HasSubstr;
  EXPECT_THAT(texts(c),
              testing::UnorderedElementsAre(
                  HasSubstr("shear stress along y of tactel 5: the reading never changes"),
                  HasSubstr("shear stress along x of tactel 1 and shear stress along y of tactel 8 are swapped"),
                  HasSubstr(transducer_name(lowest, 48, 16) + ": 1 of 100 readings are at an end")));
  for (const std::size_t channel : {37u, 17u, 40u}) EXPECT_TRUE(std::isnan(c.gain[channel].value)) << channel;
  EXPECT_NEAR(c.gain[20].value, s.gain[20], 4 * c.gain[20].deviation);
}

TEST(PadCalibration, TheTiltOfAFlatIsNamed) {
  const double tilt = 0.5, rise = 2.5 * std::tan(fem::radians(tilt));  // degrees; mm of the edge
  std::vector<KnownPress> presses = pad_presses();
  for (KnownPress& press : presses) {
    fem::PadScene& scene = pad(press);
    if (!std::holds_alternative<fem::Punch>(scene.indenter.shape)) continue;
    scene.indenter.tilt = tilt, scene.indenter.tilt_direction = 90;
    const double depth = scene.load.indentation[0];
    scene.load.indentation = {depth / 2 + rise, depth + rise};  // the same at the axis
    scene.load.indentation_steps = 1;
  }
  SimulatedPad s = simulate_pad(4, presses, few_cells);
  presses = pad_presses();
  for (std::size_t k = 0; k < presses.size(); ++k) s.presses[k].scene = presses[k].scene;
  EXPECT_THAT(texts(calibrate(s, {.fit_thickness = true})),
              testing::Contains(testing::HasSubstr("tilt of the indenters along their y")));
}

/// Answers elsewhere, of presses that are made there, follow the derivatives.
TEST(PadPress, DerivativesFollowTheAnswers) {
  const std::vector<KnownPress> all = pad_presses();
  const SensorState state = nominal_pad();
  constexpr int cells = 16;
  constexpr PressNumber numbers[] = {young_number,    poisson_number, thickness_number, shift_number, shift_y_number,
                                     friction_number, tilt_number,    tilt_y_number,    depth_number, shape_number};
  for (const KnownPress* press : {&all[6], &all[17]}) {  // a sphere, a flat
    const fem::PadScene scene = pad(*press);
    const bool flat = std::holds_alternative<fem::Punch>(scene.indenter.shape);
    const PressFrames here =
        PadPress(scene, {}, state, cells, 1).at(state, scene.friction, std::span(numbers).first(flat ? 9 : 10));
    const auto check = [&](const char* what, PressNumber number, double step, const fem::PadScene& there,
                           const SensorState& at, double tolerance) {
      const PressFrames to = PadPress(there, {}, at, cells, 1).at(at, there.friction);
      const Eigen::MatrixXd change = to.frame - here.frame;
      EXPECT_LE((change - step * here.frame_by.at(number)).norm(), tolerance * change.norm() + 1e-9 * here.frame.norm())
          << what << ' ' << flat;
      const Eigen::VectorXd P = to.P - here.P;
      EXPECT_LE((P - step * here.P_by.at(number)).norm(), tolerance * P.norm() + 1e-5 * here.P.norm()) << what << flat;
    };
    // Curvature over a step of some percent, and other cells where the contact is another.
    const auto moved = [&](double SensorState::*member, double step) {
      SensorState at = state;
      at.*member += step;
      return at;
    };
    check("E", young_number, 0.02, scene, moved(&SensorState::log_young, 0.02), 0.03);
    check("nu", poisson_number, 0.01, scene, moved(&SensorState::poisson, 0.01), 0.25);
    check("H", thickness_number, 0.1, scene, moved(&SensorState::thickness, 0.1), 0.25);
    fem::PadScene there = scene;
    there.indenter.position[0] -= 0.05;  // as tactels that lie farther along x
    check("shift", shift_number, 0.05, there, state, 0.06);
    there = scene, there.indenter.position[1] -= 0.05;
    check("shift y", shift_y_number, 0.05, there, state, 0.06);
    there = scene, there.friction += 0.04;
    check("friction", friction_number, 0.04, there, state, 0.25);
    there = scene, there.load.indentation[0] += 0.02;
    there.load.indentation.insert(there.load.indentation.begin(), scene.load.indentation[0] / 2 + 0.02);
    there.load.indentation_steps = 1;
    check("depth", depth_number, 0.02, there, state, 0.25);
    if (!flat) {
      there = scene, std::get<fem::Sphere>(there.indenter.shape).radius *= 1.05;
      check("radius", shape_number, 0.05 * std::get<fem::Sphere>(scene.indenter.shape).radius, there, state, 0.25);
      continue;
    }
    for (const int axis : {0, 1}) {  // its height at the axis stays: tan(tilt) radius is the rise of the edge
      there = scene, there.indenter.tilt = 0.2, there.indenter.tilt_direction = 90 * axis;
      const double rise = std::tan(fem::radians(0.2)) * std::get<fem::Punch>(scene.indenter.shape).radius;
      there.load.indentation = {scene.load.indentation[0] / 2 + rise, scene.load.indentation[0] + rise};
      there.load.indentation_steps = 1;
      check("tilt", axis == 0 ? tilt_number : tilt_y_number, 0.2, there, state, 0.25);
    }
  }
}

TEST(PadPress, ContactsAtAnEdgeAreRefused) {
  KnownPress press = pad_presses().front();
  pad(press).sensor.length = 16;
  press.readings = Eigen::MatrixXd::Zero(5, 48);
  EXPECT_THAT([&] { calibrate_pad({press}, nominal_pad()); },
              testing::Throws<ValueError>(testing::Field(&ValueError::key, "press 1: indenter.position")));
}

}  // namespace
}  // namespace tactel::host
