// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "host/calibration/press_plan.h"

namespace tactel::host {

/// Contents of a list of candidates (docs/calibration.md: every key).
struct CandidateList {
  std::vector<PressCandidate> candidates;
  CalibrationOptions fit;
  std::string fit_text;  ///< the tables [fit] and [transducer], for the plan's file
};

/// Returns presses with what a laboratory has, on the sensor and with the friction of `nominal`: rods of radius 3, 6
/// and 15 mm, a flat of 4 mm and a wedge of 150 degrees, at 11 places, two depths, without and with drags to both
/// sides.
std::vector<PressCandidate> usual_candidates(const fem::Scene& nominal);

/// Reads a list: each table names a scene, and the places, depths and drags at which it is a candidate. Throws
/// ConfigError for a wrong file, and for a sensor without the tactels of `tactels`.
CandidateList read_candidates(const std::filesystem::path& path, std::size_t tactels);

/// Returns when a planned press moves and is read: a second at rest, then a second for each load step.
PressTiming planned_timing(std::size_t steps);
inline constexpr double planned_window = 0.4;  ///< s, over which it is read

/// The files of a plan, named after the plan's: recordings to fill in, and a scene for each press.
struct PlanFile {
  std::filesystem::path path;
  std::string text;
};
std::vector<PlanFile> plan_files(const std::filesystem::path& path, const std::vector<PressCandidate>& chosen,
                                 const std::string& fit_text, bool forces);

}  // namespace tactel::host
