// SPDX-License-Identifier: Apache-2.0
#include "fem/mesh/block.h"

#include "fem/mesh/elements.h"

namespace tactel::fem {

Eigen::SparseMatrix<double> stiffness(const Mesh& mesh, const Sensor& sensor) {
  const Eigen::Index per_cell = mesh.cell.cols(), unknowns = 2 * mesh.node.cols();
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<std::size_t>(mesh.cell.rows() * 4 * per_cell * per_cell));
  for (const auto& cell : mesh.cell.rowwise()) {
    const ElementNodes node = mesh.node(Eigen::all, cell);
    const ElementStiffness k = element_stiffness(mesh.element, node, material(sensor, node.row(1).mean()));
    const auto global = [&](Eigen::Index local) { return 2 * cell[local / 2] + static_cast<int>(local % 2); };
    for (Eigen::Index j = 0; j < k.cols(); ++j)
      for (Eigen::Index i = 0; i < k.rows(); ++i) entries.emplace_back(global(i), global(j), k(i, j));
  }
  Eigen::SparseMatrix<double> matrix(unknowns, unknowns);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace tactel::fem
