// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/solve.h>

#include <span>
#include <vector>

#include "fem/contact_solution.h"
#include "fem/scene.h"
#include "host/contact/contact_batch.h"
#include "host/contact/solve.h"

namespace tactel::api {

/// The answers of many scenes as arrays, which grow with the longest path.
class PathArrays {
 public:
  /// Room for the steps that the loads ask for; of drags until sliding for the first ones.
  explicit PathArrays(std::span<const fem::Scene> scenes);

  /// Puts the numbers of a step, without stresses. Returns the places of sigma_y and tau_xy, [tactels].
  struct Stress {
    std::span<double> sigma_y, tau_xy;
  };
  Stress put(std::size_t scene, std::size_t step, const fem::ContactStep& from);
  /// Ends a scene that made so many steps.
  void end(std::size_t scene, std::size_t steps, bool sliding, bool fell_back);
  /// Puts a whole answer.
  void put(std::size_t scene, const fem::ContactSolution& solution);
  /// The same of an answer in place, without the increments between the steps that its load asks for: each pressing
  /// step has `parts`.
  void put(std::size_t scene, const host::LaneAnswer& answer, double mu, int parts);
  /// Returns the arrays, cut to the longest path that was made.
  Paths take();

 private:
  void widen(std::size_t steps);

  Paths paths_;
  std::vector<std::size_t> tactels_;  ///< [scenes]
  std::vector<double> stress_;        ///< of one step
};

/// Solves many scenes by streams (host/contact/contact_stream.h). Throws ConfigError for options that cannot be,
/// Cancelled where progress, in scenes, says so.
Paths solve_paths(const host::SolveOptions& options, std::span<const fem::Scene> scenes,
                  const ProgressFunction& progress);

}  // namespace tactel::api
