// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "host/support/seconds.h"

namespace tactel::host {

/// Time of the stages of a set, s, summed over threads.
struct StageSeconds {
  double draw = 0, lay_out = 0;       ///< contacts; their numbers in lanes
  double solve = 0, solve_again = 0;  ///< in kernels and waiting for them; contacts that need more than their kernel
  double gather = 0, write = 0;       ///< rows; rows to the disk
  double all() const { return draw + lay_out + solve + solve_again + gather + write; }
  StageSeconds& operator+=(const StageSeconds& more) {
    draw += more.draw, lay_out += more.lay_out, solve += more.solve, solve_again += more.solve_again;
    gather += more.gather, write += more.write;
    return *this;
  }
};

}  // namespace tactel::host
