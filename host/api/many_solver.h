// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/solve.h>

#include <optional>
#include <span>
#include <vector>

#include "fem/contact_solution.h"
#include "fem/scene.h"
#include "host/contact/solve.h"
#include "host/device/executor.h"
#include "host/scenes/ladder.h"

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
  /// Puts a whole answer in the place of what there is.
  void put(std::size_t scene, const fem::ContactSolution& solution);
  /// Returns the arrays, cut to the longest path that was made.
  Paths take();

 private:
  void widen(std::size_t steps);

  Paths paths_;
  std::vector<std::size_t> tactels_;  ///< [scenes]
};

/// Solves many scenes. Each sensor has one launcher; scenes are laid out and gathered beside the device.
class ManySolver {
 public:
  /// Throws ConfigError for options that cannot be.
  ManySolver(const host::SolveOptions& options, std::span<const fem::Scene> scenes);
  /// Throws Cancelled where progress, in scenes, says so.
  Paths solve(const ProgressFunction& progress);

 private:
  struct Launched;
  template <class Real>
  void solve_on_patches(const std::vector<std::size_t>& which, const ProgressFunction& progress);
  template <class Real>
  void solve_on_meshes(const std::vector<std::size_t>& which, const ProgressFunction& progress);
  template <class Launcher, class Served>
  std::vector<std::size_t> launch(const Launcher& launcher, const std::vector<std::size_t>& which, const Served& served,
                                  const ProgressFunction& progress);
  std::vector<fem::Scene> copies(std::span<const std::size_t> which) const;

  host::SolveOptions options_;
  std::span<const fem::Scene> asked_;
  host::Executor executor_;
  std::optional<host::Rung> rung_;    ///< of all scenes
  host::Rung patch_;                  ///< of scenes on patches
  std::vector<fem::Scene> modelled_;  ///< as a rung on meshes has them; empty: as they were asked
  std::vector<int> parts_;            ///< [scenes] increments of a pressing step; empty: 1
  PathArrays arrays_;
  std::size_t done_ = 0;
};

}  // namespace tactel::api
