#pragma once
#include <span>
#include <vector>

#include "fem/scene.h"
#include "kernels/shared/patch_layout.h"

namespace tactel::host {

/// Target of one increment of a patch path.
struct PatchStep {
  double normal = 0;      ///< indentation mm, or P N/mm
  double tangential = 0;  ///< mm, or Q N/mm
  int slot = -1;          ///< the load step of the scene that ends here; -1: none
};

/// A scene's load path with increments between: pressing to the largest depth (or force) takes at least a third of
/// the number of elements, because friction remembers how contact grew.
struct PatchPath {
  std::vector<PatchStep> steps;
  int slots = 0;               ///< load steps of the scene
  int indentation_slots = 0;   ///< those of the indentation
  int pressing_increments = 0; ///< increments of the indentation
  bool until_sliding = false;
  double most = 0;  ///< largest depth mm, or largest P N/mm
};

/// A load step that changes the depth by a share s of the largest one becomes ceil(s elements / 3) equal increments.
PatchPath patch_path(const fem::Scene& scene, int elements);

/// What the kernel gets of one scene: its rows of PatchInputRow, and its part of `shapes`.
struct PatchLane {
  double input[PATCH_INPUT_ROWS] = {};
  std::vector<double> shape;  ///< terms or points; empty for most shapes
};

/// Returns the input of a scene; PATCH_TERMS_AT and PATCH_POINTS_AT count from its own `shape`. `hull`: of a measured
/// profile.
PatchLane patch_lane(const fem::Scene& scene, const PatchPath& path);

}  // namespace tactel::host
