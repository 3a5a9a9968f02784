// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "fem/gap/contact_laws.h"
#include "fem/gap/gap_system.h"
#include "fem/scenes/scene.h"

namespace tactel::fem {

/// Positions of block and indenter, and the forces between them, for one assumed status of every gap element.
struct GapPose {
  std::vector<Trial> trial;                        ///< [columns]
  double depth = 0, tangential = 0;                ///< mm: position of the indenter
  Extended state;                                  ///< [state_size, 1] of the system
  Eigen::VectorXd gap, slip;                       ///< [columns] mm, as in GapElements
  Eigen::VectorXd normal_force, tangential_force;  ///< [columns] N/mm
  double force_tie = 0, length_tie = 0;            ///< N/mm, mm: bounds of the rounding errors of forces and lengths
};

/// One load increment: the data that stay fixed while statuses are tried.
struct GapIncrement {
  GapSystem& system;
  double mu;
  const Eigen::VectorXd& height;  ///< [columns] mm: profile above each surface node; +infinity beyond the indenter
  LoadStep target;
  const GapPose& previous;  ///< its u_x and tangential position are the history of all nodes, touching or not
};

/// Returns the pose before any contact: the indenter just touches the block.
GapPose undeformed(const GapSystem& system, const Eigen::VectorXd& height);

/// Returns the right-hand sides of GapSystem's rows, [2 columns, 3]. Multiplied by (1, depth, tangential
/// position) they are the conditions of the trial.
Extended right_side(const GapIncrement& increment, const std::vector<Trial>& trial);

/// Returns the indenter position (1, depth, tangential) that meets the target, where `force` [2 columns, 3] times
/// it is the force on the rubber. Returns none where the target does not determine a position.
std::optional<Eigen::Vector3d> indenter_position(const LoadStep& target, const Extended& force);

/// Returns the pose that meets the trial's equations and the load target. With a force target, the indenter's
/// position is an unknown and the sum of forces an additional equation. Returns none where that system is
/// singular.
std::optional<GapPose> pose_of(const GapIncrement& increment, const std::vector<Trial>& trial);

/// Returns the next trial of each element, judged by this pose. Returns the same trial where no law is violated
/// by more than rounding.
std::vector<Trial> next_trial(const GapIncrement& increment, const GapPose& pose);

/// The search of one increment: the number of trials, and the pose nearest to the laws.
struct GapSearch {
  int most, iterations = 0;
  std::optional<GapPose> nearest = std::nullopt;
  double violation = 0;  ///< of the nearest: largest relative residual

  bool exhausted() const { return iterations >= most; }
  /// Counts a trial and keeps its pose if it is the nearest so far.
  void record(const GapIncrement& increment, const std::optional<GapPose>& pose);
};

/// Active-set method: changes all violated elements simultaneously, from `trial` on. It is fast and nearly always
/// succeeds. Returns the pose that violates nothing, or none if a trial recurs or the search is exhausted.
std::optional<GapPose> switch_statuses(const GapIncrement& increment, std::vector<Trial> trial, GapSearch& search);

struct GapAnswer {
  GapPose pose;
  bool converged = false;
  int iterations = 0;
  Residual residual;
};

/// Returns the solution of the increment: by simultaneous changes from the previous statuses, else by path
/// following. `converged` means that the residual, recomputed from displacements and forces, and the target's
/// forces are within `tolerance`. Otherwise the pose is the nearest one found.
GapAnswer solve_increment(const GapIncrement& increment, int most_iterations, double tolerance);

/// Returns the elements of a pose as contact_residual takes them. The base's force is computed from the rubber,
/// not assumed.
GapElements elements_of(const GapIncrement& increment, const GapPose& pose);

}  // namespace tactel::fem
