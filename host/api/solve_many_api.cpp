// SPDX-License-Identifier: Apache-2.0
#include <tactel/pad.h>

#include <algorithm>
#include <limits>

#include "fem/gap/load_stepping.h"
#include "host/answers/planner.h"
#include "host/answers/step_quantities.h"
#include "host/api/conversion.h"
#include "host/contact/limits.h"
#include "host/contact/lines/contact_stream.h"
#include "host/contact/pads/pad_stream.h"
#include "host/scenes/unit_warnings.h"
#include "host/support/errors.h"
#include "kernels/shared/contact_layout.h"
#include "kernels/shared/pad_layout.h"

namespace tactel {
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

template <class Value>
concept Stresses = requires(const Value& value) {
  value.cols();
};

/// Numbers of a value of a step in an array: one, two, or one a tactel.
std::size_t numbers_of(const auto&, std::size_t) { return 1; }
std::size_t numbers_of(const std::array<double, 2>&, std::size_t) { return 2; }
std::size_t numbers_of(const Eigen::Vector2d&, std::size_t) { return 2; }
std::size_t numbers_of(const Stresses auto&, std::size_t tactels) { return tactels; }

void put_numbers(auto to, const std::optional<double>& value) { *to = value.value_or(nan); }
void put_numbers(auto to, const auto& value) { *to = value; }
void put_numbers(auto to, const std::ranges::range auto& values) { std::ranges::copy(values, to); }

// What the kinds of contact differ in: tactels, steps that a load asks for (of a drag until sliding the first ones),
// and a step of an answer in place.

std::size_t tactels_of(const fem::Scene& scene) { return static_cast<std::size_t>(scene.sensor.tactels); }
std::size_t tactels_of(const fem::PadScene& scene) {
  return static_cast<std::size_t>(scene.sensor.tactels[0]) * static_cast<std::size_t>(scene.sensor.tactels[1]);
}

std::size_t room_for(const fem::Scene& scene) {
  const fem::Load& load = scene.load;
  return until_sliding(load) ? static_cast<std::size_t>(load.indentation_steps) + steps_until_sliding
                             : fem::load_path(load).steps.size();
}
std::size_t room_for(const fem::PadScene& scene) { return fem::pad_targets(scene.load).size(); }

fem::ContactStep step_of(const host::LaneAnswer& answer, int k, const fem::Scene& scene, const fem::LoadPath&) {
  fem::ContactStep step = host::lane_step([&](int row) { return answer.result(k, row); }, scene.friction);
  Eigen::MatrixX2d stress(scene.sensor.tactels, 2);
  answer.tactels(k, std::span(stress.data(), static_cast<std::size_t>(stress.size())));
  step.sigma_y = stress.col(0), step.tau_xy = stress.col(1);
  return step;
}
fem::PadStep step_of(const host::LaneAnswer& answer, int k, const fem::PadScene& scene, const host::PadPath& path) {
  const double mu = scene.friction_map ? answer.result(k, PAD_RESULT_MU) : scene.friction;
  fem::PadStep step =
      host::pad_step([&](int row) { return answer.result(k, row); }, path.steps[static_cast<std::size_t>(k)], mu);
  step.stress.resize(static_cast<Eigen::Index>(tactels_of(scene)), 3);
  answer.tactels(k, std::span(step.stress.data(), static_cast<std::size_t>(step.stress.size())));
  return step;
}

/// The answers of many scenes as arrays, which grow with the longest path.
template <class Kind, class Paths>
class PathArrays {
 public:
  using Scene = typename Kind::Scene;
  using Solution = typename Kind::Solution;
  using Step = typename decltype(Solution::steps)::value_type;

  explicit PathArrays(std::span<const Scene> scenes) {
    std::size_t steps = 0;
    for (const Scene& scene : scenes)
      steps = std::max(steps, room_for(scene)), tactels_ = std::max(tactels_, tactels_of(scene));
    paths.scenes = scenes.size();
    paths.steps_made.resize(scenes.size()), paths.fell_back.resize(scenes.size());
    if constexpr (of_lines)
      paths.sliding.resize(scenes.size()), paths.tactels = tactels_;
    else
      reach.assign(scenes.size(), {fem::nowhere, fem::nowhere});
    widen(steps);
  }

  void put(std::size_t i, const Solution& solution) {
    for (std::size_t k = 0; k < solution.steps.size(); ++k) put(i, k, solution.steps[k]);
    paths.steps_made[i] = static_cast<std::uint32_t>(solution.steps.size());
    paths.fell_back[i] = solution.fell_back;
    if constexpr (of_lines) paths.sliding[i] = solution.sliding;
  }

  /// The same of an answer in place, without the increments between the steps that its load asks for: each pressing
  /// step has `parts`.
  void put(std::size_t i, const host::LaneAnswer& answer, const Scene& scene, int parts = 1) {
    const auto path = Kind::path(scene);
    std::uint32_t& made = paths.steps_made[i];
    for (int k = 0; k < answer.steps; ++k) {
      const int status = static_cast<int>(answer.result(k, RESULT_STATUS));
      if (status == LANE_NOT_RUN) break;
      const bool pressing = k < answer.indentation_steps;
      if constexpr (of_lines) paths.sliding[i] = status == LANE_SLIDING && !pressing;
      if (!pressing || (k + 1) % parts == 0) put(i, made++, step_of(answer, k, scene, path));
    }
  }

  /// Puts the answer of a step that was solved alone.
  void put_alone(std::size_t i, std::size_t k, const Solution& alone) {
    put(i, k, alone.steps.back());
    paths.fell_back[i] |= static_cast<std::uint8_t>(alone.fell_back);
  }

  /// Returns the arrays, cut to the longest path that was made.
  Paths take() {
    widen(paths.steps_made.empty() ? 0 : std::ranges::max(paths.steps_made));
    return std::move(paths);
  }

  Paths paths;
  std::vector<fem::PadBox> reach;  ///< [scenes] of pads: of the cells that touch, from the indenter's axis

 private:
  static constexpr bool of_lines = std::is_same_v<Kind, host::LineContacts>;

  void put(std::size_t i, std::size_t k, const Step& step) {
    if (k >= paths.steps) widen(2 * paths.steps + steps_until_sliding);
    const std::size_t at = i * paths.steps + k;
    host::each_pair(host::quantities<true>(paths), host::quantities<true>(step), [&](auto& list, const auto& value) {
      put_numbers(list.begin() + static_cast<std::ptrdiff_t>(at * numbers_of(value, tactels_)), value);
    });
    paths.slip_index[at] = std::clamp(paths.slip_index[at], -1.0, 1.0);  // as in sets
    if constexpr (!of_lines) reach[i].cover(step.reach);
  }
  void widen(std::size_t steps) {
    if (steps == paths.steps) return;
    const Step none{};
    host::each_pair(host::quantities<true>(paths), host::quantities<true>(none),
                    [&]<class Number>(std::vector<Number>& list, const auto& value) {
                      const std::size_t numbers = numbers_of(value, tactels_);
                      set_row(list, paths.scenes, paths.steps * numbers, steps * numbers,
                              std::numeric_limits<Number>::quiet_NaN());  // of a word 0
                    });
    paths.steps = steps;
  }

  std::size_t tactels_ = 0;  ///< of a row
};

/// The answers of scenes of the line, without warnings.
Paths solve_paths(const SolveOptions& options, std::span<const fem::Scene> scenes, const ProgressFunction& progress) {
  host::Executor executor{host::Device(options.device)};
  const SolveOptions modelling{.accuracy = options.accuracy, .rung = options.rung};
  const std::optional<host::Rung> asked =
      host::rung_for_many(executor, modelling, {scenes.size(), [&](std::uint64_t k) { return scenes[k]; }});
  host::Rung rung = asked.value_or(host::usual_patch());
  rung.precision = host::precision_named(options.precision, rung.precision);
  if (options.tolerance) rung.accept_at_most(*options.tolerance);
  const host::Precision meshes = asked ? rung.precision : host::precision_named(options.precision);

  PathArrays<host::LineContacts, Paths> arrays(scenes);
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
        [&](std::size_t k, const host::LaneAnswer& answer, auto&&) {
          arrays.put(which[k], answer, scenes[which[k]], parts[k]);
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

void check_tactels(std::span<const fem::PadScene> scenes) {
  const auto text = [](const fem::PadSensor& sensor) {
    return std::to_string(sensor.tactels[0]) + " x " + std::to_string(sensor.tactels[1]) + " of " +
           std::to_string(sensor.axes) + " axes";
  };
  for (std::size_t i = 1; i < scenes.size(); ++i)
    if (text(scenes[i].sensor) != text(scenes[0].sensor))
      throw ValueError("scenes[" + std::to_string(i) + "].sensor.tactels", text(scenes[i].sensor),
                       "those of scenes[0], " + text(scenes[0].sensor));
  for (std::size_t i = 0; i < scenes.size(); ++i)
    api::with_public_errors([&] { fem::require_times(scenes[i]); }, "scenes[" + std::to_string(i) + "]");
  for (std::size_t i = 0; i < scenes.size(); ++i)
    if (scenes[i].markers)
      throw ValueError("scenes[" + std::to_string(i) + "].markers", "given",
                       "left out: solve and PadStepper have displacements of markers");
}

/// Returns the rung that is named, or the cheapest that keeps the accuracy on those of the scenes that are tried, the
/// finest below the reference where none does, or the usual one.
host::PadRung rung_for_pads(host::Executor& executor, const SolveOptions& options,
                            std::span<const fem::PadScene> scenes) {
  if (const auto rung = host::named_rung_for_many<host::PadRung>(options)) return *rung;
  if (!options.accuracy) return host::usual_pad_rung();
  const auto tried = host::tried_of(scenes.size(), [&](std::uint64_t k) { return scenes[k]; });
  const std::vector<fem::PadSolution> solutions =
      host::PadStream(executor, host::model_of(host::all_rungs<host::PadRung>().front())).solve(tried);
  const host::PadRung& cheapest = host::cheapest_pad_rung(
      tried, *options.accuracy, [&](std::size_t k) { return host::deepest(tried[k], solutions[k]); });
  return cheapest.exact ? *std::prev(&cheapest) : cheapest;
}

}  // namespace

Paths solve_many(std::span<const Scene> scenes, const SolveOptions& options, const ProgressFunction& progress) {
  const std::vector<fem::Scene> all = api::checked_scenes(scenes);
  return api::with_public_errors([&] {
    api::check_for_many(options);
    Paths paths = solve_paths(options, all, progress);
    paths.warnings = host::unit_warnings(all);
    progress(all.size(), all.size());
    return paths;
  });
}

PadPaths solve_many(std::span<const PadScene> scenes, const SolveOptions& options, const ProgressFunction& progress) {
  const std::vector<fem::PadScene> all = api::checked_scenes(scenes);
  return api::with_public_errors([&] {
    check_tactels(all);
    api::check_for_many(options);
    host::Executor executor{host::Device(options.device)};
    const host::PadRung rung = rung_for_pads(executor, options, all);
    host::PadModel model = host::model_of(rung);
    model.precision = host::precision_named(options.precision);
    if (options.tolerance) model.options.tolerance = 0, model.options.accept = *options.tolerance;
    const host::PadStream stream(executor, model);
    PathArrays<host::PadContacts, PadPaths> arrays(all);
    if (!all.empty())
      std::ranges::copy(all[0].sensor.tactels, arrays.paths.tactels.begin()), arrays.paths.axes = all[0].sensor.axes;
    const bool solved = stream.solve(
        all,
        [&](std::size_t i, const host::LaneAnswer& answer, host::PadStream::Alone&& alone) {
          arrays.put(i, answer, all[i]);
          for (const auto& [step, solution] : alone) arrays.put_alone(i, step, solution);
        },
        [&](std::size_t i, fem::PadSolution&& solution) { arrays.put(i, solution); },
        [&](std::size_t done) { return progress(done, all.size()); });
    if (!solved) throw Cancelled("solve_many: cancelled by progress");
    for (std::size_t i = 0; i < all.size(); ++i)
      api::with_public_errors(
          [&] {
            host::refuse_at_edge(all[i],
                                 host::distance_to_edge(all[i].sensor, all[i].indenter.position, arrays.reach[i]));
          },
          "scenes[" + std::to_string(i) + "]");
    PadPaths paths = arrays.take();
    paths.rung = rung.name, paths.precision = host::name(model.precision), paths.device = executor.device().info().name;
    paths.warnings = host::unit_warnings(std::span<const fem::PadScene>(all));
    progress(all.size(), all.size());
    return paths;
  });
}

}  // namespace tactel
