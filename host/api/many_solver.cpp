// SPDX-License-Identifier: Apache-2.0
#include "host/api/many_solver.h"

#include <algorithm>
#include <limits>

#include "fem/load_stepping.h"
#include "host/contact/contact_stream.h"
#include "host/contact/rung_for_many.h"
#include "kernels/shared/contact_layout.h"

namespace tactel::api {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t steps_until_sliding = 16;  ///< room for the drag of a path whose steps are not known

bool on_mesh(const fem::Scene& scene) { return scene.model == fem::SurfaceModel::mesh; }

bool until_sliding(const fem::Load& load) {
  return load.tangential_step != 0 && !load.tangential_steps && load.tangential.empty();
}

/// Moves rows of `from` numbers apart, or closer, to rows of `to` numbers.
template <class Number>
void set_row(std::vector<Number>& list, std::size_t rows, std::size_t from, std::size_t to, Number fill) {
  std::vector<Number> other(rows * to, fill);
  for (std::size_t i = 0; i < rows; ++i)
    std::copy_n(list.begin() + static_cast<std::ptrdiff_t>(i * from), std::min(from, to),
                other.begin() + static_cast<std::ptrdiff_t>(i * to));
  list.swap(other);
}

/// The answers of many scenes as arrays, which grow with the longest path.
class PathArrays {
 public:
  /// Room for the steps that the loads ask for; of drags until sliding for the first ones.
  explicit PathArrays(std::span<const fem::Scene> scenes) {
    std::size_t steps = 0;
    for (const fem::Scene& scene : scenes) {
      const fem::Load& load = scene.load;
      const auto pressed = static_cast<std::size_t>(load.indentation_steps);
      steps = std::max(steps, until_sliding(load) ? pressed + steps_until_sliding : fem::load_path(load).steps.size());
      tactels_.push_back(static_cast<std::size_t>(scene.sensor.tactels));
      paths_.tactels = std::max(paths_.tactels, tactels_.back());
    }
    paths_.scenes = scenes.size();
    paths_.steps_made.resize(paths_.scenes);
    paths_.sliding.resize(paths_.scenes), paths_.fell_back.resize(paths_.scenes);
    widen(steps);
  }

  void put(std::size_t scene, const fem::ContactSolution& solution) {
    for (std::size_t k = 0; k < solution.steps.size(); ++k) {
      const fem::ContactStep& step = solution.steps[k];
      const Stress to = put(scene, k, step);
      std::ranges::copy(step.sigma_y, to.sigma_y.begin());
      std::ranges::copy(step.tau_xy, to.tau_xy.begin());
    }
    end(scene, solution.steps.size(), solution.sliding, solution.fell_back);
  }

  /// The same of an answer in place, without the increments between the steps that its load asks for: each pressing
  /// step has `parts`.
  void put(std::size_t scene, const host::LaneAnswer& answer, double mu, int parts) {
    std::size_t step = 0;
    bool sliding = false;
    for (int made = 0; made < answer.steps; ++made) {
      const auto result = [&](int row) { return answer.result(made, row); };
      const int status = static_cast<int>(result(RESULT_STATUS));
      if (status == LANE_NOT_RUN) break;
      const bool pressing = made < answer.indentation_steps;
      sliding = status == LANE_SLIDING && !pressing;
      if (pressing && (made + 1) % parts != 0) continue;
      const Stress to = put(scene, step++, host::lane_step(result, mu));
      const std::size_t tactels = to.sigma_y.size();
      stress_.resize(2 * tactels);
      answer.tactels(made, std::span(stress_));
      std::copy_n(stress_.begin(), tactels, to.sigma_y.begin());
      std::copy_n(stress_.begin() + static_cast<std::ptrdiff_t>(tactels), tactels, to.tau_xy.begin());
    }
    end(scene, step, sliding, false);
  }

  /// Returns the arrays, cut to the longest path that was made.
  Paths take() {
    std::size_t most = 0;
    for (const std::uint32_t steps : paths_.steps_made) most = std::max<std::size_t>(most, steps);
    widen(most);
    return std::move(paths_);
  }

 private:
  struct Stress {
    std::span<double> sigma_y, tau_xy;
  };
  /// Puts the numbers of a step, without stresses. Returns the places of sigma_y and tau_xy, [tactels].
  Stress put(std::size_t scene, std::size_t step, const fem::ContactStep& from) {
    if (step >= paths_.steps) widen(2 * paths_.steps + steps_until_sliding);
    Paths& p = paths_;
    const std::size_t at = scene * p.steps + step;
    p.slip_index[at] = std::clamp(from.slip_index.value_or(nan), -1.0, 1.0);  // as in sets
    p.P[at] = from.P, p.Q[at] = from.Q;
    p.indentation[at] = from.indentation, p.tangential[at] = from.tangential;
    p.converged[at] = from.converged;
    const auto place = [&](std::vector<double>& list) {
      return std::span(list).subspan(at * p.tactels, tactels_[scene]);
    };
    return {place(p.sigma_y), place(p.tau_xy)};
  }
  void end(std::size_t scene, std::size_t steps, bool sliding, bool fell_back) {
    paths_.steps_made[scene] = static_cast<std::uint32_t>(steps);
    paths_.sliding[scene] = sliding, paths_.fell_back[scene] = fell_back;
  }
  void widen(std::size_t steps) {
    Paths& p = paths_;
    if (steps == p.steps) return;
    for (auto* list : {&p.slip_index, &p.P, &p.Q, &p.indentation, &p.tangential})
      set_row(*list, p.scenes, p.steps, steps, nan);
    for (auto* list : {&p.sigma_y, &p.tau_xy}) set_row(*list, p.scenes, p.steps * p.tactels, steps * p.tactels, nan);
    set_row(p.converged, p.scenes, p.steps, steps, std::uint8_t(0));
    p.steps = steps;
  }

  Paths paths_;
  std::vector<std::size_t> tactels_;  ///< [scenes]
  std::vector<double> stress_;        ///< of one step
};

}  // namespace

Paths solve_paths(const host::SolveOptions& options, std::span<const fem::Scene> scenes,
                  const ProgressFunction& progress) {
  host::Executor executor{host::Device(options.device)};
  host::SolveOptions modelling;
  modelling.rung = options.rung, modelling.accuracy = options.accuracy;
  const std::optional<host::Rung> asked =
      host::rung_for_many(executor, modelling, {scenes.size(), [&](std::uint64_t k) { return scenes[k]; }});
  host::Rung rung = asked.value_or(host::usual_patch());
  if (!options.precision.empty())
    rung.precision = options.precision == "fp64" ? host::Precision::fp64 : host::Precision::fp32;
  if (options.tolerance) rung.accept_at_most(*options.tolerance);
  const host::Precision own = options.precision == "fp64" ? host::Precision::fp64 : host::Precision::fp32;
  const host::Precision meshes = asked ? rung.precision : own;

  PathArrays arrays(scenes);
  std::size_t done = 0;
  const auto solve = [&](bool on_meshes) {
    std::vector<std::size_t> which;
    for (std::size_t i = 0; i < scenes.size(); ++i)
      if ((asked ? !rung.patch() : on_mesh(scenes[i])) == on_meshes) which.push_back(i);
    if (which.empty()) return;
    const bool meshed = on_meshes && asked;
    std::vector<int> parts(which.size(), 1);  // increments of a pressing step
    std::vector<fem::Scene> modelled;         // empty: as they were asked
    for (std::size_t k = 0; k < which.size() && (meshed || which.size() < scenes.size()); ++k) {
      const fem::Scene& scene = scenes[which[k]];
      modelled.push_back(meshed ? host::on_mesh(scene, rung) : scene);
      if (!meshed) continue;
      parts[k] = fem::pressing_parts(scene.load, rung.steps);
      modelled.back().load.indentation_steps = scene.load.indentation_steps * parts[k];
    }
    host::ContactModel model = host::model_of(rung);
    if (on_meshes && !asked) {
      host::GapSweepOptions sweep;
      if (options.tolerance) sweep.accept = *options.tolerance;
      model = {host::MeshModel{sweep}, meshes};
    }
    const host::ContactStream stream(executor, std::move(model));
    const bool all = stream.solve(
        modelled.empty() ? scenes : modelled,
        [&](std::size_t k, const host::LaneAnswer& answer) {
          arrays.put(which[k], answer, scenes[which[k]].friction, parts[k]);
        },
        [&](std::size_t k, fem::ContactSolution&& solution) {
          if (parts[k] > 1) fem::keep_own_steps(solution, scenes[which[k]].load, parts[k]);
          arrays.put(which[k], solution);
        },
        [&](std::size_t some) { return progress(done + some, scenes.size()); });
    if (!all) throw Cancelled("solve_many: cancelled by progress");
    done += which.size();
  };
  solve(false);
  solve(true);
  Paths paths = arrays.take();
  if (asked || std::ranges::none_of(scenes, on_mesh)) paths.rung = rung.name;
  paths.precision = name(meshes);
  paths.device = executor.device().info().name;
  return paths;
}

}  // namespace tactel::api
