// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <array>
#include <memory>
#include <optional>
#include <utility>

#include "fem/pad/creep_history.h"
#include "fem/pad/pad_contact.h"
#include "fem/pad/pad_solver.h"
#include "fem/pad/pad_surface.h"

namespace tactel::fem {

/// A force on a pad: P, Qx, Qy (N), M (N mm) about the object's axis.
using PadWrench = Eigen::Vector4d;

/// What a step of one contact says, in the frame of the pad.
struct SteppedState {
  PadWrench force = PadWrench::Zero();
  double slip_index = 0;  ///< S; 0 where mu P = 0
  double stick_fraction = 0;
  int touching = 0;     ///< cells
  bool met = true;      ///< the wrench, and the accepted residual
  bool slides = false;  ///< every cell that touches slips, or friction does not bear the wrench
  double slid = 0;      ///< mm: rms slide of the cells that touch in this step
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  ///< mm: their mean slide, PadContact::mean_slide
  int solves = 0, sweeps = 0;
  PadResidual residual;
};

/// One contact with a pad that takes an increment a call, fp64: the twin of kernels/pad_step.cl. Cells are fixed to the
/// pad. A wrench is searched by Newton's method on differences: each solve starts from the history before the step. It
/// shares no code with the kernel, whose search is Broyden's.
class SteppedContact {
 public:
  SteppedContact(const PadLayer& layer, const PadSensor& sensor, const PadCells& cells, double mu,
                 const PadOptions& options = {});

  /// Seconds that a step takes, of rubber that creeps (PadSensor::relaxation).
  double dt = 0;

  /// Friction of each cell from the next step on, [cells].
  void set_friction(Eigen::VectorXd mu) { contact_->set_friction(std::move(mu)); }
  /// What the next step takes: the object over the cells, and its axis.
  void set_surface(const PadSurface& surface, std::array<double, 2> axis = {0, 0});

  /// Steps to a depth (mm) and a motion x, y (mm), twist (rad) about the axis, of the whole way.
  SteppedState move(double depth, const PadMotion& motion);
  /// Steps to a wrench that friction bears, to `tolerance` of P; not met where it does not.
  SteppedState press(const PadWrench& wrench, double tolerance);

  double depth() const { return contact_->depth; }
  const PadMotion& motion() const { return contact_->motion; }
  const PadContact& contact() const { return *contact_; }

 private:
  Eigen::Vector4d change_to(const PadContact& contact, double depth, const PadMotion& motion) const;
  bool solve(PadContact& contact, double depth, const PadMotion& motion, int& sweeps) const;
  PadWrench force(const PadContact& contact) const;
  SteppedState state(int solves, int sweeps, bool settled) const;
  SteppedState end_step(int solves, int sweeps, bool settled, double softer);

  PadSensor sensor_;
  PadCells cells_;
  PadOptions options_;
  std::shared_ptr<const PadInfluence> influence_{};
  std::shared_ptr<const PadTable> table_{};  ///< instead, of a pad with free sides
  std::unique_ptr<PadContact> contact_;
  std::array<double, 2> axis_{};
  Eigen::Vector4d change_ = Eigen::Vector4d::Zero();
  std::optional<CreepHistory> creep_{};
};

}  // namespace tactel::fem
