// SPDX-License-Identifier: Apache-2.0

// Written by `tactel_pad_study 72 2026 FILE`; do not edit.
// Errors in S against the reference of 72 contacts of nine shapes: H 1 to 4 mm, nu 0.3 to 0.5, mu 0.1 to 1.5,
// 2 to 20 % of H deep, eight drags, half of them with twists. By class: smooth, sharp edge, rounded edge, tilted.
#include "host/contact/pad_rung.h"

namespace tactel::host {

std::span<const MeasuredPadRung> measured_pads() {
  static constexpr MeasuredPadRung rungs[] = {
      {"pad-8",
       {{{{0.0234, 0.03, 0.03, 0.03, 0.03, 0.03}, 0.0239},
         {{0.0149, 0.03, 0.03, 0.03, 0.03, 0.03}, 0.0203},
         {{0.0187, 0.03, 0.03, 0.03, 0.03, 0.03}, 0.0187},
         {{0.06, 0.03, 0.03, 0.03, 0.03, 0.03}, 0.1}}}},
      {"pad-12",
       {{{{0.0107, 0.03, 0.03, 0.03, 0.03, 0.03}, 0.0115},
         {{0.0076, 0.03, 0.03, 0.03, 0.03, 0.03}, 0.0114},
         {{0.0131, 0.03, 0.03, 0.03, 0.03, 0.03}, 0.0131},
         {{0.06, 0.03, 0.03, 0.03, 0.03, 0.03}, 0.1}}}},
      {"pad-16",
       {{{{0.0067, 0.03, 0.03, 0.03, 0.03, 0.03}, 0.0069},
         {{0.0072, 0.03, 0.03, 0.03, 0.03, 0.03}, 0.0103},
         {{0.0089, 0.03, 0.03, 0.03, 0.03, 0.03}, 0.0089},
         {{0.06, 0.03, 0.03, 0.03, 0.03, 0.03}, 0.1}}}},
      {"pad-24",
       {{{{0.0059, 0.03, 0.03, 0.03, 0.03, 0.03}, 0.0060},
         {{0.0047, 0.03, 0.03, 0.03, 0.03, 0.03}, 0.0073},
         {{0.0071, 0.03, 0.03, 0.03, 0.03, 0.03}, 0.0071},
         {{0.06, 0.03, 0.03, 0.03, 0.03, 0.03}, 0.1}}}},
  };
  return rungs;
}

}  // namespace tactel::host
