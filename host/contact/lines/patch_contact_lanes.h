// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <vector>

#include "fem/layer/patch_path.h"
#include "fem/scenes/scene.h"
#include "kernels/shared/patch_layout.h"

namespace tactel::host {

/// A scene's load path in increments, as the kernel takes it.
struct PatchPath {
  std::vector<fem::PatchStep> steps;  ///< with increments between those that the scene asks for
  int slots = 0;                      ///< load steps of the scene
  int indentation_slots = 0;          ///< those of the indentation
  int pressing_increments = 0;        ///< increments of the indentation
  bool until_sliding = false;
  double most = 0;  ///< largest depth mm, or largest P N/mm
};

/// Returns the path of a load with at least this number of increments to each pressing target
/// (fem/layer/patch_path.h). `path`: load_path(load).
PatchPath patch_path(const fem::LoadPath& path, const fem::Load& load, int pressing_increments);

/// What the kernel gets of one scene: its rows of PatchInputRow, and its part of `shapes`.
struct PatchLane {
  double input[PATCH_INPUT_ROWS] = {};
  std::vector<double> shape;  ///< terms or points; empty for most shapes
};

/// A contact that a patch must cover, mm from the indenter's position.
struct PatchContactExtent {
  double left = 0, right = 0;
};

/// Returns the input of a scene; PATCH_TERMS_AT and PATCH_POINTS_AT count from its own `shape`. With `given` the kernel
/// lays the patch there instead of searching.
PatchLane patch_lane(const fem::Scene& scene, const PatchPath& path, const std::optional<PatchContactExtent>& given);

}  // namespace tactel::host
