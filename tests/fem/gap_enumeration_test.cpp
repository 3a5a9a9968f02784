// SPDX-License-Identifier: Apache-2.0

// An independent way to the same answer, possible for five surface nodes: the dense compliance of the block, every one
// of the 4^5 combinations of statuses solved, those kept that satisfy the laws of contact. It shares the stiffness
// matrix with the solver under test, no more.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <random>

#include "fem/gap/gap_block.h"
#include "fem/gap/gap_increment.h"
#include "fem/mesh/block.h"

namespace tactel::fem::gap_enumeration_test {

constexpr int nodes = 5;
enum Status { open, stick, slip_plus, slip_minus };

struct State {
  Eigen::VectorXd force, displacement;  // [2 nodes]: N/mm, mm
  double depth = 0, tangential = 0;
};

// Compliance of the surface by a dense inverse, [2 nodes, 2 nodes].
Eigen::MatrixXd surface_compliance(const Mesh& mesh, const Eigen::SparseMatrix<double>& stiffness) {
  Eigen::MatrixXd clamped = stiffness;
  for (int node : mesh.base) {
    for (int dof : {2 * node, 2 * node + 1}) {
      clamped.row(dof).setZero();
      clamped.col(dof).setZero();
      clamped(dof, dof) = 1;
    }
  }
  const Eigen::MatrixXd inverse = clamped.inverse();
  std::vector<int> surface;
  for (int node : mesh.surface) surface.insert(surface.end(), {2 * node, 2 * node + 1});
  return inverse(surface, surface);
}

struct Problem {
  Eigen::MatrixXd compliance;
  Eigen::VectorXd height;
  double mu;
};

// Unknowns: 10 forces, depth, position. Rows: two conditions a node, two of the load.
State solve(const Problem& p, const State& before, const LoadStep& load, const std::array<Status, nodes>& status) {
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(2 * nodes + 2, 2 * nodes + 2);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(2 * nodes + 2);
  const int depth = 2 * nodes, position = depth + 1;
  for (int i = 0; i < nodes; ++i) {
    const int x = 2 * i, y = x + 1;
    if (status[i] == open) {
      a(x, x) = a(y, y) = 1;
      continue;
    }
    a.row(y).head(2 * nodes) = p.compliance.row(y);  // u_y + depth = height
    a(y, depth) = 1;
    b(y) = p.height[i];
    if (status[i] == stick) {
      a.row(x).head(2 * nodes) = p.compliance.row(x);  // u_x - position = both before
      a(x, position) = -1;
      b(x) = before.displacement[x] - before.tangential;
    } else {
      a(x, x) = 1;  // t = +- mu n, n = -f_y
      a(x, y) = status[i] == slip_plus ? p.mu : -p.mu;
    }
  }
  for (int i = 0; i < nodes; ++i) {
    if (load.normal_is_force) a(depth, 2 * i + 1) = -1;
    if (load.tangential_is_force) a(position, 2 * i) = 1;
  }
  if (!load.normal_is_force) a(depth, depth) = 1;
  if (!load.tangential_is_force) a(position, position) = 1;
  b(depth) = load.normal;
  b(position) = load.tangential;
  const Eigen::VectorXd z = a.fullPivLu().solve(b);
  State state{.force = z.head(2 * nodes)};
  state.displacement = p.compliance * state.force;
  state.depth = z[depth];
  state.tangential = z[position];
  if ((a * z - b).norm() > 1e-9 * (1 + b.norm())) state.force.setConstant(std::nan(""));  // no solution
  return state;
}

bool lawful(const Problem& p, const State& before, const State& now, const std::array<Status, nodes>& status) {
  constexpr double slack =
      1e-10;  // forces and lengths are of order 0.1 to 1, the dense solve loses four digits at most
  if (!now.force.allFinite()) return false;
  for (int i = 0; i < nodes; ++i) {
    const double t = now.force[2 * i], n = -now.force[2 * i + 1];
    const double gap = p.height[i] - now.depth - now.displacement[2 * i + 1];
    const double slip = now.displacement[2 * i] - before.displacement[2 * i] - now.tangential + before.tangential;
    if (status[i] == open && gap < -slack) return false;
    if (status[i] != open && n < -slack) return false;
    if (status[i] == stick && std::abs(t) > p.mu * n + slack) return false;
    if (status[i] == slip_plus && slip > slack) return false;
    if (status[i] == slip_minus && slip < -slack) return false;
  }
  return true;
}

std::vector<State> all_solutions(const Problem& p, const State& before, const LoadStep& load) {
  std::vector<State> found;
  for (int code = 0; code < 1 << 2 * nodes; ++code) {
    std::array<Status, nodes> status;
    for (int i = 0; i < nodes; ++i) status[i] = Status(code >> 2 * i & 3);
    const State state = solve(p, before, load, status);
    if (!lawful(p, before, state, status)) continue;
    const auto same = [&](const State& other) { return (other.force - state.force).norm() < 1e-8; };  // ties come twice
    if (std::none_of(found.begin(), found.end(), same)) found.push_back(state);
  }
  return found;
}

Sensor small_sensor(double poisson) {
  return {.length = 4, .thickness = 1, .poisson = poisson, .columns = nodes, .rows = 3, .grading = 1.5};
}

class Enumeration : public testing::TestWithParam<double> {};  // largest mu

// Random profiles, friction and load paths: whatever the solver finds must be among the lawful combinations, and it
// must find one.
TEST_P(Enumeration, AgreesWithTheSolver) {
  std::mt19937 generator(5);
  const auto uniform = [&](double from, double to) { return std::uniform_real_distribution(from, to)(generator); };
  int increments = 0, several = 0;
  for (int scene = 0; scene < 40; ++scene) {
    const Sensor sensor = small_sensor(std::array{0.0, 0.3, 0.45, 0.49}[generator() % 4]);
    GapBlock block(make_mesh(sensor), stiffness(make_mesh(sensor), sensor));
    Problem problem{surface_compliance(block.mesh(), stiffness(block.mesh(), sensor)), {}, uniform(0.01, GetParam())};
    problem.height = Eigen::VectorXd::NullaryExpr(nodes, [&] { return uniform(0, 0.15); });
    problem.height.array() -= problem.height.minCoeff();
    GapPose pose = undeformed(block, problem.height);
    State before{Eigen::VectorXd::Zero(2 * nodes), Eigen::VectorXd::Zero(2 * nodes)};
    const bool pressed = generator() % 2, pulled = pressed && generator() % 2;  // by forces
    for (int step = 0; step < 3; ++step, ++increments) {
      LoadStep load{pressed, pulled, pressed ? uniform(0.05, 0.6) : uniform(0.02, 0.2), uniform(-0.2, 0.2)};
      // A pull that the contact can take at low friction, where slip of all nodes is the only obstacle.
      if (pulled) load.tangential = load.normal * std::min(problem.mu, 0.3) * uniform(-0.9, 0.9);
      const std::vector<State> solutions = all_solutions(problem, before, load);
      const GapAnswer answer = solve_increment({block, problem.mu, problem.height, load, pose}, 500, 1e-10);
      pose = answer.pose;
      Eigen::VectorXd force(2 * nodes);
      for (int i = 0; i < nodes; ++i) force.segment<2>(2 * i) << pose.tangential_force[i], -pose.normal_force[i];
      double distance = std::numeric_limits<double>::infinity();
      for (const State& state : solutions) distance = std::min(distance, (force - state.force).cwiseAbs().maxCoeff());
      ASSERT_TRUE(answer.converged) << "scene " << scene << " step " << step << ", solutions " << solutions.size();
      // The dense inverse loses cond(K), 1e4 here, of 1e-16.
      ASSERT_LT(distance, 1e-11) << "scene " << scene << " step " << step << ", solutions " << solutions.size();
      several += solutions.size() > 1;
      before.force = force;
      before.displacement = problem.compliance * force;
      before.depth = pose.depth;
      before.tangential = pose.tangential;
    }
  }
  if (GetParam() <= 1) {
    EXPECT_EQ(several, 0);  // the solution is unique for moderate friction
  }
  std::printf("%d increments, mu up to %g: %d with several solutions\n", increments, GetParam(), several);
}

INSTANTIATE_TEST_SUITE_P(Friction, Enumeration, testing::Values(0.3, 1.0, 5.0));

}  // namespace tactel::fem::gap_enumeration_test
