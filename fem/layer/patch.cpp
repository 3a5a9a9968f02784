// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/patch.h"

#include <algorithm>

namespace tactel::fem {

Patch make_patch(Interval contact, const PatchLimits& limits, int elements) {
  const Interval room{std::max(limits.sensor.left, limits.indenter.left),
                      std::min(limits.sensor.right, limits.indenter.right)};
  Patch patch{std::max(contact.left, room.left), std::min(contact.right, room.right), elements};
  patch.edge_left = patch.left == limits.indenter.left && patch.left > limits.sensor.left;
  patch.edge_right = patch.right == limits.indenter.right && patch.right < limits.sensor.right;
  const double overhang =
      edge_overhang * (patch.right - patch.left) / (elements - edge_overhang * (patch.edge_left + patch.edge_right));
  if (patch.edge_left) patch.left = std::max(patch.left - overhang, limits.sensor.left);
  if (patch.edge_right) patch.right = std::min(patch.right + overhang, limits.sensor.right);
  patch.reaches_left = patch.left == limits.sensor.left;
  patch.reaches_right = patch.right == limits.sensor.right;
  return patch;
}

Eigen::VectorXd places(const Patch& patch) {
  Eigen::VectorXd x(patch.elements);
  for (int i = 0; i < patch.elements; ++i) x[i] = patch.place(i);
  return x;
}

}  // namespace tactel::fem
