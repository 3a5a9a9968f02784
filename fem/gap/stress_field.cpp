// SPDX-License-Identifier: Apache-2.0
#include "fem/gap/stress_field.h"

#include <cmath>

#include "fem/mesh/block.h"
#include "fem/mesh/clamped_block.h"
#include "fem/numbers/value_error.h"

namespace tactel::fem {
namespace {

Eigen::VectorXd surface_load(const ContactStep& step) {
  Eigen::VectorXd load(2 * step.normal_force.size());  // [2 columns] N/mm, on the rubber, y up
  for (Eigen::Index i = 0; i < step.normal_force.size(); ++i) {
    load[2 * i] = step.tangential_force[i];
    load[2 * i + 1] = -step.normal_force[i];
  }
  return load;
}

StressField field_of(const Mesh& mesh, const Sensor& sensor, const Eigen::VectorXd& displacement) {
  StressField field{.mesh = mesh,
                    .displacement = displacement.reshaped(2, displacement.size() / 2),
                    .stress = nodal_stress(mesh, sensor, displacement),
                    .von_mises = {},
                    .strain = {}};
  field.von_mises.resize(field.stress.cols());
  field.strain.resize(field.stress.cols());
  for (Eigen::Index k = 0; k < field.stress.cols(); ++k) {
    field.von_mises[k] = von_mises(field.stress.col(k));
    field.strain[k] = largest_principal_strain(field.stress.col(k), sensor.young, sensor.poisson);
  }
  return field;
}

}  // namespace

double von_mises(const Eigen::Vector4d& s) {
  const double x = s[0], y = s[1], xy = s[2], z = s[3];
  return std::sqrt(0.5 * ((x - y) * (x - y) + (y - z) * (y - z) + (z - x) * (z - x)) + 3.0 * xy * xy);
}

double largest_principal_strain(const Eigen::Vector4d& s, double young, double nu) {
  const double ex = (s[0] - nu * (s[1] + s[3])) / young;
  const double ey = (s[1] - nu * (s[0] + s[3])) / young;
  const double half_shear = (1.0 + nu) * s[2] / young;
  return std::abs(0.5 * (ex + ey)) + std::hypot(0.5 * (ex - ey), half_shear);
}

StressField stress_field(const Sensor& sensor, const ContactStep& step) {
  if (!sensor.layers.empty())
    throw ValueError("sensor.layers", std::to_string(sensor.layers.size()) + " layers",
                     "left out where strains are asked for: those at interfaces have two values");
  return std::move(stress_fields(sensor, surface_load(step)).front());
}

std::vector<StressField> stress_fields(const Sensor& sensor, const Eigen::MatrixXd& surface_loads) {
  const ClampedBlock block(sensor);
  Eigen::MatrixXd loads = Eigen::MatrixXd::Zero(2 * block.mesh().node.cols(), surface_loads.cols());
  loads(unknowns_of(block.mesh().surface), Eigen::all) = surface_loads;
  const Eigen::MatrixXd displacements = block.displacement(loads);
  std::vector<StressField> fields;
  for (const auto& displacement : displacements.colwise())
    fields.push_back(field_of(block.mesh(), sensor, displacement));
  return fields;
}

}  // namespace tactel::fem
