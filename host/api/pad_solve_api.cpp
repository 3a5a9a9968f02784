// SPDX-License-Identifier: Apache-2.0
#include <tactel/pad.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/angles.h"
#include "fem/pad/pad_presses.h"
#include "host/api/outcome.h"
#include "host/api/scene_conversion.h"
#include "host/contact/pad_solve.h"
#include "host/contact/pad_stream.h"
#include "host/contact/rung_for_many.h"
#include "host/scenes/unit_warnings.h"
#include "host/support/chosen_row.h"
#include "host/support/errors.h"
#include "kernels/shared/pad_layout.h"

namespace tactel {
namespace {

double or_nan(const std::optional<double>& number) { return number.value_or(std::numeric_limits<double>::quiet_NaN()); }
double twist_in_degrees(const fem::PadStep& step) { return fem::degrees(step.twist); }

template <class Matrix>
std::vector<double> list(const Matrix& from) {
  return {from.begin(), from.end()};
}

PadStep pad_step_of(const fem::PadStep& from) {
  PadStep step;
  step.indentation = from.indentation, step.tangential = {from.x, from.y}, step.twist = twist_in_degrees(from);
  step.P = from.P, step.Q = {from.Q[0], from.Q[1]}, step.M = from.M;
  step.slip_index = or_nan(from.slip_index), step.force_ratio = or_nan(from.force_ratio);
  step.stick_fraction = from.stick_fraction, step.slip_distance = from.slip_distance;
  for (const fem::GapStatus status : from.status) step.status.push_back(static_cast<NodeStatus>(status));
  step.normal_force = list(from.normal_force);
  for (const auto& force : from.tangential_force.rowwise()) step.tangential_force.push_back({force[0], force[1]});
  step.sigma_z = list(from.stress.col(0)), step.tau_x = list(from.stress.col(1)), step.tau_y = list(from.stress.col(2));
  step.converged = from.converged, step.iterations = from.iterations;
  const fem::PadResidual& r = from.residual;
  step.residual = {r.penetration, r.complementarity, r.cone, r.drift, r.angle};
  return step;
}

PadPath pad_path_of(const host::PadOutcome& outcome) {
  const fem::PadSolution& solution = outcome.solution;
  PadPath path;
  for (const fem::PadStep& step : solution.steps) path.steps.push_back(pad_step_of(step));
  path.cell_x = list(solution.places.col(0)), path.cell_y = list(solution.places.col(1));
  path.cell_width = {solution.cells.hx, solution.cells.hy};
  const auto [nx, ny] = outcome.scene.sensor.tactels;
  path.axes = outcome.scene.sensor.axes;
  const Eigen::MatrixX2d tactels = fem::tactel_places(outcome.scene.sensor);
  path.tactel_x = list(tactels.col(0).head(nx));
  for (Eigen::Index j = 0; j < ny; ++j) path.tactel_y.push_back(tactels(j * nx, 1));
  path.fell_back = outcome.solution.fell_back;
  path.rung = outcome.rung.name, path.model = host::model_name(outcome);
  path.solver = outcome.solver, path.precision = outcome.precision, path.device = outcome.device;
  if (const auto& error = outcome.error) {
    const auto& e = error->most95;
    path.error = {e.slip_index, error->largest, error->scenes, error->outside, e.P, e.Q,
                  e.M,          e.sigma,        e.tau,         error->from};
  }
  path.warnings = host::warnings(outcome);
  return path;
}

/// The answers of many scenes on their way into arrays.
class PadArrays {
 public:
  explicit PadArrays(std::span<const fem::PadScene> scenes) {
    PadPaths& p = paths;
    p.scenes = scenes.size();
    for (const fem::PadScene& scene : scenes) {
      p.steps_made.push_back(static_cast<std::uint32_t>(fem::pad_targets(scene.load).size()));
      p.steps = std::max<std::size_t>(p.steps, p.steps_made.back());
    }
    if (!scenes.empty()) {
      std::ranges::copy(scenes.front().sensor.tactels, p.tactels.begin());
      p.axes = scenes.front().sensor.axes;
    }
    tactels_ = p.tactels[0] * p.tactels[1];
    const std::size_t all = p.scenes * p.steps;
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    for (auto* list : {&p.slip_index, &p.force_ratio, &p.P, &p.M, &p.indentation, &p.twist, &p.stick_fraction})
      list->assign(all, nan);
    for (auto* list : {&p.Q, &p.tangential}) list->assign(2 * all, nan);
    for (auto* list : {&p.sigma_z, &p.tau_x, &p.tau_y}) list->assign(tactels_ * all, nan);
    p.converged.assign(all, 0), p.fell_back.assign(p.scenes, 0);
    reach.assign(p.scenes, {fem::nowhere, fem::nowhere});
  }

  void put(std::size_t i, const fem::PadSolution& solution) {
    reach[i] = {fem::nowhere, fem::nowhere};
    for (std::size_t k = 0; k < solution.steps.size(); ++k) {
      const fem::PadStep& step = solution.steps[k];
      put(i, k, step, std::span(step.stress.data(), 3 * tactels_));
    }
    paths.fell_back[i] = solution.fell_back;
  }

  /// The same of an answer in place.
  void put(std::size_t i, const host::LaneAnswer& answer, const fem::PadScene& scene) {
    const std::vector<fem::PadTarget> targets = fem::pad_targets(scene.load);
    stress_.resize(3 * tactels_);
    for (int k = 0; k < answer.steps; ++k) {
      const auto at = static_cast<std::size_t>(k);
      answer.tactels(k, std::span(stress_));
      put(i, at, host::pad_step([&](int row) { return answer.result(k, row); }, targets[at], scene.friction), stress_);
    }
  }

  /// Puts the answer of a step of the pressing that was solved alone.
  void put_alone(std::size_t i, std::size_t k, const fem::PadSolution& alone) {
    const fem::PadStep& step = alone.steps.back();
    put(i, k, step, std::span(step.stress.data(), 3 * tactels_));
    paths.fell_back[i] |= static_cast<std::uint8_t>(alone.fell_back);
  }

  PadPaths paths;
  std::vector<fem::PadBox> reach;  ///< [scenes] of the cells that touch, from the indenter's axis

 private:
  /// `stress`: [3 tactels], sigma_z, tau_x, tau_y of all.
  void put(std::size_t i, std::size_t k, const fem::PadStep& step, std::span<const double> stress) {
    PadPaths& p = paths;
    const std::size_t at = i * p.steps + k;
    reach[i].cover(step.reach);
    p.slip_index[at] = or_nan(step.slip_index), p.force_ratio[at] = or_nan(step.force_ratio);
    p.P[at] = step.P, p.M[at] = step.M;
    p.Q[2 * at] = step.Q[0], p.Q[2 * at + 1] = step.Q[1];
    p.indentation[at] = step.indentation, p.twist[at] = twist_in_degrees(step);
    p.tangential[2 * at] = step.x, p.tangential[2 * at + 1] = step.y;
    p.stick_fraction[at] = step.stick_fraction, p.converged[at] = step.converged;
    for (auto* list : {&p.sigma_z, &p.tau_x, &p.tau_y}) {
      std::ranges::copy(stress.first(tactels_), list->begin() + static_cast<std::ptrdiff_t>(at * tactels_));
      stress = stress.subspan(tactels_);
    }
  }

  std::size_t tactels_ = 0;
  std::vector<double> stress_;  ///< of one step
};

host::PadContactOptions kernel_of(const host::PadRung& rung, const std::optional<double>& tolerance) {
  host::PadContactOptions kernel{.cells = rung.cells, .increments = rung.increments};
  if (tolerance) kernel.tolerance = 0, kernel.accept = *tolerance;
  return kernel;
}

void check_tactels(std::span<const fem::PadScene> scenes) {
  const auto text = [](const fem::PadSensor& sensor) {
    return std::to_string(sensor.tactels[0]) + " x " + std::to_string(sensor.tactels[1]) + " of " +
           std::to_string(sensor.axes) + " axes";
  };
  for (std::size_t i = 1; i < scenes.size(); ++i)
    if (text(scenes[i].sensor) != text(scenes[0].sensor))
      throw ValueError("scenes[" + std::to_string(i) + "].sensor.tactels", text(scenes[i].sensor),
                       "those of scenes[0], " + text(scenes[0].sensor));
}

/// Returns the rung that is named, or the cheapest that keeps the accuracy on at most host::most_tried of the scenes,
/// or the usual one.
host::PadRung rung_for_pads(host::Executor& executor, const host::SolveOptions& options,
                            std::span<const fem::PadScene> scenes) {
  if (const auto rung = host::pad_rung_for_many(options)) return *rung;
  if (!options.accuracy) return host::usual_pad_rung();
  std::vector<fem::PadScene> sample;
  const std::size_t count = std::min<std::size_t>(scenes.size(), host::most_tried);
  for (std::size_t k = 0; k < count; ++k) sample.push_back(scenes[host::chosen_row(k, count, scenes.size())]);
  const std::vector<host::PadRung>& rungs = host::pad_rungs();
  const host::PadContact<float> rough(executor, kernel_of(rungs.front(), {}));
  const std::vector<fem::PadSolution> solutions =
      host::solve_pad_contact(rough, std::span<const fem::PadScene>(sample));
  const auto keeps = [&](const host::PadRung& rung) {
    for (std::size_t k = 0; k < count; ++k) {
      const double depth = host::deepest(solutions[k]);
      if (host::expected_pad_error(rung, sample[k], depth).most95.slip_index > *options.accuracy) return false;
    }
    return true;
  };
  const auto finest = std::prev(std::ranges::find(rungs, true, &host::PadRung::exact));
  return *std::find_if(rungs.begin(), finest, keeps);
}

}  // namespace

PadPath solve(const PadScene& scene, const SolveOptions& options) {
  return api::with_public_errors([&] {
    if (options.derivatives)
      throw ConfigError("command line", "--derivatives", "true", "left out for a pad, which has none");
    host::PadOutcome outcome = host::solve(api::to_fem(scene), api::to_host(options));
    PadPath path = pad_path_of(outcome);
    path.outcome = outcome_of(std::move(outcome));
    return path;
  });
}

PadPaths solve_many(std::span<const PadScene> scenes, const SolveOptions& options, const ProgressFunction& progress) {
  const std::vector<fem::PadScene> all = api::checked_scenes(scenes);
  return api::with_public_errors([&] {
    check_tactels(all);
    const host::SolveOptions asked = api::to_host_for_many(options);
    host::Executor executor{host::Device(asked.device)};
    const host::PadRung rung = rung_for_pads(executor, asked, all);
    const host::Precision precision = asked.precision == "fp64" ? host::Precision::fp64 : host::Precision::fp32;
    const host::PadStream stream(executor, {kernel_of(rung, asked.tolerance), precision});
    PadArrays arrays(all);
    std::vector<std::pair<std::size_t, std::size_t>> coarse;  // scene, step of the pressing
    const bool solved = stream.solve(
        all,
        [&](std::size_t i, const host::LaneAnswer& answer) {
          arrays.put(i, answer, all[i]);
          const auto across = [&](std::size_t k) {
            return static_cast<int>(answer.result(static_cast<int>(k), PAD_RESULT_ACROSS));
          };
          for (const std::size_t k : fem::coarse_presses(all[i].load, rung.cells, across)) coarse.emplace_back(i, k);
        },
        [&](std::size_t i, fem::PadSolution&& solution) { arrays.put(i, solution); },
        [&](std::size_t done) { return progress(done, all.size()); });
    if (!solved) throw Cancelled("solve_many: cancelled by progress");
    std::vector<fem::PadScene> alone;
    for (const auto& [i, k] : coarse) alone.push_back(fem::pressed_alone(all[i], k));
    const std::vector<fem::PadSolution> found = stream.solve(alone);
    for (std::size_t a = 0; a < coarse.size(); ++a) arrays.put_alone(coarse[a].first, coarse[a].second, found[a]);
    for (std::size_t i = 0; i < all.size(); ++i)
      api::with_public_errors(
          [&] {
            host::refuse_at_edge(all[i],
                                 host::distance_to_edge(all[i].sensor, all[i].indenter.position, arrays.reach[i]));
          },
          "scenes[" + std::to_string(i) + "]");
    arrays.paths.rung = rung.name, arrays.paths.precision = host::name(precision);
    arrays.paths.device = executor.device().info().name;
    arrays.paths.warnings = host::unit_warnings(std::span<const fem::PadScene>(all));
    progress(all.size(), all.size());
    return std::move(arrays.paths);
  });
}

}  // namespace tactel
