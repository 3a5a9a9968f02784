// SPDX-License-Identifier: Apache-2.0
#include "host/api/many_solver.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <limits>
#include <map>
#include <tuple>

#include "fem/layer/layer_model.h"
#include "fem/layer/linear_elements.h"
#include "fem/load_stepping.h"
#include "host/contact/gap_sweep.h"
#include "host/contact/patch_contact.h"
#include "host/contact/rung_for_many.h"
#include "host/contact/solve_on_rung.h"
#include "kernels/shared/contact_layout.h"

namespace tactel::api {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t launch_scenes = 8192;      ///< of one launch, at most
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

/// Groups of scenes that share a launch: equal keys, in the order of their first scene.
template <class KeyOf>
std::vector<std::vector<std::size_t>> groups(const std::vector<std::size_t>& which, const KeyOf& key_of) {
  std::vector<std::vector<std::size_t>> all;
  std::map<decltype(key_of(0)), std::size_t> places;
  for (const std::size_t i : which) {
    const auto [place, is_new] = places.try_emplace(key_of(i), all.size());
    if (is_new) all.emplace_back();
    all[place->second].push_back(i);
  }
  return all;
}

auto layer_key(const fem::Sensor& s) {
  return std::tuple(s.length, s.thickness, s.poisson, s.tactels, s.tactel_span.value_or(-1), s.tactel_width);
}
auto mesh_key(const fem::Sensor& s) {
  return std::tuple_cat(layer_key(s), std::tuple(s.columns, s.rows, s.grading, s.element, s.stress));
}

template <class View>
bool every_step_solved(const View& view, std::size_t i) {
  for (int k = 0; k < view.path_steps(i); ++k)
    if (const int status = static_cast<int>(view.result(i, k, LANE_STATUS));
        status == LANE_UNSOLVED || status == LANE_INVALID)
      return false;
  return true;
}

/// Puts the answer of the kernel for scene k of a view, without the increments between the steps that it asks for.
template <class View>
void put_answer(PathArrays& arrays, std::size_t scene, const View& view, std::size_t k, double mu, int parts,
                std::vector<double>& stress) {
  const int pressed = view.indentation_steps(k);
  std::size_t step = 0;
  bool sliding = false;
  for (int made = 0; made < view.path_steps(k); ++made) {
    const auto said = [&](int row) { return static_cast<double>(view.result(k, made, row)); };
    const int status = static_cast<int>(said(LANE_STATUS));
    if (status == LANE_NOT_RUN) break;
    sliding = status == LANE_SLIDING && made >= pressed;
    if (made < pressed && (made + 1) % parts != 0) continue;
    const PathArrays::Stress to = arrays.put(scene, step++, host::lane_step(said, mu));
    const std::size_t tactels = to.sigma_y.size();
    stress.resize(2 * tactels);
    view.answer(k).tactels(made, std::span(stress));
    std::copy_n(stress.begin(), tactels, to.sigma_y.begin());
    std::copy_n(stress.begin() + static_cast<std::ptrdiff_t>(tactels), tactels, to.tau_xy.begin());
  }
  arrays.end(scene, step, sliding, false);
}

}  // namespace

PathArrays::PathArrays(std::span<const fem::Scene> scenes) {
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

void PathArrays::widen(std::size_t steps) {
  Paths& p = paths_;
  if (steps == p.steps) return;
  for (auto* list : {&p.slip_index, &p.P, &p.Q, &p.indentation, &p.tangential})
    set_row(*list, p.scenes, p.steps, steps, nan);
  for (auto* list : {&p.sigma_y, &p.tau_xy}) set_row(*list, p.scenes, p.steps * p.tactels, steps * p.tactels, nan);
  set_row(p.converged, p.scenes, p.steps, steps, std::uint8_t(0));
  p.steps = steps;
}

PathArrays::Stress PathArrays::put(std::size_t scene, std::size_t step, const fem::ContactStep& from) {
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

void PathArrays::end(std::size_t scene, std::size_t steps, bool sliding, bool fell_back) {
  Paths& p = paths_;
  for (std::size_t at = scene * p.steps + steps; at < scene * p.steps + p.steps_made[scene]; ++at) {
    for (auto* list : {&p.slip_index, &p.P, &p.Q, &p.indentation, &p.tangential}) (*list)[at] = nan;
    for (auto* list : {&p.sigma_y, &p.tau_xy})
      std::fill_n(list->begin() + static_cast<std::ptrdiff_t>(at * p.tactels), p.tactels, nan);
    p.converged[at] = 0;
  }
  p.steps_made[scene] = static_cast<std::uint32_t>(steps);
  p.sliding[scene] = sliding, p.fell_back[scene] = fell_back;
}

void PathArrays::put(std::size_t scene, const fem::ContactSolution& solution) {
  for (std::size_t k = 0; k < solution.steps.size(); ++k) {
    const fem::ContactStep& step = solution.steps[k];
    const Stress to = put(scene, k, step);
    std::ranges::copy(step.sigma_y, to.sigma_y.begin());
    std::ranges::copy(step.tau_xy, to.tau_xy.begin());
  }
  end(scene, solution.steps.size(), solution.sliding, solution.fell_back);
}

Paths PathArrays::take() {
  std::size_t most = 0;
  for (const std::uint32_t steps : paths_.steps_made) most = std::max<std::size_t>(most, steps);
  widen(most);
  return std::move(paths_);
}

ManySolver::ManySolver(const host::SolveOptions& options, std::span<const fem::Scene> scenes)
    : options_(options), asked_(scenes), executor_(host::Device(options.device)), arrays_(scenes) {
  host::SolveOptions modelling;
  modelling.rung = options.rung, modelling.accuracy = options.accuracy;
  rung_ = host::rung_for_many(executor_, modelling, {scenes.size(), [&](std::uint64_t k) { return scenes[k]; }});
  patch_ = rung_.value_or(host::usual_patch());
  if (!options.precision.empty())
    patch_.precision = options.precision == "fp64" ? host::Precision::fp64 : host::Precision::fp32;
  if (options.tolerance) patch_.accept_at_most(*options.tolerance);
  if (patch_.patch()) return;
  for (const fem::Scene& scene : scenes) {
    host::MeshedScene meshed = host::meshed_with_own_steps(scene, patch_);
    modelled_.push_back(std::move(meshed.scene));
    parts_.push_back(meshed.parts);
  }
}

std::vector<fem::Scene> ManySolver::copies(std::span<const std::size_t> which) const {
  std::vector<fem::Scene> scenes;
  scenes.reserve(which.size());
  for (const std::size_t i : which) scenes.push_back(modelled_.empty() ? asked_[i] : modelled_[i]);
  return scenes;
}

/// Lays out the next scenes, and gathers the ones before, while the device computes. Returns those that are not served.
template <class Launcher, class Served>
std::vector<std::size_t> ManySolver::launch(const Launcher& launcher, const std::vector<std::size_t>& which,
                                            const Served& served, const ProgressFunction& progress) {
  using Batch = typename Launcher::Batch;
  std::vector<std::size_t> others;
  const auto part = [&](std::size_t first) {
    return std::span(which).subspan(first, std::min(launch_scenes, which.size() - first));
  };
  const auto laid_out = [&](std::size_t first) {
    return std::async(std::launch::async, [&, first] { return launcher.prepare(copies(part(first))); });
  };
  const auto gather = [&](const Batch& batch, std::size_t first) {
    const typename Batch::View view(batch);
    std::vector<double> stress;
    for (std::size_t k = 0; k < batch.size(); ++k) {
      const std::size_t i = part(first)[k];
      if (served(view, k, i))
        put_answer(arrays_, i, view, k, asked_[i].friction, parts_.empty() ? 1 : parts_[i], stress);
      else
        others.push_back(i);
    }
  };
  std::future<Batch> next = laid_out(0);
  std::future<void> gathered;
  for (std::size_t first = 0; first < which.size(); first += launch_scenes) {
    if (!progress(done_, asked_.size())) throw Cancelled("solve_many: cancelled by progress");
    Batch batch = next.get();
    if (first + launch_scenes < which.size()) next = laid_out(first + launch_scenes);
    batch.run();
    if (gathered.valid()) gathered.get();
    gathered = std::async(std::launch::async, [&gather, batch, first] { gather(batch, first); });
    done_ += batch.size();
  }
  gathered.get();
  return others;
}

template <class Real>
void ManySolver::solve_on_patches(const std::vector<std::size_t>& which, const ProgressFunction& progress) {
  const host::PatchContactOptions options = host::patch_options(patch_);
  const auto served = [&](const auto& view, std::size_t k, std::size_t i) {
    return every_step_solved(view, k) && !fem::needs_linear_pressure(asked_[i].sensor, view.patch(k, PATCH_ELEMENT)) &&
           !host::grown_contact<Real>(view, k, options.elements);
  };
  for (const auto& alike : groups(which, [&](std::size_t i) { return layer_key(asked_[i].sensor); })) {
    const fem::Sensor& sensor = asked_[alike.front()].sensor;
    const host::PatchContact<Real> launcher(
        executor_, options.sides ? fem::layer_model(sensor) : fem::endless_layer(sensor), options);
    std::vector<std::size_t> others;
    for (const auto& kind : groups(alike, [&](std::size_t i) {
           const host::ContactKind k = host::kind_of(asked_[i]);
           return std::pair(k.force, k.friction);
         }))
      std::ranges::copy(launch(launcher, kind, served, progress), std::back_inserter(others));
    const std::vector<fem::Scene> scenes = copies(others);
    auto answers = host::solve_patch_contact(launcher, scenes);
    host::finish_on_mesh(host::mesh_solver(executor_, patch_, false), scenes, patch_, answers);
    for (std::size_t k = 0; k < others.size(); ++k) arrays_.put(others[k], answers[k]);
  }
}

template <class Real>
void ManySolver::solve_on_meshes(const std::vector<std::size_t>& which, const ProgressFunction& progress) {
  host::GapSweepOptions options = rung_ ? host::mesh_options(patch_, false) : host::GapSweepOptions{.nodes = false};
  if (options_.tolerance) options.tolerance = 0, options.accept = *options_.tolerance;
  const auto& scenes = modelled_;
  const auto at = [&](std::size_t i) -> const fem::Scene& { return scenes.empty() ? asked_[i] : scenes[i]; };
  const auto served = [](const auto& view, std::size_t k, std::size_t) { return every_step_solved(view, k); };
  for (const auto& alike : groups(which, [&](std::size_t i) { return mesh_key(at(i).sensor); })) {
    const host::GapSweep<Real> launcher(executor_, at(alike.front()).sensor, options);
    std::vector<std::size_t> others;
    for (const auto& kind : groups(alike, [&](std::size_t i) {
           const host::ContactKind k = host::kind_of(asked_[i]);
           return std::pair(k.force, k.friction);
         }))
      std::ranges::copy(launch(launcher, kind, served, progress), std::back_inserter(others));
    auto answers = host::solve_gap_sweep(executor_, copies(others),
                                         sizeof(Real) == 4 ? host::Precision::fp32 : host::Precision::fp64, options);
    for (std::size_t k = 0; k < others.size(); ++k) {
      if (!parts_.empty()) fem::keep_own_steps(answers[k], asked_[others[k]].load, parts_[others[k]]);
      arrays_.put(others[k], answers[k]);
    }
  }
}

Paths ManySolver::solve(const ProgressFunction& progress) {
  std::vector<std::size_t> of_model[2];
  for (std::size_t i = 0; i < asked_.size(); ++i) of_model[rung_ ? !patch_.patch() : on_mesh(asked_[i])].push_back(i);
  const host::Precision own = options_.precision == "fp64" ? host::Precision::fp64 : host::Precision::fp32;
  const host::Precision meshes = rung_ ? patch_.precision : own;
  if (patch_.precision == host::Precision::fp32)
    solve_on_patches<float>(of_model[0], progress);
  else
    solve_on_patches<double>(of_model[0], progress);
  if (meshes == host::Precision::fp32)
    solve_on_meshes<float>(of_model[1], progress);
  else
    solve_on_meshes<double>(of_model[1], progress);
  Paths paths = arrays_.take();
  if (rung_ || of_model[1].empty()) paths.rung = patch_.name;
  paths.precision = name(meshes);
  paths.device = executor_.device().info().name;
  return paths;
}

}  // namespace tactel::api
