// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "fem/scenes/sensor.h"

namespace tactel::fem {

/// Structured rectangular mesh of the block; degrees of freedom of node k are 2k (x) and 2k + 1 (y).
struct Mesh {
  Element element;
  Eigen::Matrix2Xd node;  ///< [2, nodes] mm; base at y = 0, surface at y = thickness
  Eigen::Matrix<int, -1, -1, Eigen::RowMajor>
      cell;  ///< [cells, 4 or 8] node ids: corners counter-clockwise from the lower left, then (q8) mid-sides
  std::vector<int> surface;  ///< [columns] corner nodes of the surface, left to right: they carry the gap elements
  std::vector<int> base;     ///< every clamped node, left to right (q8: mid-sides too)
};

Mesh make_mesh(const Sensor& sensor);

/// Returns the degrees of freedom of these nodes: 2k, 2k + 1 of each in turn.
std::vector<int> unknowns_of(const std::vector<int>& nodes);

}  // namespace tactel::fem
