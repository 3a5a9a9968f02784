// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <span>

#include "fem/layer/patch_solver.h"
#include "fem/layer/sensor_family.h"

namespace tactel::host {

/// What a calibration asks of the rubber; all but the gains and offsets of transducers.
struct RubberState {
  double log_young = 0;  ///< of E in MPa
  double poisson = 0.45;
  double thickness = 1.5;  ///< mm
  double shift = 0;        ///< mm along x, of all tactels from their nominal places
};

inline constexpr int rubber_numbers = 4;  ///< in the order of RubberState
inline constexpr const char* rubber_names[rubber_numbers] = {"ln E", "sensor.poisson", "sensor.thickness", "shift"};

/// Frames and forces of one press, and their derivatives by the numbers of a RubberState.
struct PressFrames {
  Eigen::MatrixXd frame;                     ///< [steps, 2 tactels] MPa: sigma_y, then tau_xy
  Eigen::VectorXd P;                         ///< [steps] N/mm
  Eigen::MatrixXd frame_by[rubber_numbers];  ///< [steps, 2 tactels]; empty where not asked for
  Eigen::VectorXd P_by[rubber_numbers];      ///< [steps]
};

/// One press or drag of a known indenter on a sensor whose rubber is to be found. The patch is searched once, at the
/// first state, so that answers change smoothly with the state.
class PressModel {
 public:
  /// `scene`: indenter, friction, load, and the nominal sensor, of which E, poisson and thickness are replaced. Throws
  /// ValueError for a scene that the family does not serve, fem::PathError where the sweeps do not converge.
  PressModel(const fem::SensorFamily& family, const fem::Scene& scene, const RubberState& first, int elements);

  /// Returns frames and forces at a state, with derivatives by these numbers. Throws as the constructor.
  PressFrames at(const RubberState& state, std::span<const int> numbers = {}) const;

  const fem::Scene& scene() const { return scene_; }

 private:
  fem::Sensor sensor_at(const RubberState& state) const;

  fem::SensorFamily family_;
  fem::Scene scene_;
  fem::PatchOptions options_;
  fem::Patch patch_;
};

}  // namespace tactel::host
