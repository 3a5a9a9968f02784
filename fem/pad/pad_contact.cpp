// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

// The variant is chosen when the program starts. Sanitizers do not go with that.
#if defined(__x86_64__) && !defined(__FMA__) && !defined(TACTEL_SANITIZED)
#define FOR_EACH_PROCESSOR __attribute__((target_clones("default", "fma")))
#else
#define FOR_EACH_PROCESSOR
#endif

namespace tactel::fem {
namespace {

constexpr double relaxation = 0.85;
constexpr int damped_again_after = 100;  ///< halved steps are halved again where so many sweeps come no nearer
constexpr double finer = 0.25;           ///< tolerance of sweeps that go on, over that of those before
constexpr double least_tolerance = 16 * std::numeric_limits<double>::epsilon();

/// Shortens a traction to the cone.
void to_cone(Eigen::Ref<Eigen::RowVector2d, 0, Eigen::InnerStride<>> t, double most) {
  const double length = t.norm();
  if (length > most) t *= most / length;
}

/// Adds what `count` cells of a column do to u[3]. Nearly all time of a reference goes here.
FOR_EACH_PROCESSOR void add_products(const double* xx, const double* yy, const double* zz, const double* xy,
                                     const double* xz, const double* yz, const double* n, const double* tx,
                                     const double* ty, int count, double* u) {
  double x = 0, y = 0, z = 0;
#pragma omp simd reduction(+ : x, y, z)
  for (int j = 0; j < count; ++j) {
    x += xx[j] * tx[j] + xy[j] * ty[j] - xz[j] * n[j];
    y += xy[j] * tx[j] + yy[j] * ty[j] - yz[j] * n[j];
    z -= zz[j] * n[j] + xz[j] * tx[j] + yz[j] * ty[j];
  }
  u[0] += x, u[1] += y, u[2] += z;
}

/// The same of a table, whose nine planes differ.
FOR_EACH_PROCESSOR void add_table_products(const double* const c[9], const double* n, const double* tx,
                                           const double* ty, int count, double* u) {
  double x = 0, y = 0, z = 0;
#pragma omp simd reduction(+ : x, y, z)
  for (int j = 0; j < count; ++j) {
    x += c[0][j] * tx[j] + c[1][j] * ty[j] - c[2][j] * n[j];
    y += c[3][j] * tx[j] + c[4][j] * ty[j] - c[5][j] * n[j];
    z += c[6][j] * tx[j] + c[7][j] * ty[j] - c[8][j] * n[j];
  }
  u[0] += x, u[1] += y, u[2] += z;
}

}  // namespace

double PadResidual::largest() const { return std::max({penetration, complementarity, cone, drift, angle}); }

PadContact::PadContact(const PadInfluence& influence, const PadCells& cells, Eigen::MatrixXd height, double mu,
                       const PadOptions& options)
    : PadContact(&influence, nullptr, cells, std::move(height), mu, options) {}

PadContact::PadContact(const PadTable& table, const PadCells& cells, Eigen::MatrixXd height, double mu,
                       const PadOptions& options)
    : PadContact(nullptr, &table, cells, std::move(height), mu, options) {}

PadContact::PadContact(const PadInfluence* influence, const PadTable* table, const PadCells& cells,
                       Eigen::MatrixXd height, double mu, const PadOptions& options)
    : influence_(influence),
      table_(table),
      cells_(cells),
      height_(std::move(height)),
      mu_(Eigen::VectorXd::Constant(cells.count(), mu)),
      options_(options),
      tolerance_(options.tolerance) {
  const int count = cells.count();
  n_ = n_last_ = Eigen::VectorXd::Zero(count);
  t_ = t_last_ = stick_ = crept_ = Eigen::MatrixX2d::Zero(count, 2);
  u_ = Eigen::MatrixX3d::Zero(count, 3);
  active_.assign(count, 0);
  columns_.assign(cells.n, {0, 0});
}

/// Sums over the window. Cells may lie in the ring around the grid.
Eigen::Vector3d PadContact::displacement(int ix, int iy) const {
  if (table_) return displacement_by_table(ix, iy);
  const PadInfluence& c = *influence_;
  Eigen::Vector3d u = Eigen::Vector3d::Zero();
  for (int jx = 0; jx < cells_.n; ++jx) {
    const auto [first, end] = columns_[jx];
    if (first == end) continue;
    const Eigen::Index from = c.at(jx - ix, first - iy), own = jx * cells_.ny() + first;
    add_products(&c.xx[from], &c.yy[from], &c.zz[from], &c.xy[from], &c.xz[from], &c.yz[from], &n_[own], &t_(own, 0),
                 &t_(own, 1), end - first, u.data());
  }
  return u;
}

/// With what the cell gives way on its own.
Eigen::Vector3d PadContact::displacement_of_cell(int i) const {
  Eigen::Vector3d u = displacement(i / cells_.ny(), i % cells_.ny());
  const double along = softness(i) * (table_ ? table_->own_tangential(i) : influence_->own_tangential),
               across = softness(i) * (table_ ? table_->own_normal(i) : influence_->own_normal);
  u += Eigen::Vector3d(along * t_(i, 0), along * t_(i, 1), -across * n_[i]);
  return u;
}

void PadContact::set_heights(Eigen::MatrixXd height, Eigen::VectorXd softness) {
  height_ = std::move(height);
  softness_ = std::move(softness);
}

void PadContact::creep(const Eigen::MatrixX3d& crept, double softer) {
  for (int i = 0; i < cells_.count(); ++i) height_(i / cells_.ny() + 1, i % cells_.ny() + 1) -= crept(i, 2);
  stick_ -= crept.leftCols<2>(), crept_ += crept.leftCols<2>();
  n_ *= softer, n_last_ *= softer, t_ *= softer, t_last_ *= softer;
}

Eigen::Vector3d PadContact::displacement_by_table(int ix, int iy) const {
  Eigen::Vector3d u = Eigen::Vector3d::Zero();
  for (int jx = 0; jx < cells_.n; ++jx) {
    const auto [first, end] = columns_[jx];
    if (first == end) continue;
    const Eigen::Index own = jx * cells_.ny() + first;
    const double* rows[9];
    for (int k = 0; k < 9; ++k) rows[k] = table_->row(ix, iy, k / 3, k % 3) + own;
    add_table_products(rows, &n_[own], &t_(own, 0), &t_(own, 1), end - first, u.data());
  }
  return u;
}

/// How far the indenter has moved at a cell since `from`.
Eigen::Vector2d PadContact::path(Eigen::Index i, const PadMotion& from) const {
  const PadMotion change = motion - from;
  const int ix = static_cast<int>(i) / cells_.ny(), iy = static_cast<int>(i) % cells_.ny();
  return {change[0] - change[2] * cells_.y(iy), change[1] + change[2] * cells_.x(ix)};
}

/// How far the indenter has slid over a cell in this increment.
Eigen::RowVector2d PadContact::slip(Eigen::Index i) const {
  return stick_.row(i) + path(i, motion_last_).transpose() - u_.row(i).head<2>();
}

void PadContact::activate(Eigen::Index i) {
  active_[i] = 1;
  const int iy = static_cast<int>(i) % cells_.ny();
  auto& [first, end] = columns_[i / cells_.ny()];
  if (first == end) first = iy, end = iy + 1;
  first = std::min(first, iy);
  end = std::max(end, iy + 1);
}

void PadContact::extrapolate(double ratio) {
  const Eigen::VectorXd n = n_;
  const Eigen::MatrixX2d t = t_;
  n_ = (n + ratio * (n - n_last_)).cwiseMax(0);
  t_ = t + ratio * (t - t_last_);
  n_last_ = n;
  t_last_ = t;
  tolerance_ = options_.tolerance;
  const bool touches = depth > height_.minCoeff();
  std::fill(active_.begin(), active_.end(), 0);
  std::fill(columns_.begin(), columns_.end(), std::array{0, 0});
  for (int i = 0; i < cells_.count(); ++i) {
    if (!touches) n_[i] = 0;
    to_cone(t_.row(i), mu_[i] * n_[i]);
    const double gap = height_(i / cells_.ny() + 1, i % cells_.ny() + 1) - depth - u_(i, 2);
    if (n_[i] > 0 || (touches && gap < 0)) activate(i);
  }
}

/// Returns the largest change over the largest pressure, tractions weighed by the root of the own influence.
double PadContact::sweep(double w) {
  double per_t = 0, per_n = 0, weight = 0, change = 0, largest = 0;
  const auto divide_by = [&](double own_normal, double own_tangential) {
    per_t = w / own_tangential, per_n = w / own_normal;
    weight = std::sqrt(own_tangential / own_normal);
  };
  if (influence_) divide_by(influence_->own_normal, influence_->own_tangential);
  for (int i = 0; i < cells_.count(); ++i) {
    if (!active_[i]) continue;
    if (table_) divide_by(table_->own_normal(i), table_->own_tangential(i));
    const Eigen::Vector3d u = displacement_of_cell(i);
    const double whole = 1 + softness(i);  // compliance of the cell over that of a covered one
    const double n =
        std::max(0.0, n_[i] + per_n / whole * (u[2] - (height_(i / cells_.ny() + 1, i % cells_.ny() + 1) - depth)));
    const Eigen::Vector2d goal = stick_.row(i).transpose() + path(i, motion_last_);
    Eigen::RowVector2d t = t_.row(i) + per_t / whole * (goal - u.head<2>()).transpose();
    to_cone(t, mu_[i] * n);
    change = std::max({change, std::abs(n - n_[i]), weight * (t - t_.row(i)).cwiseAbs().maxCoeff()});
    largest = std::max(largest, n);
    n_[i] = n;
    t_.row(i) = t;
  }
  return largest > 0 ? change / largest : 0;
}

/// Fresh sums at all cells. Returns true where cells outside the window are penetrated, which then belong to it.
bool PadContact::widen() {
  bool more = false;
  for (int i = 0; i < cells_.count(); ++i) u_.row(i) = displacement_of_cell(i);
  for (int i = 0; i < cells_.count(); ++i) {
    const double gap = height_(i / cells_.ny() + 1, i % cells_.ny() + 1) - depth - u_(i, 2);
    if (active_[i] || !(gap < -tolerance_ * depth)) continue;
    activate(i);
    more = true;
  }
  return more;
}

bool PadContact::solve(int most_sweeps, int& sweeps) {
  constexpr double infinity = std::numeric_limits<double>::infinity(), progress = 0.9;
  double w = relaxation, least = infinity, least_before = infinity;  // change of these sweeps, and those before them
  for (int k = 0; k < most_sweeps; ++k) {
    ++sweeps;
    options_.between_sweeps();
    if (k >= damped_after && (k - damped_after) % damped_again_after == 0) {
      if (k == damped_after || least > progress * least_before) w /= 2;
      least_before = std::exchange(least, infinity);
    }
    const double change = sweep(w);
    if (change <= tolerance_ && !widen()) return true;
    if (k >= damped_after) least = std::min(least, change / w);
  }
  widen();
  return false;
}

bool PadContact::refine() {
  if (tolerance_ <= least_tolerance || residual_of_cells().largest() <= options_.accepted()) return false;
  tolerance_ *= finer;
  return true;
}

/// By the last fresh sums.
PadResidual PadContact::residual_of_cells() const {
  PadResidual r;
  if (!(depth > 0)) return r;
  const double most_n = n_.maxCoeff(),
               moved = std::max(0.1 * depth, (motion - motion_last_).head<2>().norm() +
                                                 std::abs(motion[2] - motion_last_[2]) * cells_.half_size());
  for (int i = 0; i < cells_.count(); ++i) {
    const double h = height_(i / cells_.ny() + 1, i % cells_.ny() + 1), gap = (h - depth - u_(i, 2)) / depth;
    if (!std::isfinite(h)) continue;
    r.penetration = std::max(r.penetration, -gap);
    if (!(n_[i] > 0)) continue;
    const double length = t_.row(i).norm();
    const Eigen::RowVector2d slip = this->slip(i);
    r.complementarity = std::max(r.complementarity, std::abs(gap));
    r.cone = std::max(r.cone, (length - mu_[i] * n_[i]) / most_n);
    if (sticks(i))
      r.drift = std::max(r.drift, slip.norm() / moved);
    else if (length > 0)
      r.angle = std::max(r.angle, (slip.norm() - t_.row(i).dot(slip) / length) / moved);
  }
  return r;
}

PadResidual PadContact::residual(std::array<bool, 4>& outside) const {
  PadResidual r = residual_of_cells();
  const int nx = cells_.n, ny = cells_.ny();
  for (int ix = -1; ix <= nx; ++ix)
    for (int iy = -1; iy <= ny; ++iy) {
      const double h = height_(ix + 1, iy + 1);
      const bool in_ring = ix < 0 || iy < 0 || ix == nx || iy == ny;
      if (!in_ring || !(depth > 0) || !std::isfinite(h)) continue;
      const double gap = (h - depth - displacement(ix, iy)[2]) / depth;
      r.penetration = std::max(r.penetration, -gap);
      const bool beyond = gap < -options_.accepted();
      outside[0] |= beyond && ix < 0;
      outside[1] |= beyond && ix == nx;
      outside[2] |= beyond && iy < 0;
      outside[3] |= beyond && iy == ny;
    }
  return r;
}

double PadContact::slide() const {
  double sum = 0;
  int touching = 0;
  for (int i = 0; i < cells_.count(); ++i) {
    if (!(n_[i] > 0)) continue;
    ++touching;
    sum += slip(i).squaredNorm();
  }
  return touching > 0 ? std::sqrt(sum / touching) : 0;
}

Eigen::Vector3d PadContact::mean_slide() const {
  std::vector<Eigen::Vector2d> places, slips;
  for (int i = 0; i < cells_.count(); ++i) {
    if (!(n_[i] > 0)) continue;
    places.emplace_back(cells_.x(i / cells_.ny()), cells_.y(i % cells_.ny()));
    slips.push_back(sticks(i) ? Eigen::Vector2d::Zero() : Eigen::Vector2d(slip(i).transpose()));
  }
  if (places.size() < 2) return slips.empty() ? Eigen::Vector3d::Zero() : Eigen::Vector3d(slips[0][0], slips[0][1], 0);
  const double count = static_cast<double>(places.size());
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& place : places) middle += place / count;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double radius2 = 0;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const Eigen::Vector2d from = places[k] - middle;
    mean += Eigen::Vector3d(slips[k][0], slips[k][1], from[0] * slips[k][1] - from[1] * slips[k][0]) / count;
    radius2 += from.squaredNorm() / count;
  }
  mean[2] /= std::sqrt(radius2);
  return mean;
}

void PadContact::add_slide() {
  const double slide = this->slide();
  slip_path_ += slide;
  for (int i = 0; i < cells_.count(); ++i)
    if (n_[i] > 0 && sticks(i)) return;
  slid_ += slide;
}

void PadContact::remember() {
  for (int i = 0; i < cells_.count(); ++i) {
    if (sticks(i))
      stick_.row(i) += path(i, motion_last_).transpose();
    else
      stick_.row(i) = u_.row(i).head<2>();
  }
  motion_last_ = motion;
}

double PadContact::slip_distance() const {
  double most = 0;
  for (int i = 0; i < cells_.count(); ++i)
    if (n_[i] > 0)
      most = std::max(most, (path(i, PadMotion::Zero()) - (u_.row(i).head<2>() + crept_.row(i)).transpose()).norm());
  return most;
}

}  // namespace tactel::fem
