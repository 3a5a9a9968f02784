#pragma once
#include <span>
#include <string>
#include <vector>

#include "fem/contact_solution.h"
#include "fem/scene.h"
#include "host/executor.h"
#include "host/hand_press.h"
#include "nn/frame_set.h"
#include "nn/transducer_chain.h"

namespace tactel::host {

/// The paper's section VI again: what its sensor of eight tactels meets, and what is read of it.

/// One of the paper's seven indenters.
struct RealIndenter {
  std::string name;
  fem::Shape shape;
};
const std::vector<RealIndenter>& real_indenters();

/// One combination of the paper's: an indenter at a place, pushed by a force at an angle to the normal.
struct RealContact {
  std::uint16_t indenter = 0;          ///< place in real_indenters()
  double position = 0;                 ///< mm
  double limit_angle = 25, angle = 0;  ///< degrees: of friction; of the force
  double friction() const;             ///< mu = tan(limit_angle)
  double slip_index() const;           ///< S = tan(angle) / tan(limit_angle), equation (5)
  bool operator==(const RealContact&) const = default;
};
/// All 7 x 3 x (2 + 3) = 105: 30 degrees only where the limit is 38, as in the paper.
std::vector<RealContact> real_contacts();

/// What the paper leaves open, as chosen.
struct RealSensorChoice {
  fem::Sensor sensor;
  /// N/mm, of all contacts: the sharpest edge then goes 0.26 mm deep, within the 20 % of the thickness up to which the
  /// rubber is linear (section IV).
  double normal_force = 0.25;
  int increments = 10;   ///< in which normal and tangential force grow together
  nn::Transducer chain;  ///< but for its seed
  Record record;
};
RealSensorChoice real_sensor_choice();

/// The contact, loaded from nothing to the full force at its angle.
fem::Scene real_scene(const RealSensorChoice& choice, const RealContact& contact);

/// All contacts solved, in fp64. Throws std::runtime_error where a step does not meet its tolerance.
std::vector<fem::ContactSolution> solve_real_contacts(Executor& executor, const RealSensorChoice& choice,
                                                      const std::vector<RealContact>& contacts);

/// The stresses themselves under full load, a row each; shape classes are places in real_indenters().
nn::FrameSet ideal_frames(const std::vector<RealContact>& contacts, const std::vector<fem::ContactSolution>& solutions);

/// What a computer reads of the same contacts, each pressed by hand, [contacts, samples, 2 tactels] MPa. The sensor was
/// not calibrated. `seed` makes the sensor, the presses and the noise.
std::vector<float> read_records(Executor& executor, const RealSensorChoice& choice,
                                const std::vector<fem::ContactSolution>& solutions, std::uint64_t seed);

/// Of each record the sample with the highest normal stress.
nn::FrameSet recorded_frames(const std::vector<RealContact>& contacts,
                             const std::vector<fem::ContactSolution>& solutions, std::span<const float> records);

}  // namespace tactel::host
