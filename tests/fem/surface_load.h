// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/mesh/mesh.h"
#include "fem/mesh/shape_functions.h"

namespace tactel::fem {

/// Nodal loads, [2 nodes] N/mm, of a traction on the surface, x -> [2] MPa: consistent, mid-side nodes included.
template <class Traction>
Eigen::VectorXd consistent_surface_load(const Mesh& mesh, Traction traction) {
  Eigen::VectorXd load = Eigen::VectorXd::Zero(2 * mesh.node.cols());
  const auto cells = static_cast<Eigen::Index>(mesh.surface.size()) - 1;
  const auto lines = gauss_points(3);  // the middle row of three: eta = 0, weights 8/9 of a line's
  for (const auto& cell : mesh.cell.bottomRows(cells).rowwise()) {
    std::vector<int> edge{cell[3], cell[2]};
    if (cell.size() == 8) edge = {cell[3], cell[6], cell[2]};
    const double left = mesh.node(0, edge.front()), right = mesh.node(0, edge.back());
    for (int g : {3, 4, 5}) {
      const double s = lines[static_cast<std::size_t>(g)].xi,
                   weight = lines[static_cast<std::size_t>(g)].weight * 9 / 8;
      const Eigen::RowVectorXd shape = edge_functions(static_cast<int>(edge.size()), s);
      const Eigen::Vector2d t = traction((left + right) / 2 + s * (right - left) / 2);
      for (std::size_t k = 0; k < edge.size(); ++k)
        load.segment<2>(2 * edge[k]) += shape[static_cast<Eigen::Index>(k)] * weight * (right - left) / 2 * t;
    }
  }
  return load;
}

}  // namespace tactel::fem
