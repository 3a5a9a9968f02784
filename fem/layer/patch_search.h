// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/layer/layer_table.h"
#include "fem/layer/patch.h"
#include "fem/scenes/scene.h"

namespace tactel::fem {

// Search of the patch that an indenter touches at most along its load path, by contacts without friction on an endless
// layer with few elements. The true contact is 0.47 to 1.34 times as wide as the rigid profile's section at the
// surface. Three rounds, each on `search_elements` equal elements over a window, the first over the section:
//
//     new window = outer edges of the outermost pressed elements, and 1.5 elements more on a side; on a side whose
//                  outermost element presses, a quarter of their width more instead
//     patch      = after the last round: 6 % of their width more on each side
//
// Everything is clipped to the sensor and to the indenter's edges.

inline constexpr int search_elements = 12, search_rounds = 3, search_most_sweeps = 200;
inline constexpr double search_tolerance = 1e-3;
inline constexpr double search_margin = 1.5;        ///< elements beyond the pressed ones, for the next window
inline constexpr double search_growth = 0.25;       ///< of the pressed width, where the outermost element presses
inline constexpr double patch_margin = 0.06;        ///< of the pressed width, for the patch
inline constexpr int search_most_depths = 20;       ///< trials of the depth that gives a force
inline constexpr double search_force_error = 0.02;  ///< of the given force

/// What the search found.
struct PatchSearch {
  Patch patch;
  double depth = 0;  ///< mm: the largest of the load's, or the one that gives the largest force without friction
  double P = 0;      ///< N/mm at that depth, without friction
};

/// Returns the limits of patches of this scene.
PatchLimits patch_limits(const Scene& scene);

/// Returns the patch of a scene. For given forces the depth is sought, by secants in the logarithms of depth and
/// force, each with its three rounds.
PatchSearch find_patch(const Scene& scene, const LayerTable& table, int elements);

/// Returns the patch at a depth, in mm.
PatchSearch find_patch_at(double depth, const Scene& scene, const LayerTable& table, int elements);

}  // namespace tactel::fem
