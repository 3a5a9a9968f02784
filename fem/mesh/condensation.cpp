// SPDX-License-Identifier: Apache-2.0
#include "fem/mesh/condensation.h"

#include <algorithm>

#include "fem/mesh/clamped_block.h"
#include "fem/numbers/number_text.h"
#include "fem/numbers/value_error.h"

namespace tactel::fem {
namespace {

Eigen::VectorXd positions(const Mesh& mesh, const std::vector<int>& nodes) { return mesh.node(0, nodes).transpose(); }

/// Everything that a surface load brings about, for unit loads on the unknowns `first` to `first + count` of the
/// surface.
void condense_columns(const ClampedBlock& block, const std::vector<int>& surface, Eigen::Index first,
                      Eigen::Index count, const Eigen::SparseMatrix<double>& element_stress, Condensation& result) {
  Eigen::MatrixXd load = Eigen::MatrixXd::Zero(2 * block.mesh().node.cols(), count);
  for (Eigen::Index j = 0; j < count; ++j) load(surface[static_cast<std::size_t>(first + j)], j) = 1;
  const Eigen::MatrixXd u = block.displacement(load);
  result.compliance.middleCols(first, count) = u(surface, Eigen::all);
  result.base_force.middleCols(first, count) = block.base_force(u);
  if (element_stress.size() > 0) result.tactel_stress.middleCols(first, count) = element_stress * u;
}

/// [2 tactels, 2 columns] from the base forces, by `reaction`.
Eigen::MatrixXd stress_from_reaction(const Mesh& mesh, const Sensor& sensor, const Eigen::MatrixXd& base_force) {
  const Eigen::MatrixXd density = base_stress_from_reaction(mesh, sensor);
  const Eigen::MatrixXd along_x = base_force(Eigen::seq(0, Eigen::last, 2), Eigen::all);
  const Eigen::MatrixXd along_y = base_force(Eigen::seq(1, Eigen::last, 2), Eigen::all);
  Eigen::MatrixXd stress(2 * sensor.tactels, base_force.cols());
  stress << density * along_y, density * along_x;
  return stress;
}

void check_precision(const Sensor& sensor, const Condensation& result) {
  constexpr double most_lost = 1e-7;  // about what single precision kernels resolve
  const double lost = lost_force(result);
  if (!result.compliance.allFinite() || !result.base_force.allFinite() || !(lost <= most_lost))
    throw ValueError("sensor.poisson", number_text(sensor.poisson),
                     "further from 0.5, or the elements less flat: double precision loses " + number_text(lost) +
                         " of the force between surface and base, " + number_text(most_lost) + " is allowed");
}

}  // namespace

// Rounding of the volumetric stiffness makes it about 1e-15 / (1/2 - nu); it shows before anything else that precision
// has run out.
double lost_force(const Condensation& condensation) {
  const Eigen::MatrixXd& base_force = condensation.base_force;
  const Eigen::Map<const Eigen::Matrix2Xd> pairs(base_force.data(), 2, base_force.size() / 2);
  const Eigen::Index nodes = base_force.rows() / 2;
  double largest = 0;
  for (Eigen::Index j = 0; j < base_force.cols(); ++j) {
    Eigen::Vector2d lost = pairs.middleCols(j * nodes, nodes).rowwise().sum();
    lost[j % 2] -= 1;
    largest = std::max(largest, lost.cwiseAbs().maxCoeff());
  }
  return largest;
}

Condensation condense(const Sensor& sensor) {
  const Sensor unit = with_unit_young(sensor);
  const ClampedBlock block(unit);
  const Mesh& mesh = block.mesh();
  const bool reaction = sensor.stress == StressRecovery::reaction;
  const Eigen::SparseMatrix<double> element_stress =
      reaction ? Eigen::SparseMatrix<double>() : base_stress_from_elements(mesh, unit);
  const std::vector<int> surface = unknowns_of(mesh.surface);
  const auto loads = static_cast<Eigen::Index>(surface.size());
  Condensation result;
  result.compliance.resize(loads, loads);
  result.base_force.resize(2 * static_cast<Eigen::Index>(mesh.base.size()), loads);
  result.tactel_stress.resize(2 * sensor.tactels, loads);
  constexpr Eigen::Index width = ClampedBlock::loads_at_a_time;
  for (Eigen::Index first = 0; first < loads; first += width)
    condense_columns(block, surface, first, std::min(width, loads - first), element_stress, result);
  check_precision(sensor, result);
  if (reaction) result.tactel_stress = stress_from_reaction(mesh, unit, result.base_force);
  result.compliance = (result.compliance + result.compliance.transpose()).eval() / 2;
  result.surface_x = positions(mesh, mesh.surface);
  result.base_x = positions(mesh, mesh.base);
  result.tactel_x = tactel_positions(sensor);
  return result;
}

}  // namespace tactel::fem
