// SPDX-License-Identifier: Apache-2.0
#include "fem/path_derivatives.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "fem/contact_laws.h"

namespace tactel::fem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

bool bonded(double mu) { return mu >= largest_friction; }

void require(bool good, const char* what) {
  if (!good) throw std::invalid_argument(std::string("PathDerivatives: ") + what);
}

}  // namespace

PathDerivatives::Increment PathDerivatives::start() const {
  Increment start;
  start.f = start.u = VectorXd::Zero(2 * elements());
  return start;
}

PathDerivatives::PathDerivatives(ContactPath path) : path_(std::move(path)) {
  const Index n = elements();
  require(path_.compliance.rows() == 2 * n && path_.compliance.cols() == 2 * n, "compliance is not [2 elements, same]");
  require(path_.tactel_stress.cols() == 2 * n, "tactel_stress is not [2 tactels, 2 elements]");
  start_ = start();
  increments_.reserve(path_.increments.size());
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < path_.increments.size(); ++k) {
    const PathIncrement& given = path_.increments[k];
    require(static_cast<Index>(given.trial.size()) == n, "trial is not [elements]");
    increments_.push_back(solve(given, back(k, 1), back(k, 2)));
    nearest = std::min(nearest, distance(given, increments_[k], back(k, 1), back(k, 2)));
    if (!given.asked) continue;
    answers_.push_back(answer(increments_[k]));
    answers_.back().distance_to_switch = nearest;
  }
}

/// Adds the forces over E of the unknowns z: pressure and its friction where an element slips, then traction where it
/// sticks.
void PathDerivatives::spread(const Increment& now, const VectorXd& z, VectorXd& f) const {
  Index k = 0;
  for (const Index i : now.touching) {
    f[2 * i + 1] -= z[k];
    f[2 * i] += now.sign[static_cast<std::size_t>(i)] * path_.mu * z[k++];
  }
  for (const Index i : now.sticking) f[2 * i] += z[k++];
}

/// df/dmu at fixed pressure, over E.
VectorXd PathDerivatives::sliding_forces(const Increment& now) const {
  VectorXd f = VectorXd::Zero(2 * elements());
  for (const Index i : now.touching) f[2 * i] = -now.sign[static_cast<std::size_t>(i)] * now.f[2 * i + 1];
  return f;
}

/// [2 elements, unknown forces].
Eigen::MatrixXd PathDerivatives::displacement_by_unknowns(const Increment& now) const {
  Eigen::MatrixXd u(2 * elements(), static_cast<Index>(now.touching.size() + now.sticking.size()));
  Index k = 0;
  for (const Index i : now.touching)
    u.col(k++) = now.sign[static_cast<std::size_t>(i)] * path_.mu * path_.compliance.col(2 * i) -
                 path_.compliance.col(2 * i + 1);
  for (const Index i : now.sticking) u.col(k++) = path_.compliance.col(2 * i);
  return u;
}

/// Rows: u_y + depth on the touching elements, u_x - x on the sticking ones, then depth or the sum of pressure, x or
/// the sum of traction.
Eigen::MatrixXd PathDerivatives::equations_of(const Increment& now, const Eigen::MatrixXd& displacement) const {
  const Index m = displacement.cols(), touching = static_cast<Index>(now.touching.size());
  Eigen::MatrixXd equations = Eigen::MatrixXd::Zero(m + 2, m + 2);
  Index row = 0;
  for (const Index i : now.touching) {
    equations.row(row).head(m) = displacement.row(2 * i + 1);
    equations(row++, m) = 1;
  }
  for (const Index i : now.sticking) {
    equations.row(row).head(m) = displacement.row(2 * i);
    equations(row++, m + 1) = -1;
  }
  if (now.free_depth)
    equations.row(m).head(touching).setOnes();
  else
    equations(m, m) = 1;
  if (now.free_x) {
    for (Index k = 0; k < touching; ++k)
      equations(m + 1, k) = path_.mu * now.sign[static_cast<std::size_t>(now.touching[static_cast<std::size_t>(k)])];
    equations.row(m + 1).segment(touching, m - touching).setOnes();
  } else {
    equations(m + 1, m + 1) = 1;
  }
  return equations;
}

PathDerivatives::Closing PathDerivatives::closing(Index i, const Increment& last, const Increment& before) const {
  const double gap = path_.height[i] - last.depth - last.u[2 * i + 1],
               gap_before = path_.height[i] - before.depth - before.u[2 * i + 1];
  return {gap, gap_before, last.f[2 * i + 1] == 0 && gap > 0 && gap_before > gap};
}

PathDerivatives::Increment PathDerivatives::solve(const PathIncrement& given, const Increment& last,
                                                  const Increment& before) const {
  const Index n = elements();
  Increment now;
  for (Index i = 0; i < n; ++i) {
    const Trial trial = given.trial[static_cast<std::size_t>(i)];
    now.sign.push_back(friction_sign(trial));
    if (touches(trial)) now.touching.push_back(i);
    if (trial == Trial::stick) now.sticking.push_back(i);
  }
  // Where nothing touches a given force determines no position; it stays where it was.
  now.free_depth = given.target.normal_is_force && !now.touching.empty();
  now.free_x = given.target.tangential_is_force && !now.touching.empty();
  if (given.entry_ratio > 0)
    for (const Index i : now.sticking) {
      const Closing gap = closing(i, last, before);
      if (gap.closes && gap.part() < given.entry_ratio) now.entries.push_back({i, gap.part()});
    }
  const Eigen::MatrixXd displacement = displacement_by_unknowns(now);
  const Index m = displacement.cols();
  now.equations.compute(equations_of(now, displacement));
  const auto pivots = now.equations.matrixLU().diagonal().cwiseAbs();
  if (!(pivots.minCoeff() > 1e-15 * pivots.maxCoeff()))
    throw PathError("the equations of a load increment are singular");
  VectorXd right(m + 2);
  Index row = 0;
  for (const Index i : now.touching) right[row++] = path_.height[i];
  for (const Index i : now.sticking) right[row++] = last.u[2 * i] - last.x;
  for (const Entry& entry : now.entries) {
    const Index i = entry.element, place = std::ranges::find(now.sticking, i) - now.sticking.begin();
    right[static_cast<Index>(now.touching.size()) + place] += entry.part * (last.u[2 * i] - before.u[2 * i]);
  }
  const double normal = given.target.normal_is_force ? given.target.normal / path_.young : given.target.normal;
  const double tangential =
      given.target.tangential_is_force ? given.target.tangential / path_.young : given.target.tangential;
  right[m] = given.target.normal_is_force && !now.free_depth ? last.depth : normal;
  right[m + 1] = given.target.tangential_is_force && !now.free_x ? last.x : tangential;
  const VectorXd z = now.equations.solve(right);
  now.f = VectorXd::Zero(2 * n);
  spread(now, z, now.f);
  now.u = path_.compliance * now.f;
  now.depth = z[m];
  now.x = z[m + 1];
  return now;
}

double PathDerivatives::distance(const PathIncrement& given, const Increment& now, const Increment& last,
                                 const Increment& before) const {
  double force = 0, length = now.u.cwiseAbs().maxCoeff();
  for (const Index i : now.touching) force = std::max(force, -now.f[2 * i + 1]);
  if (!(length > 0)) length = std::abs(now.depth) > 0 ? std::abs(now.depth) : 1;
  double nearest = std::numeric_limits<double>::infinity();
  for (Index i = 0; i < elements(); ++i) {
    const Trial trial = given.trial[static_cast<std::size_t>(i)];
    const double n = -now.f[2 * i + 1], t = now.f[2 * i];
    if (!touches(trial)) {
      nearest = std::min(nearest, (path_.height[i] - now.depth - now.u[2 * i + 1]) / length);
      continue;
    }
    nearest = std::min(nearest, n / force);
    if (path_.mu == 0) continue;
    if (trial == Trial::stick) nearest = std::min(nearest, (path_.mu * n - std::abs(t)) / (path_.mu * force));
    const Closing gap = closing(i, last, before);
    const bool closing_now = given.entry_ratio > 0 && gap.closes;
    if (slips(trial) && !given.held) {
      double history = last.u[2 * i];
      if (closing_now && gap.part() < given.entry_ratio) history += gap.part() * (last.u[2 * i] - before.u[2 * i]);
      const double slip = now.u[2 * i] - history - (now.x - last.x);
      nearest = std::min(nearest, -now.sign[static_cast<std::size_t>(i)] * slip / length);
    }
    // Whether an element counts as touched within the increment is a switch of its history.
    if (closing_now) nearest = std::min(nearest, std::abs(gap.part() - given.entry_ratio));
  }
  return nearest;
}

PathAnswer PathDerivatives::answer(const Increment& now) const {
  PathAnswer a;
  a.n.resize(elements());
  a.t.resize(elements());
  for (Index i = 0; i < elements(); ++i) a.n[i] = -path_.young * now.f[2 * i + 1], a.t[i] = path_.young * now.f[2 * i];
  a.P = a.n.sum();
  a.Q = a.t.sum();
  a.S = slip_index(path_.mu, a.P, a.Q);
  a.depth = now.depth;
  a.x = now.x;
  a.frame = path_.young * (path_.tactel_stress * now.f);
  return a;
}

std::vector<PathAnswer> PathDerivatives::forward(const PathDirection& d) const {
  const Index n = elements();
  const double E = path_.young;
  struct Change {
    VectorXd f, u;
    double depth = 0, x = 0;
  };
  Change zero{VectorXd::Zero(2 * n), VectorXd::Zero(2 * n)}, last = zero, before = zero;
  std::vector<PathAnswer> result;
  for (std::size_t k = 0; k < increments_.size(); ++k) {
    const Increment &now = increments_[k], &past = back(k, 1), &past_before = back(k, 2);
    const LoadStep& target = path_.increments[k].target;
    const VectorXd sliding = sliding_forces(now);
    VectorXd own = VectorXd::Zero(2 * n);  // displacement at fixed unknowns
    if (d.compliance.size() > 0) own += d.compliance * now.f;
    if (d.mu != 0) own += d.mu * (path_.compliance * sliding);
    const auto dh = [&](Index i) { return d.height.size() > 0 ? d.height[i] : 0.0; };
    const auto touching = static_cast<Index>(now.touching.size());
    const Index m = touching + static_cast<Index>(now.sticking.size());
    VectorXd right = VectorXd::Zero(m + 2);
    Index row = 0;
    for (const Index i : now.touching) right[row++] = dh(i) - own[2 * i + 1];
    for (const Index i : now.sticking) right[row++] = last.u[2 * i] - last.x - own[2 * i];
    for (const Entry& entry : now.entries) {
      const Index i = entry.element, place = std::ranges::find(now.sticking, i) - now.sticking.begin();
      const Closing gap = closing(i, past, past_before);
      const double dgap = dh(i) - last.depth - last.u[2 * i + 1],
                   dgap_before = dh(i) - before.depth - before.u[2 * i + 1];
      const double dpart = (dgap * gap.before - gap.last * dgap_before) / (gap.closed() * gap.closed());
      right[touching + place] +=
          dpart * (past.u[2 * i] - past_before.u[2 * i]) + entry.part * (last.u[2 * i] - before.u[2 * i]);
    }
    const double normal = d.normal.size() > 0 ? d.normal[static_cast<Index>(k)] : 0,
                 tangential = d.tangential.size() > 0 ? d.tangential[static_cast<Index>(k)] : 0;
    right[m] = now.free_depth           ? (normal - target.normal / E * d.young) / E
               : target.normal_is_force ? last.depth
                                        : normal;
    right[m + 1] = now.free_x ? (tangential - target.tangential / E * d.young) / E - d.mu * sliding.sum()
                   : target.tangential_is_force ? last.x
                                                : tangential;
    const VectorXd z = now.equations.solve(right);
    Change change{d.mu * sliding, own, z[m], z[m + 1]};
    VectorXd f = VectorXd::Zero(2 * n);
    spread(now, z, f);
    change.f += f;
    change.u += path_.compliance * f;
    if (path_.increments[k].asked) {
      const PathAnswer& a = answers_[result.size()];
      PathAnswer r;
      r.n.resize(n);
      r.t.resize(n);
      for (Index i = 0; i < n; ++i) {
        r.n[i] = -E * change.f[2 * i + 1] - d.young * now.f[2 * i + 1];
        r.t[i] = E * change.f[2 * i] + d.young * now.f[2 * i];
      }
      r.P = r.n.sum();
      r.Q = r.t.sum();
      if (a.S) r.S = bonded(path_.mu) ? 0 : r.Q / (path_.mu * a.P) - *a.S * r.P / a.P - *a.S * d.mu / path_.mu;
      r.depth = change.depth;
      r.x = change.x;
      r.frame = path_.tactel_stress * (E * change.f + d.young * now.f);
      if (d.tactel_stress.size() > 0) r.frame += E * (d.tactel_stress * now.f);
      result.push_back(std::move(r));
    }
    before = std::exchange(last, std::move(change));
  }
  return result;
}

}  // namespace tactel::fem
