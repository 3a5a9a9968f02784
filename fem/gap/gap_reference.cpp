// SPDX-License-Identifier: Apache-2.0
#include "fem/gap/gap_reference.h"

#include <stdexcept>

#include "fem/mesh/block.h"

namespace tactel::fem {
namespace {

GapBlock make_block(const Sensor& sensor) {
  Mesh mesh = make_mesh(sensor);
  const Eigen::SparseMatrix<double> matrix = stiffness(mesh, sensor);
  return {std::move(mesh), matrix};
}

}  // namespace

GapReference::GapReference(const Sensor& sensor, const GapReferenceOptions& options)
    : sensor_(sensor),
      options_(options),
      block_(make_block(sensor)),
      surface_x_(surface_positions(sensor)),
      tactel_x_(tactel_positions(sensor)) {
  const Mesh& mesh = block_.mesh();
  base_x_ = mesh.node(0, mesh.base).transpose();
  if (sensor.stress == StressRecovery::reaction) {
    stress_of_reaction_ = base_stress_from_reaction(mesh, sensor);
  } else {
    stress_of_elements_ = base_stress_from_elements(mesh, sensor);
  }
}

Eigen::VectorXd GapReference::tactel_stress(const Extended& displacement, const Eigen::VectorXd& base_force) const {
  if (sensor_.stress == StressRecovery::element) return stress_of_elements_ * displacement.cast<double>();
  const Eigen::VectorXd x = base_force(Eigen::seq(0, Eigen::last, 2)), y = base_force(Eigen::seq(1, Eigen::last, 2));
  Eigen::VectorXd stress(2 * tactel_x_.size());
  stress << stress_of_reaction_ * y, stress_of_reaction_ * x;
  return stress;
}

ContactSolution GapReference::solve(const Scene& scene) {
  scene.validate();
  if (scene.sensor != sensor_)
    throw std::invalid_argument("GapReference::solve: the scene has another sensor than the solver");
  return step_load_path(block_, scene, {surface_x_, base_x_, tactel_x_, {}, false}, options_,
                        [this](const auto& state, const auto& base) { return tactel_stress(state, base); });
}

ContactSolution solve_gap_reference(const Scene& scene, const GapReferenceOptions& options) {
  return GapReference(scene.sensor, options).solve(scene);
}

}  // namespace tactel::fem
