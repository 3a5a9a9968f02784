// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string>
#include <vector>

#include "fem/contact_solution.h"
#include "fem/scene.h"
#include "host/device/executor.h"
#include "host/studies/paper/hand_press.h"
#include "nn/frame_set.h"
#include "nn/transducer_chain.h"

namespace tactel::host {

/// Section VI of the paper: the contacts of its sensor of eight tactels, and its readings.

/// One of the paper's seven indenters.
struct RealIndenter {
  std::string name;
  fem::Shape shape;
};
const std::vector<RealIndenter>& real_indenters();

/// One combination of the paper: an indenter at a position, loaded by a force at an angle to the normal.
struct RealContact {
  std::uint16_t indenter = 0;          ///< index in real_indenters()
  double position = 0;                 ///< mm
  double limit_angle = 25, angle = 0;  ///< degrees: of friction; of the force
  double friction() const;             ///< mu = tan(limit_angle)
  double slip_index() const;           ///< S = tan(angle) / tan(limit_angle), equation (5)
  bool operator==(const RealContact&) const = default;
};
/// Returns all 7 x 3 x (2 + 3) = 105 combinations: 30 degrees only where the limit is 38, as in the paper.
std::vector<RealContact> real_contacts();

/// Choice of the parameters that the paper leaves open.
struct RealSensorChoice {
  fem::Sensor sensor;
  /// N/mm, of all contacts. The sharpest edge then reaches 0.26 mm, within the 20 % of the thickness up to
  /// which the rubber is linear (section IV).
  double normal_force = 0.25;
  int increments = 10;   ///< load steps in which normal and tangential force grow together
  nn::Transducer chain;  ///< except its seed
  Record record;
};
RealSensorChoice real_sensor_choice();

/// Returns the contact, loaded from 0 to the full force at its angle.
fem::Scene real_scene(const RealSensorChoice& choice, const RealContact& contact);

/// Solves all contacts in fp64. Throws std::runtime_error where a step misses its tolerance.
std::vector<fem::ContactSolution> solve_real_contacts(Executor& executor, const RealSensorChoice& choice,
                                                      const std::vector<RealContact>& contacts);

/// Returns the stresses under full load, a row each. Shape classes are indices in real_indenters().
nn::FrameSet ideal_frames(const std::vector<RealContact>& contacts, const std::vector<fem::ContactSolution>& solutions);

/// Returns the readings of the same contacts, each pressed by hand, [contacts, samples, 2 tactels] MPa. The
/// sensor is not calibrated. `seed` draws the sensor, the presses and the noise.
std::vector<float> read_records(Executor& executor, const RealSensorChoice& choice,
                                const std::vector<fem::ContactSolution>& solutions, std::uint64_t seed);

/// Returns the sample with the highest normal stress of each record.
nn::FrameSet recorded_frames(const std::vector<RealContact>& contacts,
                             const std::vector<fem::ContactSolution>& solutions, std::span<const float> records);

}  // namespace tactel::host
