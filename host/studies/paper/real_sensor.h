// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string>
#include <vector>

#include "fem/gap/contact_solution.h"
#include "fem/scenes/scene.h"
#include "host/device/executor.h"
#include "nn/frame_set.h"
#include "nn/transducer_chain.h"

namespace tactel::host {

/// Section VI of the paper: the contacts of its sensor of eight tactels, and its readings while a hand presses it.

/// A record of a sensor while an indenter is pressed on it by hand (the paper, sections III and VII.B).
struct Record {
  double seconds = 10, rate = 100;  ///< s, Hz
  std::uint32_t samples() const;
};

/// Times of a press: start, linear rise, hold and linear release. s
struct HandPress {
  double start = 3, rise = 1, hold = 1.5, release = 0.5;
  double load(double t) const;  ///< load at time t over the full load: 0 ... 1
};
/// Returns a random press: it starts after 2 to 5 s, rises within 0.5 to 1.5 s, holds for 1 to 2 s and is
/// released within 0.3 to 0.7 s, each uniformly distributed. It uses words 0 ... 3 of random_words(seed, contact,
/// number).
HandPress hand_press(std::uint64_t seed, std::uint32_t number);

/// Returns the stress at the transducers, [samples, 2 tactels] MPa, normal stresses first. The steps of
/// `solution` are equal parts of the load, with linear stress between them. The release retraces the press,
/// without the slip of a real release. A sample taken before the release is not affected.
std::vector<float> pressed_record(const fem::ContactSolution& solution, const HandPress& press, const Record& record);

/// Returns the sample of a record [samples, channels], normal stresses first, with the strongest compression at
/// any single transducer.
std::size_t highest_normal_sample(std::span<const float> record, std::size_t channels);

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
