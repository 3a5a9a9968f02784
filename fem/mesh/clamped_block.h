// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/SparseCholesky>
#include <vector>

#include "fem/mesh/block.h"

namespace tactel::fem {

/// The block with its base clamped, under any nodal loads. The stiffness is factored once (sparse Cholesky,
/// fp64).
class ClampedBlock {
 public:
  static constexpr int loads_at_a_time = 32;

  explicit ClampedBlock(const Sensor& sensor) : ClampedBlock(make_mesh(sensor), sensor) {}
  /// The same on another mesh with this sensor's rubber.
  ClampedBlock(Mesh mesh, const Sensor& sensor);

  const Mesh& mesh() const { return mesh_; }

  /// Returns the displacements of all nodes [2 nodes, loads] mm for loads on all nodes [2 nodes, loads] N/mm.
  /// Loads on the base are carried by the base. One pass over the factor serves `loads_at_a_time` loads.
  Eigen::MatrixXd displacement(const Eigen::MatrixXd& load) const;

  /// Returns the force of the rubber on the base, -K u there: [2 base nodes, loads] N/mm for displacements [2
  /// nodes, loads] mm. The block must be loaded above its base only.
  Eigen::MatrixXd base_force(const Eigen::MatrixXd& displacement) const;

 private:
  Mesh mesh_;
  std::vector<int> order_;  // [free unknowns] in the factor's order: number in the whole block
  Eigen::SparseMatrix<double, Eigen::RowMajor> base_rows_;  // [2 base nodes, 2 nodes] stiffness
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
};

}  // namespace tactel::fem
