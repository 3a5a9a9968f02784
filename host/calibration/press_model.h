// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "fem/layer/patch_solver.h"
#include "fem/layer/sensor_family.h"
#include "host/calibration/press_timing.h"
#include "host/scenes/scene_file.h"

namespace tactel::host {

/// What a calibration asks of a sensor, all but the gains and offsets of its transducers.
struct SensorState {
  double log_young = 0;  ///< of E in MPa
  double poisson = 0.45;
  double thickness = 1.5;         ///< mm
  double shift = 0, shift_y = 0;  ///< mm along x and, of a pad, y, of all tactels from their nominal places
  double log_time_constant = std::numeric_limits<double>::infinity();  ///< of RC in s; infinite: no decay
};

/// A number by which frames have derivatives.
enum PressNumber : int {
  young_number,  // of the sensor, in the order of SensorState: its logarithm
  poisson_number,
  thickness_number,
  shift_number,
  shift_y_number,
  time_constant_number,  // its logarithm
  friction_number,       // of the press
  tilt_number,           // degrees, of the indenter along its x
  tilt_y_number,         // and on a pad along its y
  depth_number,          // mm, the zero of the depth
  load_number,           // its given forces, relative
  shape_number           // the first number of its shape; the others follow, as many as shape_numbers() has
};
inline constexpr int sensor_numbers = friction_number;

/// A number of the sensor.
struct SensorNumber {
  const char *key, *label, *unit;  ///< in JSON; for people; of its value
  const char* fitted;              ///< name of what a fit changes
  double SensorState::*member;
  bool logarithm = false;  ///< the member is the number's logarithm
};
inline constexpr SensorNumber sensor_table[sensor_numbers] = {
    {"young", "sensor.young", "MPa", "ln E", &SensorState::log_young, true},
    {"poisson", "sensor.poisson", "", "sensor.poisson", &SensorState::poisson},
    {"thickness", "sensor.thickness", "mm", "sensor.thickness", &SensorState::thickness},
    {"shift", "shift of the tactels", "mm", "shift", &SensorState::shift},
    {"shift_y", "shift along y", "mm", "shift along y", &SensorState::shift_y},
    {"time_constant", "transducer.time_constant", "s", "ln transducer.time_constant", &SensorState::log_time_constant,
     true}};

/// A number of the indenter's shape.
struct ShapeNumber {
  std::string key;  ///< as in scene files, such as "radius"
  std::string unit;
  double value;
  bool operator==(const ShapeNumber&) const = default;
};

// What a calibration asks of a scene, of either kind of sensor.
double friction_of(const AnyScene& scene);
bool by_force(const AnyScene& scene);
/// Returns the numbers of a frame, and the tactels.
Eigen::Index channels_of(const AnyScene& scene);
Eigen::Index tactels_of(const AnyScene& scene);
/// Returns the numbers of the shape that move none of its sharp edges.
std::vector<ShapeNumber> shape_numbers(const AnyScene& scene);

/// Frames and forces of one press, and their derivatives by the numbers of a SensorState and of the press.
struct PressFrames {
  Eigen::MatrixXd
      frame;          ///< [steps, channels] MPa, as amplifiers read them: normal stresses of all tactels, then shear
  Eigen::VectorXd P;  ///< [steps] N/mm; of a pad N
  std::map<PressNumber, Eigen::MatrixXd> frame_by;  ///< [steps, channels] by the numbers that were asked for
  std::map<PressNumber, Eigen::VectorXd> P_by;      ///< [steps]
};

/// One press or drag of a known indenter on a sensor that is to be found. Where it touches is searched once, at the
/// first state, so that answers change smoothly with the state.
class PressModel {
 public:
  virtual ~PressModel() = default;

  /// Returns frames and forces at a state and a friction, with derivatives by these numbers. Throws fem::PathError
  /// where the sweeps do not converge.
  PressFrames at(const SensorState& state, double friction, std::span<const PressNumber> numbers = {}) const;

 protected:
  /// `timing` is asked for where readings decay.
  explicit PressModel(const PressTiming& timing) : timing_(timing) {}

 private:
  /// Stresses and forces, with derivatives by all of these numbers but the time constant.
  virtual PressFrames stresses(const SensorState& state, double friction,
                               std::span<const PressNumber> numbers) const = 0;
  void amplify(double log_time_constant, std::span<const PressNumber> numbers, PressFrames& frames) const;

  PressTiming timing_;
};

/// A press on a line, with derivatives by fem/path_derivatives.h.
class LinePress : public PressModel {
 public:
  /// `scene`: indenter, friction, load, and the nominal sensor, of which E, poisson and thickness are replaced. Throws
  /// ValueError for a scene that the family does not serve, fem::PathError where the sweeps do not converge.
  LinePress(const fem::SensorFamily& family, const fem::Scene& scene, const PressTiming& timing,
            const SensorState& first, int elements);

 private:
  PressFrames stresses(const SensorState& state, double friction, std::span<const PressNumber> numbers) const override;
  fem::Sensor sensor_at(const SensorState& state) const;

  fem::SensorFamily family_;
  fem::Scene scene_;
  fem::PatchOptions options_;
  fem::Patch patch_;
};

}  // namespace tactel::host
