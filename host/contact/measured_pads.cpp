// SPDX-License-Identifier: Apache-2.0

// Errors in S against 64 x 64 cells of 72 contacts: nine shapes, H 1 to 4 mm, nu 0.3 to 0.5, mu 0.1 to 1.5, 2 to 20 %
// of H deep, eight drags with twist. All classes together.
#include "host/contact/pad_rung.h"

namespace tactel::host {

std::span<const MeasuredPadRung> measured_pads() {
  static constexpr PadErrors e8{0.0093, 0.0341, 0.079}, e12{0.0048, 0.0110, 0.028}, e16{0.0028, 0.0081, 0.015},
      e24{0.0018, 0.0060, 0.015};
  static constexpr MeasuredPadRung rungs[] = {{"pad-8", {e8, e8, e8, e8}},
                                              {"pad-12", {e12, e12, e12, e12}},
                                              {"pad-16", {e16, e16, e16, e16}},
                                              {"pad-24", {e24, e24, e24, e24}}};
  return rungs;
}

}  // namespace tactel::host
