// SPDX-License-Identifier: Apache-2.0
#include "fem/layer/patch_contact.h"

#include <algorithm>
#include <cmath>

#include "fem/gap/accuracy.h"

namespace tactel::fem {
namespace {

// Sweeps after which steps are damped, and by how much: near nu = 1/2 with mu above 1 sweeps may go round in circles.
constexpr int damped_after = 60, damped_twice_after = 240;
constexpr double damping = 0.5, damping_twice = 0.2;

}  // namespace

PatchContact::PatchContact(const PatchCompliance& compliance, Eigen::VectorXd height, double mu,
                           const PatchOptions& options)
    : compliance_(compliance), height_(std::move(height)), mu_(mu), options_(options) {
  options_.tolerance = sweep_tolerance(options.tolerance, mu);
  const Eigen::Index elements = compliance.uy_by_n.cols();
  n_ = t_ = n_last_ = t_last_ = ux_last_ = ux_ = ux_before_ = Eigen::VectorXd::Zero(elements);
  gap_ = gap_before_ = height_.segment(rows_beyond, elements);
  first_touch_ = height_.segment(rows_beyond, elements).minCoeff();
  laws_[0] = patch_laws(compliance, relaxation);
}

/// An element that is pressed has a history of its own. Gaps that do not close are left alone.
void PatchContact::touch_within(double ratio) {
  for (Eigen::Index i = 0; i < n_.size(); ++i) {
    if (n_[i] > 0 || !(gap_[i] > 0 && gap_before_[i] > gap_[i])) continue;
    const double part = gap_[i] / (gap_before_[i] - gap_[i]);
    if (part < ratio) ux_last_[i] += part * (ux_[i] - ux_before_[i]);
  }
}

void PatchContact::extrapolate(double ratio) {
  held_ = false;
  if (options_.entries && x == x_last_) touch_within(ratio);
  const Eigen::VectorXd n = n_, t = t_;
  n_ = (n + ratio * (n - n_last_)).cwiseMax(0);
  t_ = (t + ratio * (t - t_last_)).cwiseMax(-mu_ * n_).cwiseMin(mu_ * n_);
  n_last_ = n;
  t_last_ = t;
}

void PatchContact::release() {
  n_.setZero();
  t_.setZero();
}

const PatchLaws& PatchContact::laws_at(int sweep) {
  const int damped = sweep < damped_after ? 0 : sweep < damped_twice_after ? 1 : 2;
  PatchLaws& laws = laws_[damped];
  if (laws.A.size() == 0) laws = patch_laws(compliance_, relaxation * (damped == 1 ? damping : damping_twice));
  return laws;
}

/// Element by element, left to right: the pressure force, then the traction force in its cone. The pressure of element
/// i takes the traction of element i - 1 from the sweep before: in the kernel it need not wait for the new one. Returns
/// the largest change over the largest pressure force.
double PatchContact::sweep(const PatchLaws& laws) {
  double change = 0, largest = 0, late = 0;
  for (Eigen::Index i = 0; i < n_.size(); ++i) {
    const double press = laws.n_per_uy[i] * (depth - height_[rows_beyond + i]);
    const double drag = laws.t_per_ux[i] * (ux_last_[i] + (x - x_last_));
    const double n = std::max(0.0, press + laws.A.row(i).dot(n_) + laws.B.row(i).dot(t_));
    change = std::max(change, std::abs(n - n_[i]));
    n_[i] = n;
    if (i > 0) t_[i - 1] = late;
    const double free = drag + laws.D.row(i).dot(n_) + laws.E.row(i).dot(t_);
    late = std::min(std::max(free, -mu_ * n), mu_ * n);
    change = std::max(change, std::abs(late - t_[i]));
    largest = std::max(largest, n);
  }
  t_[t_.size() - 1] = late;
  return largest > 0 ? change / largest : 0;
}

bool PatchContact::solve(int& sweeps) {
  held_ = false;
  for (int k = 0; k < options_.sweeps(); ++k) {
    ++sweeps;
    if (sweep(laws_at(k)) <= options_.tolerance) return true;
  }
  return false;
}

Eigen::VectorXd PatchContact::ux() const {
  const auto within = Eigen::seqN(rows_beyond, n_.size());
  return compliance_.ux_by_n(within, Eigen::all) * n_ + compliance_.ux_by_t(within, Eigen::all) * t_;
}

GapElements PatchContact::elements() const {
  const Eigen::VectorXd uy = compliance_.uy_by_n * n_ + compliance_.uy_by_t * t_;
  const Eigen::Index rows = uy.size(), count = n_.size();
  GapElements e;
  e.mu = mu_;
  e.gap = height_.array() - depth - uy.array();
  e.slip = e.normal_force = e.tangential_force = Eigen::VectorXd::Zero(rows);
  if (!held_) e.slip.segment(rows_beyond, count) = (ux() - ux_last_).array() - (x - x_last_);
  e.normal_force.segment(rows_beyond, count) = n_;
  e.tangential_force.segment(rows_beyond, count) = t_;
  // The layer's base bears the sums: that is a property of its kernels, not of a solution.
  e.base_force = {t_.sum(), -n_.sum()};
  e.largest_displacement = uy.segment(rows_beyond, count).cwiseAbs().maxCoeff();
  return e;
}

void PatchContact::remember() {
  const Eigen::VectorXd moved = ux();
  for (Eigen::Index i = 0; i < n_.size(); ++i) {
    const bool sticks = n_[i] > 0 && std::abs(t_[i]) < mu_ * n_[i];
    ux_last_[i] = sticks ? ux_last_[i] + (x - x_last_) : moved[i];
  }
  gap_before_ = gap_;
  ux_before_ = ux_;
  gap_ = elements().gap.segment(rows_beyond, n_.size());
  ux_ = moved;
  x_last_ = x;
}

}  // namespace tactel::fem
