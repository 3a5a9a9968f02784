// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "host/contact/planner.h"
#include "host/contact/rung_error.h"
#include "host/device/executor.h"

namespace tactel::host {

struct TradeoffOptions {
  std::size_t scenes =
      288;  ///< for patches; meshes, which are slower, are judged on the first third of them, 8 at least
  std::uint64_t seed = 1998;
  std::function<bool(const std::string& what, std::size_t done, std::size_t total)> progress{};  ///< false stops
};

/// Error and speed of a model on the mix of scenes.
struct MeasuredModel {
  Rung rung;
  ErrorQuantiles error;         ///< against the judge
  double unsolved = 0;          ///< share of increments that missed the model's tolerance
  double sweeps = 0;            ///< Gauss-Seidel sweeps an increment, mean
  double steps_per_second = 0;  ///< requested load increments, in a batch; 0: not timed
  bool front = false;           ///< no other model is as fast with a smaller 95 % error in S
};

/// Models that differ from the judge in one quantity alone.
struct ErrorSource {
  std::string what;
  Rung judge;
  std::vector<MeasuredModel> models{};
};

struct Tradeoff {
  std::string mix, device;
  std::size_t scenes = 0;
  std::uint64_t seed = 0;
  double reference_error = 0;           ///< 95 % quantile of the reference's own error in S, by extrapolation
  double observed_order = 0;            ///< of the median error in S with the elements of the reference
  std::size_t smooth_scenes = 0;        ///< smooth indenters on more than smooth_width mm
  ErrorQuantiles mesh_agreement{};      ///< of these: the finest mesh beside the reference
  double full_mesh_difference = 0;      ///< condensed against full-mesh solver on the same mesh, S, largest
  double full_mesh_per_second = 0;      ///< requested load increments per second, full mesh, one core
  std::vector<MeasuredModel> models{};  ///< named rungs first
  std::vector<ErrorSource> sources{};
  std::vector<MeasuredRung> planner{};  ///< for the rungs of the ladder
};
inline constexpr double smooth_width = 2;  ///< mm

/// Throws Stopped where progress returns false.
Tradeoff measure_tradeoff(Executor& executor, const TradeoffOptions& options);

/// Result of the planner on scenes that did not serve to measure it.
struct Promise {
  std::string what;  ///< which scenes: "the mix", or what makes them unlike it
  double accuracy = 0;
  std::size_t scenes = 0;              ///< all of them
  std::size_t kept = 0;                ///< error in S within the accuracy; scenes sent to the reference count as kept
  std::vector<std::size_t> by_rung{};  ///< [ladder] scenes
};
/// Plans each of `options.scenes` scenes of the mix, and as many unlike it, by itself for each accuracy. Judges the
/// answers by the reference. Returns the promises on the mix, then on each class of the others, then on all others.
std::vector<Promise> verify_planner(Executor& executor, const TradeoffOptions& options,
                                    const std::vector<double>& accuracies);

/// Returns requested load increments per second: scenes of the mix on one sensor in one batch, best of a few runs.
double steps_per_second(Executor& executor, const Rung& rung);

}  // namespace tactel::host
