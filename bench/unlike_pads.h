// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/pad/pad_scene.h"

namespace tactel::host {

/// How the indenter moves after pressing. Long drags go on far beyond sliding.
enum class PadWay { straight, long_drag, curved, back, loop, twist, twisting_drag };
inline constexpr int pad_ways = 7;
const char* name(PadWay way);

inline constexpr int pad_kinds = 12;  ///< of indenters, of which three are height maps

/// A random scene and its way.
struct UnlikePad {
  fem::PadScene scene;
  PadWay way;
};

/// Returns scene k of a seed: pad_kinds indenters in turn with every way in turn; H 1 to 4 mm, mu 0.1 to 1.5, 2 to 20 %
/// of H deep, nu 0.3 to 0.5, contacts of 0.2 to 1.5 H to a side of the axis. With `wide` as no table was measured: mu
/// from 0.05, 1 to 20 % deep, nu from 0, contacts of 0.15 to 10 H; some by force.
UnlikePad unlike_pad(unsigned seed, int k, bool wide);

/// Returns a wide scene k with 7 x 7 markers 0.02 to 0.5 H deep, over 1.5 times the contact.
UnlikePad unlike_marked_pad(unsigned seed, int k);

/// Returns a wide scene k on one to three layers, each 0.1 of the whole or thicker, with 0.1 to 10 times the E of the
/// uppermost and nu 0.3 to 0.5.
UnlikePad unlike_layered_pad(unsigned seed, int k);

/// Returns scene k on a pad of 19 x 19 mm with free sides: the same indenters and ways; H 2 to 6 mm, nu 0.3 to 0.4999,
/// mu 0.1 to 1.5, 1 to 10 % of H deep, contacts of 1.5 to 14 mm to a side of the axis, which lies anywhere on the pad.
UnlikePad unlike_free_pad(unsigned seed, int k);

}  // namespace tactel::host
