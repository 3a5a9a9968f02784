// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/pad/pad_cells.h"
#include "fem/pad/pad_scene.h"
#include "fem/pad/side_kernel.h"

namespace tactel::fem {

// Search of the rectangle of its own frame that an indenter touches at most along its load path, by contacts without
// friction, as in fem/layer/patch_search.h: three rounds on pad_search_cells x pad_search_cells cells over a window,
// the first over the rigid section at the largest depth,
//
//     new window = outer edges of the outermost pressed cells, and 1.5 cells more on a side; on a side whose outermost
//                  cells press, a quarter of the width more instead
//     contact    = after the last round: 6 % of the width more on each side
//
// Everything is clipped to the indenter's edges. Measured heights whose points lie so far apart that no cell of the
// first window is pressed get a second first window, around where the bilinear profile lies below the depth.

inline constexpr int pad_search_cells = 12;

struct PadSearch {
  PadBox contact;
  double depth = 0;  ///< mm: the largest of the load's, or the one that gives the largest force without friction
  double P = 0;      ///< N at that depth, without friction
};

/// The frame of a search on a pad with free sides, whose origin is the indenter's axis.
struct PadFrame {
  double turn = 0;             ///< degrees, from the indenter's own frame
  PadBox rubber = everywhere;  ///< mm: where the pad's sides lie along the frame; cells beyond the pad press nothing
  PadSides sides{};            ///< none: endless
};

/// Returns the contact of a scene. For given forces the depth is sought by secants in the logarithms of depth and
/// force.
PadSearch find_pad_contact(const PadScene& scene, const PadLayer& layer, const PadFrame& frame = {});

/// What a scene is solved on.
struct PadLayout {
  PadIndenter indenter;  ///< as the cells see it
  PadCells cells;
  double depth = 0;  ///< mm: of the search
};

// The rounding, of radius R, of the edge of a flat may be about as small as a cell. With E' = E / (1 - nu^2), the
// pressure near the edge is E' strength / sqrt(s) at a distance s within it, as below a sharp one. That touches
//
//     reach = (3 pi R strength / 2)^(2/3)
//
// of the rounding, which acts on what is far from it like a sharp edge at rim_end reach (plane strain near the edge; K.
// L. Johnson, Contact Mechanics, 1985, section 5.3). For a mean pressure p over a contact of radius a at a depth d, and
// s = P / (2 a d E'), which is 1 on a thick layer, the energy that an edge set outwards releases gives a mean
// strength^2 of p d (1 - 1 / (2 s)) / (2 pi E').
//
// A punch whose rounding is touched over less than round_rim cells is sharp to them, and rim_end reach wider. Cells
// below a box touched over less than straight_rim cells end, in cells,
//
//     straight_overhang - (1 - rim_end) min(reach, rim_end)
//
// beyond the contact, where the force is right: as at a sharp edge, and within the contact where cells resolve it.

inline constexpr double rim_end = 0.6, round_rim = 0.5, straight_rim = 3;

/// Returns an indenter as the search and the cells see it, over the skin (over_skin): a tilted punch, which touches
/// along an arc, in a frame turned so that this lies along the cells.
PadIndenter aligned(PadIndenter indenter, const PadSensor& sensor);

/// Returns the cells of a scene, `cells` along a side (pad_cells), over the contact of the search. With `found`: what
/// find_pad_contact found for the aligned indenter, which `scene` has.
/// Beside free sides the ladder does not count: where the indenter's own frame is that of the pad, but for quarter
/// turns, cells end at the pad's edge. Otherwise they lie within the pad, or have its frame and are shared.
PadLayout lay_cells(PadSearch found, const PadScene& scene, int cells, bool ladder);
PadLayout lay_cells(const PadScene& scene, const PadLayer& layer, int cells, bool ladder, const PadSides& sides = {});

/// Returns the pad's outline in a frame turned by so many degrees, about the indenter's axis; `everywhere` where they
/// are no quarter turns.
PadBox rubber_along(const PadSensor& sensor, const PadIndenter& indenter, double degrees);
/// Whether a place in such a frame lies on the pad.
bool on_pad(const PadSensor& sensor, const PadIndenter& indenter, double degrees, double x, double y);

/// Returns the contact at a depth, in mm.
PadSearch find_pad_contact_at(double depth, const PadScene& scene, const PadLayer& layer, const PadFrame& frame = {});

}  // namespace tactel::fem
