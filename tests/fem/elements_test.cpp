// SPDX-License-Identifier: Apache-2.0
#include "fem/mesh/elements.h"

#include <gtest/gtest.h>

#include "fem/mesh/shape_functions.h"
#include "sensors.h"

namespace tactel::fem::elements_test {

/// Nodes of a quadrilateral with straight sides from its corners, mid-sides added where the element has them.
ElementNodes with_mid_sides(Element element, const Eigen::Matrix<double, 2, 4>& corner) {
  ElementNodes node(2, nodes_per_element(element));
  node.leftCols<4>() = corner;
  for (int side = 0; side + 4 < node.cols(); ++side)
    node.col(4 + side) = (corner.col(side) + corner.col((side + 1) % 4)) / 2;
  return node;
}
ElementNodes rectangle(Element element, double a, double b) {
  Eigen::Matrix<double, 2, 4> corner;
  corner << 0, a, a, 0, 0, 0, b, b;
  return with_mid_sides(element, corner);
}
ElementNodes distorted(Element element) {
  Eigen::Matrix<double, 2, 4> corner;
  corner << 0.1, 1.3, 1.0, -0.2, 0.0, 0.2, 1.1, 0.8;
  return with_mid_sides(element, corner);
}

/// Nodal values [2 nodes] of a displacement field.
template <class Field>
Eigen::VectorXd at_nodes(const ElementNodes& node, Field field) {
  Eigen::Matrix2Xd u(2, node.cols());
  for (Eigen::Index k = 0; k < node.cols(); ++k) u.col(k) = field(node(0, k), node(1, k));
  return u.reshaped();
}

const Material soft{0.5, 1.0 / 3};                                                // E = 1, nu = 0
const Material rubber{0.7, 11.0};                                                 // nu = 0.469
const double c11 = 11.0 + 4 * 0.7 / 3, lambda = 11.0 - 2 * 0.7 / 3, shear = 0.7;  // of rubber, in plane strain

TEST(ElementStiffness, UnitSquareWithoutPoissonEffectByHand) {
  // nu = 0, E = 1: u1 against itself (1 + 1/2)/3, against v1 1/8, against its neighbours -1/4, -1/4 (above: 0).
  const Eigen::MatrixXd k = element_stiffness(Element::q4, rectangle(Element::q4, 1, 1), soft);
  Eigen::RowVectorXd first(8);
  first << 1 / 2.0, 1 / 8.0, -1 / 4.0, -1 / 8.0, -1 / 4.0, -1 / 8.0, 0, 1 / 8.0;
  EXPECT_LT((k.row(0) - first).cwiseAbs().maxCoeff(), 1e-16 * 4) << k.row(0);
}

TEST(ElementStiffness, RectangleInClosedForm) {
  const double a = 0.5, b = 0.2;
  const Eigen::MatrixXd k = element_stiffness(Element::q4, rectangle(Element::q4, a, b), rubber);
  const double p = c11 * b / a, q = shear * a / b, sum = (lambda + shear) / 4, difference = (lambda - shear) / 4;
  Eigen::RowVectorXd first(8);
  first << (p + q) / 3, sum, -p / 3 + q / 6, difference, -(p + q) / 6, -sum, p / 6 - q / 3, -difference;
  EXPECT_LT((k.row(0) - first).cwiseAbs().maxCoeff(), 1e-14);  // entries up to 16
  EXPECT_NEAR(k(1, 1), (c11 * a / b + shear * b / a) / 3, 1e-14);
}

TEST(ElementStiffness, MeanDilatationTakesTheVolumetricPartOfHourglasses) {
  // K(bbar) = K(q4) - kappa * integral (theta - mean theta)^2. On a rectangle the deviation of theta from its mean is
  // -+eta/(2a) for an x and -+xi/(2b) for a y displacement: kappa b/(12 a) and kappa a/(12 b), no cross terms.
  const double a = 0.5, b = 0.2;
  const Eigen::MatrixXd full = element_stiffness(Element::q4, rectangle(Element::q4, a, b), rubber);
  Eigen::Vector4d hourglass(1, -1, 1, -1);
  Eigen::MatrixXd expected = full;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      expected(2 * i, 2 * j) -= rubber.bulk * b / (12 * a) * hourglass[i] * hourglass[j];
      expected(2 * i + 1, 2 * j + 1) -= rubber.bulk * a / (12 * b) * hourglass[i] * hourglass[j];
    }
  const Eigen::MatrixXd bbar = element_stiffness(Element::bbar, rectangle(Element::bbar, a, b), rubber);
  EXPECT_LT((bbar - expected).cwiseAbs().maxCoeff(), 2e-14) << bbar - expected;
}

class EveryElement : public testing::TestWithParam<Element> {};

TEST_P(EveryElement, IsExactlySymmetricWithThreeRigidModes) {
  for (const ElementNodes& node : {rectangle(GetParam(), 0.5, 0.2), distorted(GetParam())}) {
    const Eigen::MatrixXd k = element_stiffness(GetParam(), node, rubber);
    EXPECT_EQ(k, k.transpose());
    const auto still = [&](auto field) { return (k * at_nodes(node, field)).cwiseAbs().maxCoeff() / k.norm(); };
    EXPECT_LT(still([](double, double) { return Eigen::Vector2d(1, 0); }), 1e-15);
    EXPECT_LT(still([](double, double) { return Eigen::Vector2d(0, 1); }), 1e-15);
    EXPECT_LT(still([](double x, double y) -> Eigen::Vector2d { return Eigen::Vector2d(-y, x); }), 1e-15);
    const Eigen::VectorXd value = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvalues();
    EXPECT_LT(value.head(3).cwiseAbs().maxCoeff(), 1e-14 * value.tail(1)[0]);
    EXPECT_GT(value[3], 1e-3 * shear);  // and no hourglass among the rest
  }
}

TEST_P(EveryElement, StressOfALinearFieldIsExact) {
  // u = (3x + y, 2x - 5y) 1e-2: eps_x = 0.03, eps_y = -0.05, gamma = 0.03, trace -0.02.
  const auto field = [](double x, double y) -> Eigen::Vector2d {
    return Eigen::Vector2d(3 * x + y, 2 * x - 5 * y) / 100;
  };
  const Eigen::Vector4d expected(2 * shear * 0.03 - lambda * 0.02, -2 * shear * 0.05 - lambda * 0.02, shear * 0.03,
                                 -lambda * 0.02);
  for (const ElementNodes& node : {rectangle(GetParam(), 0.5, 0.2), distorted(GetParam())}) {
    const Eigen::VectorXd stress = element_nodal_stress(GetParam(), node, rubber) * at_nodes(node, field);
    for (Eigen::Index k = 0; k < node.cols(); ++k)
      EXPECT_LT((stress.segment<4>(4 * k) - expected).cwiseAbs().maxCoeff(), 1e-14) << "node " << k;
  }
}

/// MacNeal and Harder's patch (1985), in their proportions: five distorted elements, four nodes inside. Under a linear
/// displacement of the outer boundary the inner nodes must follow it exactly.
TEST_P(EveryElement, PassesThePatchTest) {
  Eigen::Matrix<double, 2, 8> corner;
  corner << 0, 0.24, 0.24, 0, 0.04, 0.18, 0.16, 0.08,  //
      0, 0, 0.12, 0.12, 0.02, 0.03, 0.08, 0.08;
  const int quad[5][4] = {{0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}, {4, 5, 6, 7}};
  const auto field = [](double x, double y) -> Eigen::Vector2d { return Eigen::Vector2d(x + y / 2, y + x / 2) / 1000; };
  // Nodes are told apart by place: corners first, then every mid-side once.
  std::vector<Eigen::Vector2d> place;
  const auto number = [&](const Eigen::Vector2d& at) {
    for (std::size_t k = 0; k < place.size(); ++k)
      if ((place[k] - at).norm() < 1e-12) return static_cast<int>(k);
    place.push_back(at);
    return static_cast<int>(place.size()) - 1;
  };
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(48, 48);
  for (const auto& q : quad) {
    const ElementNodes node = with_mid_sides(GetParam(), corner(Eigen::all, std::vector(q, q + 4)));
    std::vector<int> unknown;
    for (const auto& at : node.colwise())
      for (int c : {0, 1}) unknown.push_back(2 * number(at) + c);
    k(unknown, unknown) += element_stiffness(GetParam(), node, rubber);
  }
  std::vector<int> inner, outer;
  Eigen::VectorXd exact(2 * place.size());
  for (int i = 0; i < static_cast<int>(place.size()); ++i) {
    const auto& at = place[static_cast<std::size_t>(i)];
    const bool boundary = at.x() < 1e-9 || at.x() > 0.24 - 1e-9 || at.y() < 1e-9 || at.y() > 0.12 - 1e-9;
    for (int c : {0, 1}) (boundary ? outer : inner).push_back(2 * i + c);
    exact.segment<2>(2 * i) = field(at.x(), at.y());
  }
  const Eigen::MatrixXd inside = k(inner, inner), across = k(inner, outer);
  const Eigen::VectorXd u = -inside.llt().solve(across * exact(outer));
  EXPECT_EQ(inner.size(), GetParam() == Element::q8 ? 24u : 8u);
  // Displacements of 1e-4, condition of the patch below 1e3.
  EXPECT_LT((u - exact(inner)).cwiseAbs().maxCoeff(), 1e-4 * 1e-12);
}

INSTANTIATE_TEST_SUITE_P(, EveryElement, testing::ValuesIn(all_elements),
                         [](const auto& info) { return std::string(name(info.param)); });

TEST(Serendipity, HoldsTheEnergyOfQuadraticFields) {
  const double a = 0.5, b = 0.2;
  const ElementNodes node = rectangle(Element::q8, a, b);
  const Eigen::MatrixXd k = element_stiffness(Element::q8, node, rubber);
  const auto energy = [&](auto field) {
    const Eigen::VectorXd u = at_nodes(node, field);
    return u.dot(k * u);
  };
  // u = x^2: eps_x = 2x, integral c11 4 x^2. u = y^2: gamma = 2y. u = x y: eps_x = y, gamma = x.
  EXPECT_NEAR(energy([](double x, double) { return Eigen::Vector2d(x * x, 0); }), c11 * 4 * a * a * a * b / 3, 1e-14);
  EXPECT_NEAR(energy([](double, double y) { return Eigen::Vector2d(y * y, 0); }), shear * 4 * a * b * b * b / 3, 1e-14);
  EXPECT_NEAR(energy([](double x, double y) -> Eigen::Vector2d { return Eigen::Vector2d(x * y, 0); }),
              (c11 * a * b * b * b + shear * a * a * a * b) / 3, 1e-14);
}

TEST(IncompatibleModes, BendARectangleExactly) {
  // Pure bending in plane strain, sigma_x = y: u = x y / E', v = -x^2 / (2 E') - nu' y^2 / (2 E'), E' = E/(1-nu^2),
  // nu' = nu/(1-nu). The y^2 is in the internal mode; at the corners it is the same everywhere. E = 9 K G/(3 K + G).
  const double young = 9 * rubber.bulk * shear / (3 * rubber.bulk + shear), nu = young / (2 * shear) - 1;
  const double plane = young / (1 - nu * nu), a = 0.5, b = 0.2;
  ElementNodes node = rectangle(Element::q4i, a, b);
  node.row(0).array() -= a / 2;
  node.row(1).array() -= b / 2;
  const Eigen::VectorXd u =
      at_nodes(node, [&](double x, double y) -> Eigen::Vector2d { return Eigen::Vector2d(x * y, -x * x / 2) / plane; });
  const Eigen::VectorXd stress = element_nodal_stress(Element::q4i, node, rubber) * u;
  for (int k = 0; k < 4; ++k) {
    const double y = node(1, k);
    EXPECT_LT((stress.segment<4>(4 * k) - Eigen::Vector4d(y, 0, 0, nu * y)).cwiseAbs().maxCoeff(), 1e-14);
  }
  // Energy: integral sigma_x^2 / E' = a b^3 / (12 E'); q4 has far more of it.
  const double exact = a * b * b * b / 12 / plane;
  EXPECT_NEAR(u.dot(element_stiffness(Element::q4i, node, rubber) * u), exact, 1e-14 * exact * 100);
  EXPECT_GT(u.dot(element_stiffness(Element::q4, node, rubber) * u), 3 * exact);
}

TEST(NearlyIncompressible, OnlyTheMeanDilatationResists) {
  // Modes that cost about the bulk modulus: theta at the four Gauss points of q4 spans three functions (1, xi, eta), at
  // bbar one. More of them than a mesh has freedoms to spare is what locks.
  const Material stiff{1, 1e6};
  const auto volumetric_modes = [&](Element element) {
    const Eigen::MatrixXd k = element_stiffness(element, rectangle(element, 1, 1), stiff);
    return (Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvalues().array() > 1e3).count();
  };
  EXPECT_EQ(volumetric_modes(Element::q4), 3);
  EXPECT_EQ(volumetric_modes(Element::bbar), 1);
}

}  // namespace tactel::fem::elements_test
