// SPDX-License-Identifier: Apache-2.0

// Only what a scene requires: each thing that a scene can do without, with it and without it, in one run. Lines called
// `needed` model what the scene requires, lines called `all` what any scene might. Load steps a second, all threads
// unless said otherwise.
#include <benchmark/benchmark.h>

#include <cmath>
#include <functional>
#include <random>

#include "fem/gap/gap_sweep.h"
#include "fem/gap/solution_difference.h"
#include "fem/numbers/cache_directory.h"
#include "host/answers/line_error.h"
#include "host/answers/planner.h"
#include "host/contact/lines/gap_sweep.h"
#include "host/contact/lines/solve_on_rung.h"
#include "host/scenes/ladder.h"
#include "tests/host/device/test_device.h"

namespace {

using namespace tactel;

constexpr double tolerance = 1e-4;
/// Two answers at that tolerance, base forces over the largest: slow lanes leave some 100 times their last change.
constexpr double agree = 100 * tolerance;

using Scenes = std::vector<fem::Scene>;
using Solutions = std::vector<fem::ContactSolution>;

fem::Sensor mesh(char which) {
  fem::Sensor sensor;
  sensor.columns = which == 'A' ? 123 : 41;
  sensor.rows = which == 'A' ? 33 : 11;
  return sensor;
}

using tactel::host::executor;

/// Parabolas of log-uniform radius and random friction, in the middle, with one path for all.
Scenes parabolas(const fem::Sensor& sensor, std::size_t count, const fem::Load& load, double least_radius = 1) {
  std::mt19937_64 random(1998);
  std::uniform_real_distribution<double> log_radius(std::log(least_radius), std::log(100.0)), friction(0.1, 1.5);
  Scenes scenes(count);
  for (fem::Scene& scene : scenes) {
    scene.sensor = sensor;
    scene.load = load;
    scene.indenter.shape = fem::Parabola{std::exp(log_radius(random))};
    scene.friction = friction(random);
  }
  return scenes;
}

fem::Load pressed(int steps) {
  fem::Load load;
  load.indentation_steps = steps;
  return load;
}

fem::Load dragged() {
  fem::Load load = pressed(1);
  load.tangential = {0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35};
  return load;
}

bool same_answers(benchmark::State& state, const Solutions& a, const Solutions& b) {
  for (std::size_t i = 0; i < a.size(); ++i)
    if (const double off = fem::base_force_difference(a[i], b[i]); !(off <= agree)) {
      state.SkipWithError(("base forces of scene " + std::to_string(i) + " differ by " + std::to_string(off)).c_str());
      return false;
    }
  return true;
}

void report(benchmark::State& state, double steps) {
  state.counters["steps_per_second"] = benchmark::Counter(steps, benchmark::Counter::kIsIterationInvariantRate);
}

/// Contacts for one launch, and how far the window of gap elements reaches.
struct Model {
  Scenes scenes;
  double reach = host::GapSweepOptions{}.reach;

  host::GapSweep<float>::Batch batch() const {
    host::GapSweepOptions options;
    options.tolerance = tolerance;
    options.tactels = options.nodes = false;
    options.reach = reach;
    return host::GapSweep<float>(executor(), scenes.front().sensor, options).prepare(scenes);
  }
};

Solutions sample(const host::GapSweep<float>::Batch& batch) {
  Solutions some;
  for (std::size_t i = 0; i < batch.size(); i += batch.size() / 16) some.push_back(batch.solution(i));
  return some;
}

/// The clock runs over `timed` alone; `other` is the same contacts modelled otherwise.
void launches(benchmark::State& state, const Model& timed, const Model& other) {
  auto batch = timed.batch();
  auto judge = other.batch();
  batch.run();
  judge.run();
  if (!same_answers(state, sample(batch), sample(judge))) return;
  for (auto _ : state) batch.run();
  report(state, static_cast<double>(batch.steps_in_all()));
}

Scenes with_friction(Scenes scenes, double mu) {
  for (fem::Scene& scene : scenes) scene.friction = mu;
  return scenes;
}

/// Scenes of several sensors: one C for each sensor, or one for each scene (out of the cache on disk).
void mixed_sensors(benchmark::State& state, bool one_for_all) {
  Scenes scenes = parabolas(mesh('B'), 24, dragged());
  for (std::size_t i = 0; i < scenes.size(); ++i) scenes[i].sensor.poisson = i % 2 ? 0.45 : 0.49;
  const auto solve = [&](bool together) {
    if (together) return host::solve_on_meshes(executor(), scenes, host::Precision::fp32, {.tolerance = tolerance});
    Solutions answers;
    for (const fem::Scene& scene : scenes)
      answers.push_back(
          host::solve_on_meshes(executor(), std::span(&scene, 1), host::Precision::fp32, {.tolerance = tolerance})[0]);
    return answers;
  };
  if (!same_answers(state, solve(one_for_all), solve(!one_for_all))) return;
  for (auto _ : state) benchmark::DoNotOptimize(solve(one_for_all));
  report(state, 8.0 * static_cast<double>(scenes.size()));
}

/// Blunt indenters at an error in S of 0.02: on the rung that the planner takes for them, or on the finest.
void contact_mesh(benchmark::State& state, bool planned) {
  constexpr double accuracy = 0.02;
  const Scenes scenes = parabolas({}, 48, dragged(), 30);
  const auto solve = [&](const host::Rung& rung) { return host::solve_on_rung(executor(), scenes, rung); };
  const host::RungChoice plan = host::plan(scenes, accuracy, solve);
  const host::Rung& finest = host::rung_named("mesh-321");
  const Solutions truth = solve(finest);
  std::size_t off = 0;
  for (std::size_t i = 0; i < scenes.size(); ++i)
    off += !(host::answer_error(scenes[i], plan.answers[i], plan.rung, truth[i], finest).S <= accuracy);
  if (20 * off > scenes.size()) {
    state.SkipWithError("more than 5 % of the contacts are off by more than what was asked for");
    return;
  }
  for (auto _ : state) benchmark::DoNotOptimize(solve(planned ? plan.rung : finest));
  report(state, 8.0 * static_cast<double>(scenes.size()));
  state.SetLabel(planned ? plan.rung.name : finest.name);
}

/// C for contacts that are their own mirror image, on the middle node and those right of it: n the same, t the opposite
/// on the other side. The middle node's t is zero: a compliance of 1 for itself alone keeps it so.
fem::Condensation fold(const fem::Condensation& full) {
  const Eigen::Index columns = full.surface_x.size(), middle = columns / 2, half = columns - middle;
  Eigen::MatrixXd unfold = Eigen::MatrixXd::Zero(2 * columns, 2 * half);
  for (Eigen::Index i = 0; i < half; ++i) {
    const Eigen::Index right = middle + i, left = columns - 1 - right;
    unfold(2 * left, 2 * i) -= 1;
    unfold(2 * right, 2 * i) += 1;
    unfold(2 * left + 1, 2 * i + 1) = unfold(2 * right + 1, 2 * i + 1) = 1;
  }
  fem::Condensation folded = full;
  folded.compliance = full.compliance.bottomRows(2 * half) * unfold;
  folded.compliance.row(0).setZero();
  folded.compliance(0, 0) = 1;
  folded.base_force = full.base_force * unfold;
  folded.tactel_stress = full.tactel_stress * unfold;
  folded.surface_x = full.surface_x.tail(half);
  return folded;
}

/// Pressed in the middle, nothing else: half of the unknowns will do. Plain Eigen, one core.
void symmetric(benchmark::State& state, bool half) {
  const fem::Condensation full = fem::condense_cached(mesh('B'), fem::default_cache_directory());
  const Scenes scenes = parabolas(mesh('B'), 64, pressed(4));
  const fem::Condensation folded = fold(full);
  const fem::GapSweep<float> whole(full, tolerance), right(folded, tolerance);
  const auto solve = [&](const fem::GapSweep<float>& sweep) {
    Solutions answers;
    for (const fem::Scene& scene : scenes) answers.push_back(sweep.solve(scene));
    return answers;
  };
  if (!same_answers(state, solve(right), solve(whole))) return;
  const fem::GapSweep<float>& timed = half ? right : whole;
  for (auto _ : state) benchmark::DoNotOptimize(solve(timed));
  report(state, 4.0 * static_cast<double>(scenes.size()));
}

void add(const std::string& name, std::function<void(benchmark::State&)> body) {
  benchmark::RegisterBenchmark(("needs/" + name).c_str(), std::move(body))
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
}

/// Both models are made when the benchmark runs, not when it is listed.
void add_launches(const std::string& name, const std::function<Model()>& needed, const std::function<Model()>& all) {
  add(name + "/needed", [=](benchmark::State& state) { launches(state, needed(), all()); });
  add(name + "/all", [=](benchmark::State& state) { launches(state, all(), needed()); });
}

const bool scene_needs_registered = [] {
  constexpr double everywhere = 1e6;  // indentations
  constexpr double hardly = 1e-30;    // friction that takes the general program to the same answer
  for (char which : {'B', 'A'}) {
    const std::string on = std::string("/mesh_") + which;
    const std::size_t count = which == 'A' ? 1536 : 12288;
    const auto drag = [=] { return parabolas(mesh(which), count, dragged()); };
    const auto press = [=] { return parabolas(mesh(which), count, pressed(4)); };
    add_launches(
        "window" + on, [=] { return Model{drag()}; },
        [=] {
          return Model{drag(), everywhere};
        });
    add_launches(
        "friction/pressed" + on, [=] { return Model{with_friction(press(), 0)}; },
        [=] { return Model{with_friction(press(), hardly)}; });
    add_launches(
        "friction/dragged" + on, [=] { return Model{with_friction(drag(), 0)}; },
        [=] { return Model{with_friction(drag(), hardly)}; });
  }
  for (bool needed : {true, false}) {
    const std::string name = needed ? "/needed" : "/all";
    add("compliance_per_sensor" + name, [=](benchmark::State& state) { mixed_sensors(state, needed); });
    add("contact_mesh" + name, [=](benchmark::State& state) { contact_mesh(state, needed); });
    add("symmetry" + name, [=](benchmark::State& state) { symmetric(state, needed); });
  }
  return true;
}();

}  // namespace
