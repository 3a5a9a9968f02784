// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <limits>

#include "fem/scenes/scene.h"

namespace tactel::fem {

/// Search for the indenter's position z = (depth, x) that gives the forces asked for, by Broyden's inverse update (C.
/// G. Broyden, Math. Comp. 19, 1965, 577-593) of P and Q - (Q target / P target) P; the depth is bracketed where x is
/// given. Forces are over E, mm. A trial that slides as a whole is halved back and not learned from.
class PatchForceControl {
 public:
  /// `first_touch`: depth at which the undeformed surface is touched, mm.
  explicit PatchForceControl(double first_touch);

  /// Sets the targets of an increment. Returns the depth to try first, from where the indenter is.
  double start(const LoadStep& target, double depth);

  /// Judges a trial and moves the indenter. Returns false, and leaves it, where the forces are within `tolerance`
  /// times the target.
  bool move(double P, double Q, double mu, double tolerance, double& depth, double& x);

 private:
  void update(const Eigen::Vector2d& z, const Eigen::Vector2d& g);

  static constexpr double infinity = std::numeric_limits<double>::infinity();
  Eigen::Matrix2d inverse_;  ///< of the Jacobian
  Eigen::Vector2d z_, g_;    ///< last trial that did not slide: position; P and Q - (Q target / P target) P
  double first_touch_;
  double low_ = 0, high_ = infinity;  ///< bracket of the depth
  LoadStep target_;
};

}  // namespace tactel::fem
