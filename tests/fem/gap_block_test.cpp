// SPDX-License-Identifier: Apache-2.0
#include "fem/gap/gap_block.h"

#include <gtest/gtest.h>

#include <random>

#include "fem/mesh/block.h"

namespace tactel::fem::gap_block_test {

struct Case {
  Element element;
  double poisson;
};

class GapBlockTest : public testing::TestWithParam<Case> {
 protected:
  GapBlockTest() {
    sensor_.columns = 9;
    sensor_.rows = 4;
    sensor_.length = 5;
    sensor_.element = GetParam().element;
    sensor_.poisson = GetParam().poisson;
  }
  Sensor sensor_;
  std::mt19937 generator_{17};
};

// The same equations, unknowns in the mesh's own order, dense.
Eigen::MatrixXd dense_solution(const Mesh& mesh, const Eigen::MatrixXd& stiffness, const std::vector<Trial>& trial,
                               double mu, const Eigen::MatrixXd& right) {
  Eigen::MatrixXd a = stiffness, b = Eigen::MatrixXd::Zero(a.rows(), right.cols());
  const auto prescribe = [&](int dof) {
    a.row(dof).setZero();
    a(dof, dof) = 1;
  };
  for (int i = 0; i < int(trial.size()); ++i) {
    const int x = 2 * mesh.surface[i], y = x + 1;
    b.middleRows(x, 2) = right.middleRows(2 * i, 2);
    if (trial[i] == Trial::stick) prescribe(x);
    if (slips(trial[i])) a.row(x) += friction_sign(trial[i]) * mu * a.row(y);
    if (touches(trial[i])) prescribe(y);
  }
  for (int node : mesh.base) prescribe(2 * node), prescribe(2 * node + 1);
  return a.fullPivLu().solve(b);
}

TEST_P(GapBlockTest, AgreesWithADenseSolveForRandomStatuses) {
  const Mesh mesh = make_mesh(sensor_);
  const Eigen::SparseMatrix<double> matrix = stiffness(mesh, sensor_);
  GapBlock block(mesh, matrix);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int round = 0; round < 12; ++round) {
    std::vector<Trial> trial(sensor_.columns, Trial::open);
    // From none to all columns in contact, at the ends and inside.
    for (Trial& each : trial) each = int(generator_() % 12) < round ? Trial(generator_() % 4) : Trial::open;
    if (round == 1) trial[4] = Trial::slip_plus;  // one node alone
    const Extended right = Extended::NullaryExpr(2 * sensor_.columns, 2, [&] { return uniform(generator_); });
    const auto found = block.solve(trial, 0.7, right);
    ASSERT_TRUE(found);
    const Eigen::MatrixXd expected = dense_solution(mesh, matrix, trial, 0.7, right.cast<double>());
    // The dense solve loses cond(K), 1e3 to 1e7, of 1e-16.
    const double tolerance = 1e-13 / (1 - 2 * sensor_.poisson) * 10 * expected.cwiseAbs().maxCoeff();
    EXPECT_LT((found->cast<double>() - expected).cwiseAbs().maxCoeff(), tolerance) << "round " << round;
  }
}

TEST_P(GapBlockTest, SurfaceAndBaseForcesBalance) {
  const Mesh mesh = make_mesh(sensor_);
  GapBlock block(mesh, stiffness(mesh, sensor_));
  std::vector<Trial> trial(sensor_.columns, Trial::open);
  trial[3] = Trial::stick;
  trial[4] = Trial::slip_minus;
  const auto u = block.solve(trial, 0.4, Extended::Constant(2 * sensor_.columns, 1, -0.1L));
  ASSERT_TRUE(u);
  const Extended surface = block.surface_force(*u), base = block.base_force(*u);
  const Extended lost =
      surface.reshaped(2, surface.size() / 2).rowwise().sum() - base.reshaped(2, base.size() / 2).rowwise().sum();
  // Rows of K sum to 0 up to rounding of its entries, which are 1 / (1 - 2 nu) times larger than those that forces
  // feel.
  EXPECT_LT(double(lost.cwiseAbs().maxCoeff() / surface.cwiseAbs().maxCoeff()), 1e-14 / (1 - 2 * sensor_.poisson));
  for (int i : {0, 1, 2, 5, 6, 7, 8}) {
    EXPECT_NEAR(double(surface(2 * i)), -0.1, 1e-14);  // open nodes bear what was asked for
    EXPECT_NEAR(double(surface(2 * i + 1)), -0.1, 1e-14);
  }
  EXPECT_EQ(double((*u)(2 * mesh.surface[3])), double(-0.1L));
  EXPECT_NEAR(double(surface(8) - 0.4L * surface(9)), -0.1, 1e-14);  // f_x - mu f_y
}

TEST(GapBlock, SaysThatASystemIsSingular) {
  // f_x + mu f_y = 0 says nothing about u_x where K_xx + mu K_yx = 0.
  Mesh mesh{.element = Element::q4};
  mesh.node.resize(2, 4);
  mesh.node << 0, 1, 0, 1, 0, 0, 1, 1;
  mesh.base = {0, 1};
  mesh.surface = {2, 3};
  Eigen::Matrix2d spring;
  spring << 1, -0.5, -0.5, 1;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(8, 8);
  for (int column : {0, 2}) {
    matrix.block<2, 2>(column, column) = matrix.block<2, 2>(column + 4, column + 4) = spring;
    matrix.block<2, 2>(column, column + 4) = matrix.block<2, 2>(column + 4, column) = -spring;
  }
  GapBlock block(mesh, matrix.sparseView());
  const std::vector<Trial> trial{Trial::slip_plus, Trial::open};
  EXPECT_FALSE(block.solve(trial, 2, Extended::Zero(4, 1)));
  EXPECT_TRUE(block.solve(trial, 1, Extended::Zero(4, 1)));
}

TEST(GapBlock, RefusesAStiffnessThatResistsTranslation) {
  const Sensor sensor;
  Eigen::SparseMatrix<double> matrix = stiffness(make_mesh(sensor), sensor);
  matrix.coeffRef(100, 100) *= 1.001;
  EXPECT_THROW(GapBlock(make_mesh(sensor), matrix), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(Elements, GapBlockTest,
                         testing::Values(Case{Element::bbar, 0.3}, Case{Element::bbar, 0.4999}, Case{Element::q4, 0.0},
                                         Case{Element::q4i, 0.45}, Case{Element::q8, 0.3}, Case{Element::q8, 0.4999}));

}  // namespace tactel::fem::gap_block_test
