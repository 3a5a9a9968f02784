#pragma once
#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "fem/contact_laws.h"
#include "fem/gap_system.h"
#include "fem/scene.h"

namespace tactel::fem {

/// Where block and indenter are, and the forces between them, for one assumption about every gap element.
struct GapPose {
  std::vector<Trial> trial;                        ///< [columns]
  double depth = 0, tangential = 0;                ///< mm: where the indenter is
  Extended state;                                  ///< [state_size, 1] of the system
  Eigen::VectorXd gap, slip;                       ///< [columns] mm, as in GapElements
  Eigen::VectorXd normal_force, tangential_force;  ///< [columns] N/mm
  double force_tie = 0, length_tie = 0;            ///< N/mm, mm: what rounding may have done to forces and lengths
};

/// One load increment: what stays while statuses are tried.
struct GapIncrement {
  GapSystem& system;
  double mu;
  const Eigen::VectorXd& height;  ///< [columns] mm: profile over each surface node; +infinity where there is none
  LoadStep target;
  const GapPose& previous;  ///< its u_x and tangential position are the history of all nodes, touching or not
};

/// The block before any contact: the indenter over it, just touching.
GapPose undeformed(const GapSystem& system, const Eigen::VectorXd& height);

/// Right sides of GapSystem's rows, [2 columns, 3]: multiplied by (1, depth, tangential position) they say what the
/// trial asks for.
Extended right_side(const GapIncrement& increment, const std::vector<Trial>& trial);

/// Indenter position (1, depth, tangential) that gives the target where `force` [2 columns, 3] times it are the forces
/// on the rubber; none if it does not determine one.
std::optional<Eigen::Vector3d> indenter_position(const LoadStep& target, const Extended& force);

/// The pose that meets the trial's equations and the load target. With a force for target, the indenter's position is
/// an unknown and the sum of forces one more equation. None where that system is singular.
std::optional<GapPose> pose_of(const GapIncrement& increment, const std::vector<Trial>& trial);

/// What each element should be tried as next, to judge by this pose; the same trial where no law is violated by more
/// than rounding.
std::vector<Trial> next_trial(const GapIncrement& increment, const GapPose& pose);

/// The trials of one increment: how many were made, and the pose that came nearest to the laws.
struct GapSearch {
  int most, iterations = 0;
  std::optional<GapPose> nearest = std::nullopt;
  double violation = 0;  ///< of the nearest: largest relative residual

  bool exhausted() const { return iterations >= most; }
  /// Counts one trial and keeps its pose if it is the nearest so far.
  void record(const GapIncrement& increment, const std::optional<GapPose>& pose);
};

/// Simultaneous change of all violated elements, from `trial` on: fast, and nearly always successful. The pose that
/// violates nothing; none if a trial recurs or the search is exhausted.
std::optional<GapPose> switch_statuses(const GapIncrement& increment, std::vector<Trial> trial, GapSearch& search);

/// Follows the solution from the previous pose, one status change after another, as the load grows to its target:
/// slower, for increments where simultaneous changes cycle. The statuses at the target; none if the path does not get
/// there.
std::optional<std::vector<Trial>> follow_path(const GapIncrement& increment, GapSearch& search, double offset_size);

struct GapAnswer {
  GapPose pose;
  bool converged = false;
  int iterations = 0;
  Residual residual;
};

/// The increment's solution: from the previous statuses by simultaneous changes, else by the path. Converged says that
/// the residual, recomputed from displacements and forces, and the target's forces are within `tolerance`; otherwise
/// the nearest pose found.
GapAnswer solve_increment(const GapIncrement& increment, int most_iterations, double tolerance);

/// The elements of a pose as contact_residual wants them; the base's force is that of the rubber, nothing assumed.
GapElements elements_of(const GapIncrement& increment, const GapPose& pose);

}  // namespace tactel::fem
