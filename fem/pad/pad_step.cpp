// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_step.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/pad/slip_margin.h"

namespace tactel::fem {
namespace {

constexpr int most_newton_rounds = 30;
constexpr double difference = 1e-4;  ///< of a depth, for the derivatives of a force

/// Heights in a ring without object.
Eigen::MatrixXd with_ring(const Eigen::ArrayXd& height, const PadCells& cells) {
  const int ny = cells.ny();
  Eigen::MatrixXd ring = Eigen::MatrixXd::Constant(cells.n + 2, ny + 2, std::numeric_limits<double>::infinity());
  for (int i = 0; i < cells.count(); ++i) ring(i / ny + 1, i % ny + 1) = height[i];
  return ring;
}

}  // namespace

SteppedContact::SteppedContact(const PadLayer& layer, const PadSensor& sensor, const PadCells& cells, double mu,
                               const PadOptions& options)
    : sensor_(sensor), cells_(cells), options_(options) {
  const Eigen::MatrixXd open =
      with_ring(Eigen::ArrayXd::Constant(cells.count(), std::numeric_limits<double>::infinity()), cells);
  if (const PadSides sides = sides_at(sensor, {0, 0}, SideBricks::usual); sides.free()) {
    table_ =
        std::make_shared<const PadTable>(layer, sides, cells, Eigen::Matrix2d::Identity(), Eigen::Vector2d::Zero());
    contact_ = std::make_unique<PadContact>(*table_, cells, open, mu, options);
  } else {
    influence_ = std::make_shared<const PadInfluence>(layer, sensor.thickness, cells.hx, cells.hy,
                                                      std::max(cells.n, cells.ny()));
    contact_ = std::make_unique<PadContact>(*influence_, cells, open, mu, options);
  }
  if (!sensor.relaxation.empty()) creep_.emplace(sensor.relaxation, cells.count());
}

void SteppedContact::set_surface(const PadSurface& surface, std::array<double, 2> axis) {
  Eigen::VectorXd softness = Eigen::VectorXd::Zero(cells_.count());
  for (Eigen::Index i = 0; i < softness.size(); ++i)
    if (surface.cover[i] > 0) softness[i] = 1 / surface.cover[i] - 1;
  contact_->set_heights(with_ring(surface.height, cells_), softness);
  contact_->set_axis(axis[0], axis[1]);
  axis_ = axis;
}

/// How far a contact moves to a pose, mm.
Eigen::Vector4d SteppedContact::change_to(const PadContact& contact, double depth, const PadMotion& motion) const {
  return {depth - contact.depth, motion[0] - contact.motion[0], motion[1] - contact.motion[1],
          cells_.half_size() * (motion[2] - contact.motion[2])};
}

/// Solves a pose from the history of a contact. Returns whether the sweeps settled and the residual is accepted.
bool SteppedContact::solve(PadContact& contact, double depth, const PadMotion& motion, int& sweeps) const {
  const Eigen::Vector4d change = change_to(contact, depth, motion);
  const double last = change_.squaredNorm();
  contact.depth = depth;
  contact.motion = motion;
  contact.extrapolate(last > 0 ? std::clamp(change.dot(change_) / last, 0.0, 2.0) : 0);
  bool settled = false;
  do settled = contact.solve(options_.most_sweeps, sweeps);
  while (settled && contact.refine());
  return settled;
}

PadWrench SteppedContact::force(const PadContact& contact) const {
  const double unit = sensor_.young * cells_.area();
  PadWrench force = PadWrench::Zero();
  for (int i = 0; i < cells_.count(); ++i) {
    const double n = unit * contact.n()[i], x = unit * contact.t()(i, 0), y = unit * contact.t()(i, 1);
    const double from_x = cells_.x(i / cells_.ny()) - axis_[0], from_y = cells_.y(i % cells_.ny()) - axis_[1];
    force += PadWrench(n, x, y, from_x * y - from_y * x);
  }
  return force;
}

SteppedState SteppedContact::state(int solves, int sweeps, bool settled) const {
  SteppedState s;
  std::array<bool, 4> outside{};
  s.force = force(*contact_), s.solves = solves, s.sweeps = sweeps, s.residual = contact_->residual(outside);
  Eigen::MatrixX2d places(cells_.count(), 2);
  int sticking = 0;
  for (int i = 0; i < cells_.count(); ++i) {
    places.row(i) << cells_.x(i / cells_.ny()) - axis_[0], cells_.y(i % cells_.ny()) - axis_[1];
    s.touching += contact_->n()[i] > 0;
    sticking += contact_->sticks(i);
  }
  const Eigen::VectorXd grip = (sensor_.young * cells_.area()) * contact_->friction().cwiseProduct(contact_->n());
  if (grip.sum() > 0) s.slip_index = std::min(1.0, slip_margin(places, grip, s.force.tail<3>()));
  s.stick_fraction = s.touching > 0 ? static_cast<double>(sticking) / s.touching : 0;
  s.slides = s.touching > 0 && sticking == 0;
  s.met = settled && s.residual.largest() <= options_.accepted();
  return s;
}

/// Ends a step in which the rubber was `softer` than elastic, and returns what it says.
SteppedState SteppedContact::end_step(int solves, int sweeps, bool settled, double softer) {
  const double slid = contact_->slide();
  const Eigen::Vector3d mean = contact_->mean_slide();
  contact_->remember();
  SteppedState s = state(solves, sweeps, settled);
  s.slid = slid, s.mean = mean;
  if (!creep_) return s;
  creep_->end(*contact_);
  s.force /= softer;
  return s;
}

SteppedState SteppedContact::move(double depth, const PadMotion& motion) {
  const Eigen::Vector4d change = change_to(*contact_, depth, motion);
  const double softer = creep_ ? creep_->begin(*contact_, dt) : 1;
  int sweeps = 0;
  const bool settled = solve(*contact_, depth, motion, sweeps);
  change_ = change;
  return end_step(1, sweeps, settled, softer);
}

SteppedState SteppedContact::press(const PadWrench& asked, double tolerance) {
  const double softer = creep_ ? creep_->begin(*contact_, dt) : 1;
  const PadWrench wrench = softer * asked;
  const double lever = cells_.half_size(), scale = difference * sensor_.thickness;
  const Eigen::Vector4d weight(1, 1, 1, 1 / lever), step = Eigen::Vector4d::Constant(scale).cwiseProduct(weight);
  Eigen::Vector4d pose(contact_->depth, contact_->motion[0], contact_->motion[1], contact_->motion[2]);
  const auto at = [&](const Eigen::Vector4d& to, std::unique_ptr<PadContact>& trial, int& sweeps, bool& settled) {
    trial = std::make_unique<PadContact>(*contact_);
    settled = solve(*trial, to[0], to.tail<3>(), sweeps);
    return force(*trial);
  };
  std::unique_ptr<PadContact> trial, other;
  bool settled = false, any = false, met = false;
  int solves = 0, sweeps = 0;
  PadWrench found = at(pose, trial, sweeps, settled);
  while (!(found[0] > 0) && solves++ < most_newton_rounds) {  // touch down
    pose[0] += 0.02 * sensor_.thickness;
    found = at(pose, trial, sweeps, settled);
  }
  for (int round = 0; round < most_newton_rounds; ++round) {
    const PadWrench missing = (wrench - found).cwiseProduct(weight);
    met = missing.cwiseAbs().maxCoeff() <= tolerance * wrench[0];
    if (met) break;
    Eigen::Matrix4d slope;
    for (int k = 0; k < 4; ++k) {
      Eigen::Vector4d moved = pose;
      moved[k] += step[k];
      slope.col(k) = (at(moved, other, sweeps, any) - found).cwiseProduct(weight) / scale;
      ++solves;
    }
    Eigen::Vector4d by = slope.fullPivLu().solve(missing);
    double part = std::min(1.0, 0.1 * sensor_.thickness / by.norm());
    // Halved until it comes nearer.
    for (int halving = 0; halving < 8; ++halving, part /= 2) {
      const Eigen::Vector4d to = pose + part * by.cwiseProduct(weight);
      const PadWrench there = at(to, other, sweeps, settled);
      ++solves;
      if (halving < 7 && (wrench - there).cwiseProduct(weight).norm() > missing.norm()) continue;
      pose = to, found = there, std::swap(trial, other);
      break;
    }
  }
  change_ << pose[0] - contact_->depth, pose[1] - contact_->motion[0], pose[2] - contact_->motion[1],
      lever * (pose[3] - contact_->motion[2]);
  contact_ = std::move(trial);
  return end_step(solves, sweeps, settled && met, softer);
}

}  // namespace tactel::fem
