// SPDX-License-Identifier: Apache-2.0
#include "fem/mesh/block.h"

#include <gtest/gtest.h>

#include "fem/mesh/clamped_block.h"
#include "fem/mesh/elements.h"
#include "sensors.h"
#include "surface_load.h"

namespace tactel::fem::block_test {

/// Nodal values [2 nodes] of a displacement field.
template <class Field>
Eigen::VectorXd at_nodes(const Mesh& mesh, Field field) {
  Eigen::Matrix2Xd u(2, mesh.node.cols());
  for (Eigen::Index k = 0; k < mesh.node.cols(); ++k) u.col(k) = field(mesh.node(0, k), mesh.node(1, k));
  return u.reshaped();
}

Eigen::VectorXd part(const Eigen::VectorXd& whole, const std::vector<int>& nodes, int component) {
  return whole.reshaped(2, whole.size() / 2)(component, nodes).transpose();
}

/// Every second entry from `first` on: one component of forces or displacements.
Eigen::VectorXd component(const Eigen::VectorXd& pairs, int first) { return pairs(Eigen::seq(first, Eigen::last, 2)); }

class Block : public testing::TestWithParam<Element> {
 protected:
  Sensor sensor = mesh_b(GetParam());
  Mesh mesh = make_mesh(sensor);
  // In plane strain: M = lambda + 2 G at no sideways strain.
  const double G = material(sensor).shear, M = material(sensor).bulk + 4 * G / 3, lambda = M - 2 * G;
};

TEST_P(Block, StiffnessIsSymmetricAndRigidModesAreFree) {
  const Eigen::SparseMatrix<double> k = stiffness(mesh, sensor);
  const Eigen::SparseMatrix<double> transposed = k.transpose();
  // Sums over neighbouring elements may run in another order in the other triangle.
  EXPECT_LE((k - transposed).norm(), 1e-16 * k.norm());
  for (auto field :
       {+[](double, double) { return Eigen::Vector2d(1, 0); }, +[](double, double) { return Eigen::Vector2d(0, 1); },
        +[](double x, double y) { return Eigen::Vector2d(-y, x); }}) {
    const Eigen::VectorXd u = at_nodes(mesh, field);
    EXPECT_LT((k * u).cwiseAbs().maxCoeff(), 1e-15 * k.norm() * u.cwiseAbs().maxCoeff());
  }
}

TEST_P(Block, ElementRecoveryHoldsAnyConstantStress) {
  const Eigen::VectorXd u = at_nodes(
      mesh, [](double x, double y) -> Eigen::Vector2d { return Eigen::Vector2d(3 * x + y, 2 * x - 5 * y) / 100; });
  const Eigen::Vector4d expected(2 * G * 0.03 - lambda * 0.02, -2 * G * 0.05 - lambda * 0.02, G * 0.03, -lambda * 0.02);
  const Eigen::VectorXd tactel = base_stress_from_elements(mesh, sensor) * u;
  for (int t = 0; t < sensor.tactels; ++t) {
    EXPECT_NEAR(tactel[t], expected[1], 1e-12);  // displacements of 0.3 over heights of 0.05: 1e-16 * 0.3 / 0.05 * 20
    EXPECT_NEAR(tactel[sensor.tactels + t], expected[2], 1e-12);
  }
  EXPECT_LT((nodal_stress(mesh, sensor, u).colwise() - expected).cwiseAbs().maxCoeff(), 1e-12);
}

TEST_P(Block, ReactionRecoveryHoldsConstantStressThatLeavesTheSidesFree) {
  // sigma_x = 0: eps_x = -lambda / M eps_y. The traction on the base is sigma_y everywhere.
  const double squeeze = -0.02;
  const Eigen::VectorXd u =
      at_nodes(mesh, [&](double x, double y) { return Eigen::Vector2d(-lambda / M * squeeze * x, squeeze * y); });
  const Eigen::VectorXd on_base = -(stiffness(mesh, sensor) * u);
  const Eigen::MatrixXd recovery = base_stress_from_reaction(mesh, sensor);
  const Eigen::VectorXd sigma = recovery * part(on_base, mesh.base, 1), tau = recovery * part(on_base, mesh.base, 0);
  const double expected = (M - lambda * lambda / M) * squeeze;
  for (int t = 0; t < sensor.tactels; ++t) {
    EXPECT_NEAR(sigma[t], expected, 1e-12);
    EXPECT_NEAR(tau[t], 0, 1e-12);
  }
}

TEST_P(Block, ReactionRecoveryHoldsConstantShear) {
  // Dragged to +x: tau > 0. The sides carry tau too, but in y.
  const Eigen::VectorXd u = at_nodes(mesh, [](double, double y) { return Eigen::Vector2d(0.03 * y, 0); });
  const Eigen::VectorXd on_base = -(stiffness(mesh, sensor) * u);
  const Eigen::VectorXd tau = base_stress_from_reaction(mesh, sensor) * part(on_base, mesh.base, 0);
  for (int t = 0; t < sensor.tactels; ++t) EXPECT_NEAR(tau[t], G * 0.03, 1e-12);
}

/// Forces at the base nodes that are consistent with a density 1 + 0.3 x + 0.1 curvature x^2.
Eigen::VectorXd base_load(const Mesh& mesh, const Sensor& sensor, double curvature) {
  const Eigen::VectorXd load = consistent_surface_load(
      mesh, [&](double x) { return Eigen::Vector2d(0, 1 + 0.3 * x + 0.1 * curvature * x * x); });
  // The base edge is the surface edge moved down: same columns, same functions.
  std::vector<int> top = mesh.surface;
  if (mesh.element == Element::q8) {
    top.clear();
    for (const auto& cell : mesh.cell.bottomRows(sensor.columns - 1).rowwise())
      top.insert(top.end(), {cell[3], cell[6]});
    top.push_back(mesh.surface.back());
  }
  return part(load, top, 1);
}

TEST_P(Block, TactelsBetweenNodesTakeTheEdgesInterpolation) {
  // A density linear in x (quadratic for q8) comes back between the nodes too.
  const double curvature = GetParam() == Element::q8;
  sensor.tactels = 8;
  for (const std::optional<double> span : {std::optional<double>(), std::optional(12.3)}) {
    sensor.tactel_span = span;
    const Eigen::VectorXd stress = base_stress_from_reaction(mesh, sensor) * base_load(mesh, sensor, curvature);
    for (int t = 0; t < 8; ++t) {
      const double x = span.value_or(20) * (t / 7.0 - 0.5);
      EXPECT_NEAR(stress[t], 1 + 0.3 * x + 0.1 * curvature * x * x, 1e-12) << "tactel at " << x;
    }
  }
}

TEST_P(Block, WideTactelsTakeTheMean) {
  // The mean of a + b x + c x^2 over x - w/2 ... x + w/2 is its value at x plus c w^2 / 12.
  const double curvature = GetParam() == Element::q8;
  for (const int tactels : {8, 21}) {
    for (const double width : {0.01, 0.25, 0.5, 20.0 / 21}) {
      sensor.tactels = tactels, sensor.tactel_width = width;
      const Eigen::VectorXd stress = base_stress_from_reaction(mesh, sensor) * base_load(mesh, sensor, curvature);
      for (int t = 0; t < tactels; ++t) {
        const double x = (20 - width) * (t / (tactels - 1.0) - 0.5);  // the outer ones end on the ends
        EXPECT_NEAR(stress[t], 1 + 0.3 * x + 0.1 * curvature * (x * x + width * width / 12), 1e-12)
            << "tactel at " << x << ", width " << width;
      }
    }
  }
}

TEST_P(Block, TactelsSideBySideFeelTheWholeForce) {
  // Whatever the stress: means over the whole base, times their widths, are the force. By either recovery.
  sensor.tactels = 13, sensor.tactel_width = 20.0 / 13;
  std::srand(5);
  const Eigen::VectorXd force = Eigen::VectorXd::Random(static_cast<Eigen::Index>(mesh.base.size()));
  const double felt = (base_stress_from_reaction(mesh, sensor) * force).sum() * sensor.tactel_width;
  EXPECT_NEAR(felt, force.sum(), 1e-11);  // 40 nodal stresses of some 10, each to 1e-14
  const Eigen::VectorXd u = Eigen::VectorXd::Random(2 * mesh.node.cols());
  Sensor points = sensor;  // at the ends and the middle of every edge, for Simpson's rule
  points.tactels = 2 * sensor.columns - 1, points.tactel_width = 0;
  const Eigen::VectorXd wide = base_stress_from_elements(mesh, sensor) * u;
  const Eigen::VectorXd at_points = base_stress_from_elements(mesh, points) * u;
  double expected = 0;
  for (int k = 0; k + 2 < points.tactels; k += 2)
    expected += 0.5 / 6 * (at_points[k] + 4 * at_points[k + 1] + at_points[k + 2]);
  EXPECT_NEAR(wide.head(13).sum() * sensor.tactel_width, expected, 1e-13 * at_points.cwiseAbs().sum());
}

TEST_P(Block, FieldAndTactelsTellTheSame) {
  // Tactels 0, 2, ... of mesh B stand at nodes; any displacement will do.
  std::srand(3);
  const Eigen::VectorXd u = Eigen::VectorXd::Random(2 * mesh.node.cols());
  const Eigen::Matrix4Xd field = nodal_stress(mesh, sensor, u);
  const Eigen::VectorXd tactel = base_stress_from_elements(mesh, sensor) * u;
  for (int t = 0; t < sensor.tactels; ++t) {
    const int node = 2 * t;  // corners of the base come first
    EXPECT_NEAR(tactel[t], field(1, node), 1e-13 * field.cwiseAbs().maxCoeff());
    EXPECT_NEAR(tactel[sensor.tactels + t], field(2, node), 1e-13 * field.cwiseAbs().maxCoeff());
  }
}

TEST_P(Block, WithoutPoissonEffectAColumnIsASpring) {
  // nu = 0: uniform pressure p squeezes every column alike, u_y = -p y / E, sigma_y = -p, whatever the mesh.
  sensor.poisson = 0;
  const ClampedBlock block(sensor);
  const double pressure = 0.1;
  const Eigen::VectorXd load =
      consistent_surface_load(block.mesh(), [&](double) { return Eigen::Vector2d(0, -pressure); });
  const Eigen::MatrixXd u = block.displacement(load);
  for (Eigen::Index k = 0; k < block.mesh().node.cols(); ++k) {
    EXPECT_NEAR(u(2 * k), 0, 1e-14);
    EXPECT_NEAR(u(2 * k + 1), -pressure / sensor.young * block.mesh().node(1, k), 1e-14);
  }
  const Eigen::VectorXd by_elements = base_stress_from_elements(block.mesh(), sensor) * u.col(0);
  const Eigen::VectorXd by_reaction =
      base_stress_from_reaction(block.mesh(), sensor) * component(block.base_force(u), 1);
  for (int t = 0; t < sensor.tactels; ++t) {
    EXPECT_NEAR(by_elements[t], -pressure, 1e-13);
    EXPECT_NEAR(by_reaction[t], -pressure, 1e-13);
  }
}

/// The thin bonded layer: far from the sides a wide uniform load strains the rubber in thickness direction only,
/// u_y = -p h / M, and in shear u_x = q h / G. What the free sides change dies out like exp(-x / h) (nu = 0.45: 1 % of
/// u_y at 6.7 thicknesses, on the paper's own sensor); here the centre is 20 thicknesses away from them.
TEST_P(Block, WideLoadOnTheBondedLayer) {
  sensor.length = 60;
  sensor.columns = 121;
  for (double nu : {0.0, 0.3, 0.45}) {
    sensor.poisson = nu;
    const ClampedBlock block(sensor);
    const Material rubber = material(sensor);
    const double modulus = rubber.bulk + 4 * rubber.shear / 3;
    EXPECT_NEAR(modulus, sensor.young * (1 - nu) / ((1 + nu) * (1 - 2 * nu)), 1e-14 * modulus);
    const Eigen::VectorXd load =
        consistent_surface_load(block.mesh(), [](double) { return Eigen::Vector2d(0.2, -0.1); });
    const Eigen::MatrixXd u = block.displacement(load);
    const int centre = block.mesh().surface[60];
    EXPECT_NEAR(u(2 * centre) / (0.2 * sensor.thickness / rubber.shear), 1, 1e-6) << nu;
    EXPECT_NEAR(u(2 * centre + 1) / (-0.1 * sensor.thickness / modulus), 1, 1e-6) << nu;
    const Eigen::MatrixXd recovery = base_stress_from_reaction(block.mesh(), sensor), force = block.base_force(u);
    EXPECT_NEAR((recovery * component(force, 1))[10], -0.1, 1e-7) << nu;
    EXPECT_NEAR((recovery * component(force, 0))[10], 0.2, 1e-7) << nu;
  }
}

INSTANTIATE_TEST_SUITE_P(, Block, testing::ValuesIn(all_elements),
                         [](const auto& info) { return std::string(name(info.param)); });

}  // namespace tactel::fem::block_test
