// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/pad/pad_cells.h"
#include "fem/pad/pad_scene.h"

namespace tactel::fem {

// Search of the rectangle of its own frame that an indenter touches at most along its load path, by contacts without
// friction, as in fem/layer/patch_search.h: three rounds on pad_search_cells x pad_search_cells cells over a window,
// the first over the rigid section at the largest depth,
//
//     new window = outer edges of the outermost pressed cells, and 1.5 cells more on a side; on a side whose outermost
//                  cells press, a quarter of the width more instead
//     contact    = after the last round: 6 % of the width more on each side
//
// Everything is clipped to the indenter's edges.

inline constexpr int pad_search_cells = 12;

struct PadSearch {
  PadBox contact;
  double depth = 0;  ///< mm: the largest of the load's, or the one that gives the largest force without friction
  double P = 0;      ///< N at that depth, without friction
};

/// Returns the contact of a scene. For given forces the depth is sought by secants in the logarithms of depth and
/// force.
PadSearch find_pad_contact(const PadScene& scene, const PadLayer& layer);

/// What a scene is solved on.
struct PadLayout {
  PadIndenter indenter;  ///< as the cells see it
  PadCells cells;
};

/// Returns an indenter as the search and the cells see it: a tilted punch, which touches along an arc, in a frame
/// turned so that this lies along the cells.
PadIndenter aligned(PadIndenter indenter);

/// Returns the cells of a scene, `cells` along a side (pad_cells), over the contact of the search. With `found`: what
/// find_pad_contact found for the aligned indenter, which `scene` has.
PadLayout lay_cells(PadSearch found, const PadScene& scene, int cells, bool ladder);
PadLayout lay_cells(const PadScene& scene, const PadLayer& layer, int cells, bool ladder);

/// Returns the contact at a depth, in mm.
PadSearch find_pad_contact_at(double depth, const PadScene& scene, const PadLayer& layer);

}  // namespace tactel::fem
