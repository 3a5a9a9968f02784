// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "fem/scenes/indenter.h"
#include "fem/scenes/sensor.h"

namespace tactel::fem {

using tactel::Load, tactel::LoadMove;

/// Target of one load increment.
struct LoadStep {
  bool normal_is_force = false;
  bool tangential_is_force = false;
  double normal = 0.0;      ///< indentation, mm, or P, N/mm
  double tangential = 0.0;  ///< indenter position along x since first touch, mm, or Q, N/mm
  bool operator==(const LoadStep&) const = default;
};

/// The increments of a load path. A path until sliding has `most_tangential_steps` and `until_sliding` set.
struct LoadPath {
  std::vector<LoadStep> steps;
  int indentation_steps = 0;  ///< number of them that belong to the indentation
  bool until_sliding =
      false;  ///< stop after the first tangential increment in which no node sticks: all that touch slip
};
inline constexpr int most_tangential_steps = 1000;
inline constexpr int most_indentation_steps = 1000;  // for each target

/// Model of a contact: gap elements on the mesh of the block, or elements on the scene's own patch (fem/layer).
enum class SurfaceModel { mesh, patch };

/// One contact: the contents of a scene file.
struct Scene {
  std::string title;
  Sensor sensor;
  Indenter indenter;
  double friction = 0.5;  ///< mu >= 0; infinite: touching nodes stick until they lift off ("bonded")
  Load load;
  SurfaceModel model = SurfaceModel::mesh;
  void validate() const;  ///< throws ValueError, keys as in scene files
};

LoadPath load_path(const Load& load);

/// Returns true where the scene's normal load is a force instead of a depth.
inline bool by_force(const Scene& scene) { return !scene.load.normal_force.empty(); }

}  // namespace tactel::fem
