// SPDX-License-Identifier: Apache-2.0
#include "fem/gap/gap_sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/gap/accuracy.h"
#include "fem/gap/contact_laws.h"
#include "fem/numbers/value_error.h"

namespace tactel::fem {
namespace {

constexpr double reach = 1.25;  ///< gap elements go to work up to this many indentations

template <class Real>
using Vector = Eigen::Matrix<Real, -1, 1>;

/// What changes during a load path. Forces are divided by E (mm), n at 2i and t at 2i + 1.
template <class Real>
struct Contact {
  explicit Contact(int columns)
      : force(Vector<Real>::Zero(2 * columns)),
        last_force(force),
        ux_last(Vector<Real>::Zero(columns)),
        active(columns, false) {}

  Vector<Real> force, last_force;  ///< [2 columns]
  Vector<Real> ux_last;            ///< [columns] mm
  std::vector<bool> active;        ///< [columns] has a gap element
  int first = 0, end = 0;          ///< nodes [first, end): all gap elements
  Real mu = 0, d = 0, x = 0, x_last = 0;

  void activate(int i) {
    if (first == end) first = end = i;
    active[i] = true;
    first = std::min(first, i);
    end = std::max(end, i + 1);
  }
};

/// How much of the last change of the forces to expect again.
double growth(const LoadStep& next, const LoadStep& last, const LoadStep& before) {
  const double d = next.normal - last.normal, d_last = last.normal - before.normal;
  const double x = next.tangential - last.tangential, x_last = last.tangential - before.tangential;
  double ratio = 0;
  if (d == 0 && d_last == 0 && x_last != 0)
    ratio = x / x_last;
  else if (x == 0 && x_last == 0 && d_last != 0)
    ratio = d / d_last;
  return ratio > 0 && ratio <= 2 ? ratio : 0;
}

}  // namespace

template <class Real>
GapSweep<Real>::GapSweep(const Condensation& condensation, double tolerance, int most_sweeps)
    : condensation_(condensation), tolerance_(tolerance), most_sweeps_(most_sweeps) {
  const auto& c = condensation.compliance;
  const Eigen::Index columns = c.rows() / 2;
  to_uy_.resize(columns, 2 * columns);
  to_ux_.resize(columns, 2 * columns);
  for (Eigen::Index i = 0; i < columns; ++i)
    for (Eigen::Index j = 0; j < columns; ++j) {
      to_uy_(i, 2 * j) = static_cast<Real>(-c(2 * i + 1, 2 * j + 1));
      to_uy_(i, 2 * j + 1) = static_cast<Real>(c(2 * i + 1, 2 * j));
      to_ux_(i, 2 * j) = static_cast<Real>(-c(2 * i, 2 * j + 1));
      to_ux_(i, 2 * j + 1) = static_cast<Real>(c(2 * i, 2 * j));
    }
}

/// Goes along the load path; calls record(contact, sweeps, converged, profile) after each increment, which says whether
/// to go on.
template <class Real>
template <class Record>
void GapSweep<Real>::step_load_path(const Scene& scene, const Record& record) const {
  if (!scene.load.normal_force.empty())
    throw ValueError("load.normal_force", "given", "absent: this solver is driven by depth");
  const LoadPath path = load_path(scene.load);
  const int columns = static_cast<int>(condensation_.surface_x.size());
  Vector<Real> profile(columns);
  for (int i = 0; i < columns; ++i)
    profile[i] = static_cast<Real>(profile_height(scene.indenter, condensation_.surface_x[i]));

  Contact<Real> c(columns);
  c.mu = static_cast<Real>(std::min(scene.friction, largest_friction));
  const Real first_touch = profile.minCoeff();
  const auto segment = [&](const auto& values) { return values.segment(2 * c.first, 2 * (c.end - c.first)); };
  const auto uy = [&](int i, const Vector<Real>& force) { return segment(to_uy_.row(i)).dot(segment(force)); };
  const auto ux = [&](int i, const Vector<Real>& force) { return segment(to_ux_.row(i)).dot(segment(force)); };

  const auto sweep = [&] {  // returns largest change over largest pressure force
    Real change = 0, largest = 0;
    for (int i = c.first; i < c.end; ++i) {
      if (!c.active[i]) continue;
      const Real n_old = c.force[2 * i], t_old = c.force[2 * i + 1];
      const Real inside = uy(i, c.force) - (profile[i] - c.d), slip = ux(i, c.force) - (c.ux_last[i] + c.x - c.x_last);
      const Real n = std::max(n_old - inside / to_uy_(i, 2 * i), Real(0));
      const Real slip_now = slip + to_ux_(i, 2 * i) * (n - n_old);
      const Real t = std::clamp(t_old - slip_now / to_ux_(i, 2 * i + 1), -c.mu * n, c.mu * n);
      c.force[2 * i] = n;
      c.force[2 * i + 1] = t;
      change = std::max({change, std::abs(n - n_old), std::abs(t - t_old)});
      largest = std::max(largest, n);
    }
    return largest > 0 ? change / largest : Real(0);
  };
  const auto activate = [&](int i) {
    c.ux_last[i] = c.first < c.end ? ux(i, c.last_force) : Real(0);
    c.activate(i);
  };
  const auto activate_penetrated = [&] {
    std::vector<int> penetrated;
    Real largest_uy = 0;
    for (int i = 0; i < columns; ++i) largest_uy = std::max(largest_uy, std::abs(uy(i, c.force)));
    for (int i = 0; i < columns; ++i)
      if (!c.active[i] && uy(i, c.force) - (profile[i] - c.d) > static_cast<Real>(tolerance_) * largest_uy)
        penetrated.push_back(i);
    for (int i : penetrated) activate(i);
    return !penetrated.empty();
  };

  LoadStep last, before;
  for (const LoadStep& step : path.steps) {
    c.d = static_cast<Real>(step.normal);
    c.x = static_cast<Real>(step.tangential);
    const Vector<Real> guess = c.force + static_cast<Real>(growth(step, last, before)) * (c.force - c.last_force);
    c.last_force = c.force;
    for (int i = c.first; i < c.end; ++i) {
      const Real n = std::max(guess[2 * i], Real(0));
      c.force[2 * i] = n;
      c.force[2 * i + 1] = std::clamp(guess[2 * i + 1], -c.mu * n, c.mu * n);
    }
    if (c.d <= first_touch) c.force.setZero();  // nothing is reached: the rubber without forces is a solution
    for (int i = 0; i < columns; ++i)
      if (!c.active[i] && profile[i] <= c.d * static_cast<Real>(reach)) activate(i);
    int sweeps = 0;
    bool converged = true;
    do {
      converged = false;
      while (!converged && sweeps < most_sweeps_) {
        ++sweeps;
        converged = sweep() <= static_cast<Real>(sweep_tolerance(tolerance_, scene.friction));
      }
    } while (converged && activate_penetrated());
    if (!record(c, step, sweeps, converged, profile)) return;
    Vector<Real> moved = c.ux_last;
    for (int i = c.first; i < c.end; ++i) {
      const bool sticks = std::abs(c.force[2 * i + 1]) < c.mu * c.force[2 * i];
      moved[i] = sticks ? c.ux_last[i] + (c.x - c.x_last) : ux(i, c.force);  // what convergence left does not add up
    }
    c.ux_last = moved;
    c.x_last = c.x;
    before = last;
    last = step;
  }
}

template <class Real>
ContactSolution GapSweep<Real>::solve(const Scene& scene) const {
  ContactSolution solution{condensation_.surface_x, condensation_.base_x, condensation_.tactel_x, {}, false};
  const LoadPath path = load_path(scene.load);
  const int columns = static_cast<int>(condensation_.surface_x.size());
  step_load_path(scene, [&](const auto& c, const LoadStep& target, int sweeps, bool converged, const auto&) {
    ContactStep step;
    Eigen::VectorXd load = Eigen::VectorXd::Zero(2 * columns);
    step.normal_force = step.tangential_force = Eigen::VectorXd::Zero(columns);
    step.status.assign(columns, GapStatus::open);
    bool slides = true;
    for (int i = c.first; i < c.end; ++i) {
      const Real n = c.force[2 * i], t = c.force[2 * i + 1];
      step.normal_force[i] = n * scene.sensor.young;
      step.tangential_force[i] = t * scene.sensor.young;
      if (n > 0) step.status[i] = std::abs(t) < c.mu * n ? GapStatus::stick : GapStatus::slip;
      slides = slides && step.status[i] != GapStatus::stick;
      load[2 * i] = step.tangential_force[i];
      load[2 * i + 1] = -step.normal_force[i];
    }
    step.indentation = target.normal;
    step.tangential = target.tangential;
    step.P = step.normal_force.sum();
    step.Q = step.tangential_force.sum();
    step.slip_index = slip_index(scene.friction, step.P, step.Q);
    const Eigen::VectorXd u = condensation_.compliance * load / scene.sensor.young;
    for (int i = c.first; i < c.end; ++i)
      if (c.force[2 * i] > 0) step.slip_distance = std::max(step.slip_distance, std::abs(target.tangential - u[2 * i]));
    const Eigen::VectorXd base = condensation_.base_force * load, stress = condensation_.tactel_stress * load;
    const Eigen::Index tactels = stress.size() / 2;
    step.base_force_x = base(Eigen::seq(0, Eigen::last, 2));
    step.base_force_y = base(Eigen::seq(1, Eigen::last, 2));
    step.sigma_y = stress.head(tactels);
    step.tau_xy = stress.tail(tactels);
    step.iterations = sweeps;
    step.converged = converged;
    const bool touches = step.P > 0;
    const bool dragged = static_cast<int>(solution.steps.size()) >= path.indentation_steps;
    solution.sliding = slides && touches && dragged;
    solution.steps.push_back(std::move(step));
    return !(path.until_sliding && slides && dragged);  // where nothing touches, nothing ever will
  });
  return solution;
}

template class GapSweep<float>;
template class GapSweep<double>;

}  // namespace tactel::fem
