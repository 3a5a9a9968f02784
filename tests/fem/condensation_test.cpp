// SPDX-License-Identifier: Apache-2.0
#include "fem/mesh/condensation.h"

#include <cmath>
#include <iostream>

#include "expect_error.h"
#include "fem/mesh/block.h"
#include "fem/mesh/clamped_block.h"
#include "sensors.h"

namespace tactel::fem::condensation_test {

/// What rounding may do, relative: the volumetric stiffness stands above the shear stiffness by about 1/(1/2 - nu), and
/// every node adds a rounding of 1e-16 to what passes through it.
double rounding(const Sensor& sensor) {
  return 1e-16 * static_cast<double>(make_mesh(sensor).node.cols()) / (0.5 - sensor.poisson);
}

void expect_symmetric_positive_definite(const Condensation& c) {
  EXPECT_EQ(c.compliance, c.compliance.transpose());
  const Eigen::VectorXd value = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(c.compliance).eigenvalues();
  EXPECT_GT(value[0], 0);
  // Single precision lanes keep three digits at the worst (q4, which locks, at nu = 0.4999).
  EXPECT_LT(value.tail(1)[0] / value[0], 1e4) << "condition";
}

/// Forces in x and y and the moment x f_y - y f_x about the middle of the base.
void expect_equilibrium(const Condensation& c, const Sensor& sensor) {
  for (Eigen::Index j = 0; j < c.base_force.cols(); ++j) {
    double x = 0, y = 0, moment = 0;
    for (Eigen::Index k = 0; k < c.base_x.size(); ++k) {
      x += c.base_force(2 * k, j);
      y += c.base_force(2 * k + 1, j);
      moment += c.base_x[k] * c.base_force(2 * k + 1, j);
    }
    EXPECT_NEAR(x, j % 2 == 0, rounding(sensor)) << "load " << j;
    EXPECT_NEAR(y, j % 2 == 1, rounding(sensor)) << "load " << j;
    const double put_in = j % 2 == 1 ? c.surface_x[j / 2] : -sensor.thickness;
    EXPECT_NEAR(moment, put_in, 10 * rounding(sensor)) << "load " << j;  // arms up to 10 mm
  }
}

/// x -> -x turns column i into columns - 1 - i and changes the sign of x.
void expect_mirror_symmetry(const Condensation& c, const Sensor& sensor) {
  const Eigen::Index n = c.compliance.rows();
  const auto mirror = [&](Eigen::Index k) { return n - 2 - k + 2 * (k % 2); };
  double largest = 0;
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = 0; i < n; ++i) {
      const double sign = (i % 2 == j % 2) ? 1 : -1;
      largest = std::max(largest, std::abs(c.compliance(i, j) - sign * c.compliance(mirror(i), mirror(j))));
    }
  EXPECT_LT(largest, rounding(sensor) * c.compliance.cwiseAbs().maxCoeff());
}

class Condensed : public testing::TestWithParam<Sensor> {};

TEST_P(Condensed, KeepsTheLawsOfStatics) {
  const Condensation c = condense(GetParam());
  expect_symmetric_positive_definite(c);
  expect_equilibrium(c, GetParam());
  expect_mirror_symmetry(c, GetParam());
}

std::vector<Sensor> both_meshes() {
  std::vector<Sensor> all;
  for (Element element : all_elements)
    for (double nu : {0.0, 0.3, 0.45, 0.49, 0.4999}) {
      all.push_back(mesh_b(element, nu));
      all.push_back(mesh_a(element, nu));
    }
  return all;
}
INSTANTIATE_TEST_SUITE_P(, Condensed, testing::ValuesIn(both_meshes()),
                         [](const auto& info) { return describe(info.param); });

TEST(Condensation, IsSymmetricBeforeItIsSymmetrised) {
  // Columns of C are solved one by one; that C(i, j) from one solve equals C(j, i) from another checks them all.
  for (double nu : {0.3, 0.45, 0.4999}) {
    const Sensor block_sensor = mesh_a(Element::bbar, nu);
    const ClampedBlock block(block_sensor);
    const std::vector<int> surface = unknowns_of(block.mesh().surface);
    const auto n = static_cast<Eigen::Index>(surface.size());
    Eigen::MatrixXd load = Eigen::MatrixXd::Zero(2 * block.mesh().node.cols(), n);
    for (Eigen::Index j = 0; j < n; ++j) load(surface[static_cast<std::size_t>(j)], j) = 1;
    const Eigen::MatrixXd raw = block.displacement(load)(surface, Eigen::all);
    const double unsymmetric = (raw - raw.transpose()).cwiseAbs().maxCoeff() / raw.cwiseAbs().maxCoeff();
    std::cout << "mesh A, bbar, nu = " << nu << ": C(i, j) and C(j, i) differ by " << unsymmetric
              << " of the largest\n";
    EXPECT_LT(unsymmetric, 1e-13) << nu;  // a few hundred roundings of 1e-16
  }
}

TEST(Condensation, DoesNotDependOnYoungsModulus) {
  Sensor other = mesh_b();
  other.young = 7.3;
  const Condensation a = condense(mesh_b()), b = condense(other);
  EXPECT_EQ(a.compliance, b.compliance);
  EXPECT_EQ(a.base_force, b.base_force);
  EXPECT_EQ(a.tactel_stress, b.tactel_stress);
}

class CondensedAndWhole : public testing::TestWithParam<std::tuple<Element, StressRecovery>> {
 protected:
  Sensor sensor() const {
    Sensor s = mesh_b(std::get<0>(GetParam()));
    s.young = 3.7;
    s.stress = std::get<1>(GetParam());
    s.tactels = 8;
    return s;
  }
};

/// A load on the whole block, by a fresh solve with E in the stiffness, against what C, T and the stress map say.
TEST_P(CondensedAndWhole, TellTheSame) {
  const Sensor s = sensor();
  const Condensation c = condense(s);
  std::srand(5);
  const Eigen::VectorXd load = Eigen::VectorXd::Random(c.compliance.cols());
  const ClampedBlock block(s);
  const Mesh& mesh = block.mesh();
  Eigen::VectorXd nodal_load = Eigen::VectorXd::Zero(2 * mesh.node.cols());
  nodal_load(unknowns_of(mesh.surface)) = load;
  const Eigen::VectorXd u = block.displacement(nodal_load);
  const Eigen::VectorXd surface = u(unknowns_of(mesh.surface));
  EXPECT_LT((surface - c.compliance * load / s.young).cwiseAbs().maxCoeff(),
            rounding(s) * surface.cwiseAbs().maxCoeff());
  const Eigen::VectorXd nodal = stiffness(mesh, s) * u;
  const Eigen::VectorXd on_base = -nodal(unknowns_of(mesh.base));
  EXPECT_LT((on_base - c.base_force * load).cwiseAbs().maxCoeff(), rounding(s));  // forces of 1
  Eigen::VectorXd stress(16);
  if (s.stress == StressRecovery::element) {
    stress = base_stress_from_elements(mesh, s) * u;
  } else {
    const Eigen::VectorXd along_y = on_base(Eigen::seq(1, Eigen::last, 2)),
                          along_x = on_base(Eigen::seq(0, Eigen::last, 2));
    stress << base_stress_from_reaction(mesh, s) * along_y, base_stress_from_reaction(mesh, s) * along_x;
  }
  EXPECT_LT((stress - c.tactel_stress * load).cwiseAbs().maxCoeff(), rounding(s));
  EXPECT_EQ(c.surface_x, surface_positions(s));
  EXPECT_EQ(c.base_x.size(), static_cast<Eigen::Index>(mesh.base.size()));
  EXPECT_EQ(c.tactel_x, tactel_positions(s));
}
INSTANTIATE_TEST_SUITE_P(, CondensedAndWhole,
                         testing::Combine(testing::ValuesIn(all_elements),
                                          testing::Values(StressRecovery::reaction, StressRecovery::element)),
                         [](const auto& info) {
                           return std::string(name(std::get<0>(info.param))) + "_" + name(std::get<1>(info.param));
                         });

TEST(Condensation, SignsAreThoseOfAPressAndADrag) {
  for (StressRecovery recovery : {StressRecovery::reaction, StressRecovery::element}) {
    Sensor sensor = mesh_b();
    sensor.stress = recovery;
    const Condensation c = condense(sensor);
    Eigen::VectorXd press = Eigen::VectorXd::Zero(82), drag = Eigen::VectorXd::Zero(82);
    press[2 * 20 + 1] = -1;  // on the middle node, down
    drag[2 * 20] = 1;        // to +x
    EXPECT_LT((c.compliance * press)[41], 0);
    EXPECT_LT((c.tactel_stress * press)[10], 0) << "sigma_y under the press: compression";
    EXPECT_GT((c.compliance * drag)[40], 0);
    EXPECT_GT((c.tactel_stress * drag)[21 + 10], 0) << "tau_xy under the drag";
  }
}

TEST(Condensation, SaysWhenPrecisionHasRunOut) {
  EXPECT_NO_THROW(condense(mesh_b(Element::bbar, 0.499999)));
  expect_value_error([] { condense(mesh_b(Element::bbar, 0.4999999999)); }, "sensor.poisson", "0.4999999999",
                     "further from 0.5");
  expect_value_error([] { condense(mesh_b(Element::q4i, 0.49999999999999994)); }, "sensor.poisson",
                     "0.49999999999999994", "further from 0.5");
}

}  // namespace tactel::fem::condensation_test
