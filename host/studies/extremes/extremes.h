// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <variant>
#include <vector>

#include "fem/pad/pad_scene.h"
#include "fem/scenes/scene.h"
#include "host/device/executor.h"

namespace tactel::host {

struct ExtremeScene {
  std::string group, name;
  std::variant<fem::Scene, fem::PadScene> scene;
};

/// Returns the scenes of the table of extremes: one quantity at a time takes its extreme values, on meshes, then on
/// patches, then on pads. `finest`: with the mesh of 401 x 101.
std::vector<ExtremeScene> extreme_scenes(bool finest);

/// Returns the scene that the extremes vary: a parabola on mesh B, pressed in, dragged until it nearly slides, and
/// back.
fem::Scene ordinary_scene();

/// Answer of one solver to an extreme scene.
struct ExtremeAnswer {
  bool solved = false;     ///< every step met its tolerance
  bool fell_back = false;  ///< the exact fallback answered
  int iterations = 0;      ///< most in a step
  double residual = 0;     ///< worst of the certificates
  double off = 0;          ///< forces on the base, of patches those of elements, of pads of cells, beside the
                           ///< reference's (fem::base_force_difference); NaN where one is NaN
};

/// One line of the table.
struct Extreme {
  std::string model;  ///< "mesh", "patch", "pad"
  std::string group, name;
  ExtremeAnswer fp32, fp64, reference;
  std::string told;  ///< warnings to the user beside the answer
};

/// Solves every extreme by the batched solver, in fp32 and fp64, and by the reference: on meshes the exact solver, on
/// the same elements or cells the twin, in fp64 to 1e-9 (the exact solver where a patch does not settle). `quick`:
/// without the mesh of 401 x 101, and with short paths in the findings; seconds instead of minutes.
std::vector<Extreme> scene_extremes(Executor& executor, bool quick, const Progress& progress = {});

/// P and Q of a contact after each load step. [steps] N/mm
struct ForcePath {
  std::vector<double> P, Q;
};

/// Returns the drift of a path that alternates between two positions from step `first` on: the largest difference of P
/// or Q from its value in the first round at the same position, over P of step `first`. NaN where a force is NaN.
double loop_drift(const ForcePath& path, std::size_t first);

/// Result of a test of long paths, several solutions or wrong input: its question and its finding.
struct ExtremeFinding {
  std::string question, found;
  bool good = false;  ///< the finding is the required one
};
std::vector<ExtremeFinding> extreme_findings(Executor& executor, bool quick);

std::string extremes_table(const std::vector<Extreme>& extremes);
std::string findings_table(const std::vector<ExtremeFinding>& findings);

}  // namespace tactel::host
