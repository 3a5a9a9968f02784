// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <array>
#include <limits>
#include <span>

#include "fem/layer/patch_solver.h"
#include "fem/layer/sensor_family.h"
#include "host/calibration/press_timing.h"

namespace tactel::host {

/// What a calibration asks of a sensor, all but the gains and offsets of its transducers.
struct SensorState {
  double log_young = 0;  ///< of E in MPa
  double poisson = 0.45;
  double thickness = 1.5;  ///< mm
  double shift = 0;        ///< mm along x, of all tactels from their nominal places
  double log_time_constant = std::numeric_limits<double>::infinity();  ///< of RC in s; infinite: no decay
};

inline constexpr int sensor_numbers = 5;  ///< in the order of SensorState
inline constexpr const char* sensor_names[sensor_numbers] = {"ln E", "sensor.poisson", "sensor.thickness", "shift",
                                                             "ln transducer.time_constant"};
inline constexpr int time_constant_number = 4;
/// Beside them, numbers of the press itself: its friction; tilt of the indenter, degrees; zero of the depth, mm; its
/// given forces, relative; the first numbers of its shape (fem/shape_derivatives.h).
inline constexpr int friction_number = sensor_numbers, tilt_number = friction_number + 1,
                     depth_number = tilt_number + 1, load_number = depth_number + 1, shape_number = load_number + 1,
                     most_shape_numbers = 2, press_numbers = shape_number + most_shape_numbers;

/// Frames and forces of one press, and their derivatives by the numbers of a SensorState and of the press.
struct PressFrames {
  Eigen::MatrixXd frame;  ///< [steps, 2 tactels] MPa: sigma_y, then tau_xy, as amplifiers read them
  Eigen::VectorXd P;      ///< [steps] N/mm
  std::array<Eigen::MatrixXd, press_numbers> frame_by;  ///< [steps, 2 tactels]; empty where not asked for
  std::array<Eigen::VectorXd, press_numbers> P_by;      ///< [steps]
};

/// One press or drag of a known indenter on a sensor that is to be found. The patch is searched once, at the
/// first state, so that answers change smoothly with the state.
class PressModel {
 public:
  /// `scene`: indenter, friction, load, and the nominal sensor, of which E, poisson and thickness are replaced.
  /// `timing` is asked for where readings decay. Throws ValueError for a scene that the family does not serve,
  /// fem::PathError where the sweeps do not converge.
  PressModel(const fem::SensorFamily& family, const fem::Scene& scene, const PressTiming& timing,
             const SensorState& first, int elements);

  /// Returns frames and forces at a state and a friction, with derivatives by these numbers. Throws as the constructor.
  PressFrames at(const SensorState& state, double friction, std::span<const int> numbers = {}) const;

  const fem::Scene& scene() const { return scene_; }

 private:
  fem::Sensor sensor_at(const SensorState& state) const;
  void amplify(double log_time_constant, std::span<const int> numbers, PressFrames& frames) const;

  fem::SensorFamily family_;
  fem::Scene scene_;
  PressTiming timing_;
  fem::PatchOptions options_;
  fem::Patch patch_;
};

}  // namespace tactel::host
