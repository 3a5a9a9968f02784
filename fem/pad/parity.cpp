// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/parity.h"

namespace tactel::fem {

void unfold(const Eigen::MatrixXd& quarter, Parity parity, std::array<int, 2> count, Eigen::MatrixXd& to) {
  for (const int sx : {0, 1})
    for (const int sy : {0, 1})
      for (int i = 0; i < count[0]; ++i)
        for (int j = 0; j < count[1]; ++j)
          for (int c = 0; c < 3; ++c) {
            const int x = sx ? count[0] - 1 - i : count[0] + i, y = sy ? count[1] - 1 - j : count[1] + j;
            const double sign = (sx ? parity.in_x(c) : 1) * (sy ? parity.in_y(c) : 1) / 4.0;
            to.row(3 * (x * 2 * count[1] + y) + c) += sign * quarter.row(3 * (i * count[1] + j) + c);
          }
}

}  // namespace tactel::fem
