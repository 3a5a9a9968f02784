// SPDX-License-Identifier: Apache-2.0

// Load steps a second: random parabolas and friction, one indentation step and seven of drag, base forces and
// certificate written out. The batched kernel beside the same algorithm in plain Eigen (one core) and the full-mesh
// reference.
#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <string>

#include "bench/fma_peak.h"
#include "bench/random_parabolas.h"
#include "fem/gap/gap_condensed.h"
#include "fem/gap/gap_reference.h"
#include "fem/gap/gap_sweep.h"
#include "fem/gap/solution_difference.h"
#include "fem/layer/patch_solver.h"
#include "fem/numbers/cache_directory.h"
#include "host/contact/lines/contact_fallback.h"
#include "host/contact/lines/gap_sweep.h"
#include "host/contact/lines/patch_contact.h"
#include "host/studies/tradeoff/scene_mix.h"
#include "kernels/shared/contact_layout.h"

namespace {

using namespace tactel;

using bench::mesh;
using bench::random_parabolas;

/// Multiplications and additions that the algorithm needs for nodes that touch, twice the fused operations: sweeps, the
/// certificate's rows, output rows. Rows of the certificate at nodes that do not touch are left out.
template <class Batch>
double useful_flops(const Batch& batch, int outputs) {
  double flops = 0;
  for (std::size_t i = 0; i < batch.size(); ++i)
    for (int k = 0; k < batch.steps(); ++k) {
      const double touching = batch.result(i, k, RESULT_STICKING) + batch.result(i, k, RESULT_SLIPPING);
      flops += 8 * touching * touching * (batch.result(i, k, RESULT_SWEEPS) + 1) + 4 * touching * outputs;
    }
  return flops;
}

/// What the kernel writes beside results and certificate: forces of all base nodes, or as sets do, stresses at the
/// tactels and the sums of base forces.
enum class Written { base_forces, tactels };

/// Sweeps that a lane takes part in, its own or its neighbours': a group makes as many as its slowest lane.
template <class Real>
double sweeps_with_neighbours(const typename host::GapSweep<Real>::Batch& batch, std::size_t group) {
  const typename host::GapSweep<Real>::Batch::View view(batch);
  const auto order = view.by_lane();
  double sum = 0, steps = 0;
  for (std::size_t first = 0; first < order.size(); first += group)
    for (int k = 0; k < batch.steps(); ++k) {
      Real most = 0;
      const std::size_t end = std::min(first + group, order.size());
      for (std::size_t i = first; i < end; ++i) most = std::max(most, view.result(order[i], k, RESULT_SWEEPS));
      sum += static_cast<double>(end - first) * most;
      steps += static_cast<double>(end - first);
    }
  return sum / steps;
}

template <class Real>
void batched(benchmark::State& state, const fem::Sensor& sensor, std::size_t count, double tolerance,
             Written written = Written::base_forces) {
  host::Executor executor{host::Device()};
  host::GapSweepOptions options;
  options.tolerance = tolerance, options.accept = fem::slow_on_mesh * tolerance;  // in fp64, too
  options.nodes = false;
  options.tactels = options.base_sums = written == Written::tactels;
  const auto scenes = random_parabolas(sensor, count);
  host::GapSweep<Real> sweep(executor, scenes.front().sensor, options);
  auto batch = sweep.prepare(scenes);
  batch.run();
  // The twin sweeps without damping. On fine meshes it may go round in circles where the kernel converges; the
  // active-set method answers then.
  const fem::GapSweep<double> twin(sweep.condensation(), 1e-11, 2000);
  const fem::GapCondensed active_set(sweep.condensation());
  double worst = 0;
  const std::size_t checked = sensor.columns > 321 ? 4 : 16;  // one takes the twin seconds on the finest mesh
  for (std::size_t i = 0; i < scenes.size(); i += scenes.size() / checked) {
    const fem::ContactSolution found = batch.solution(i);
    fem::ContactSolution expected = twin.solve(scenes[i]);
    if (!host::every_step_converged(expected)) expected = active_set.solve(scenes[i]);
    for (std::size_t k = 0; k < found.steps.size(); ++k)
      worst = std::max(worst, bench::difference(scenes[i].friction, found.steps[k], expected.steps[k]));
    const double P = expected.steps.back().P;
    const double off = written == Written::tactels ? std::abs(found.steps.back().P - P) / P +
                                                         std::abs(found.steps.back().Q - expected.steps.back().Q) / P
                                                   : fem::base_force_difference(found, expected);
    if (!(off <= 100 * tolerance)) {
      state.SkipWithError("forces differ from the Eigen twin's");
      return;
    }
  }
  double unsolved = 0, sweeps = 0, residual = 0, pressing = 0, first_drag = 0;
  for (std::size_t i = 0; i < scenes.size(); ++i)
    for (int k = 0; k < batch.steps(); ++k) {
      unsolved += static_cast<int>(batch.result(i, k, RESULT_STATUS)) >= LANE_UNSOLVED;
      sweeps += batch.result(i, k, RESULT_SWEEPS);
      if (k == 0) pressing += batch.result(i, k, RESULT_SWEEPS);
      if (k == 1) first_drag += batch.result(i, k, RESULT_SWEEPS);
      for (int row : {RESULT_PENETRATION, RESULT_CONE, RESULT_COMPLEMENTARITY, RESULT_DRIFT, RESULT_OWN_RESIDUAL})
        residual = std::max(residual, batch.result(i, k, row));
    }
  for (auto _ : state) batch.run();
  const double steps = static_cast<double>(batch.steps_in_all());
  const auto per_second = benchmark::Counter::kIsIterationInvariantRate;
  state.counters["steps_per_second"] = benchmark::Counter(steps, per_second);
  const int outputs =
      written == Written::tactels ? 2 + 2 * sensor.tactels : 2 * static_cast<int>(sweep.condensation().base_x.size());
  const double flops = useful_flops(batch, outputs);
  state.counters["GFLOP/s"] = benchmark::Counter(1e-9 * flops, per_second);
  state.counters["kFLOP_a_step"] = 1e-3 * flops / steps;
  state.counters["sweeps"] = sweeps / steps;
  state.counters["sweeps_press"] = pressing / static_cast<double>(scenes.size());
  state.counters["sweeps_first_drag"] = first_drag / static_cast<double>(scenes.size());
  state.counters["sweeps_with_neighbours"] = sweeps_with_neighbours<Real>(
      batch, 3 * static_cast<std::size_t>(
                     executor.device().lanes(sizeof(Real) == 4 ? host::Precision::fp32 : host::Precision::fp64)));
  state.counters["sweeps_of_warp"] = sweeps_with_neighbours<Real>(batch, 32);
  state.counters["unsolved"] = unsolved / steps;
  state.counters["worst_residual"] = residual;
  state.counters["worst_off"] = worst;
  state.counters["threads"] = executor.threads();
  state.SetLabel(executor.device().info().name);
}

template <class Real>
void eigen(benchmark::State& state, char which, double tolerance) {
  const fem::Condensation condensation = fem::condense_cached(mesh(which), fem::default_cache_directory());
  const fem::GapSweep<Real> sweep(condensation, tolerance);
  const auto scenes = random_parabolas(mesh(which), 64);
  std::size_t next = 0;
  for (auto _ : state) benchmark::DoNotOptimize(sweep.solve(scenes[next++ % scenes.size()]).steps.back().P);
  state.counters["steps_per_second"] = benchmark::Counter(8, benchmark::Counter::kIsIterationInvariantRate);
}

void reference(benchmark::State& state, char which) {
  const auto scenes = random_parabolas(mesh(which), 8);
  std::size_t next = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(fem::solve_gap_reference(scenes[next++ % scenes.size()]).steps.back().P);
  state.counters["steps_per_second"] = benchmark::Counter(8, benchmark::Counter::kIsIterationInvariantRate);
}

/// The same scenes on patches: 4 increments to press with 12 elements, of which one is asked for, and 7 of drag.
std::vector<fem::Scene> random_patches(std::size_t count) {
  std::vector<fem::Scene> scenes = random_parabolas(mesh('B'), count);
  for (fem::Scene& scene : scenes) scene.load.tangential_step = 0.03;
  return scenes;
}

/// Multiplications and additions that the scenes need, twice the fused operations: sweeps and fresh sums of the load
/// path over all elements of a patch, search, compliance with sides, base stress. Those of lanes that wait do not
/// count.
template <class View>
double patch_flops(const View& view, std::size_t scenes, int elements, int tactels) {
  constexpr double search_elements = 12, side_modes = 8;
  const double n = elements, certificates = n / 3 + 7;
  double flops = 0;
  for (std::size_t i = 0; i < scenes; ++i) {
    double sweeps = 0;
    for (int k = 0; k < view.path_steps(i); ++k) sweeps += view.result(i, k, RESULT_SWEEPS);
    flops += 8 * n * n * (sweeps + certificates) +
             2 * search_elements * search_elements * view.patch(i, PATCH_SEARCH_SWEEPS) + 4 * n * n * side_modes +
             8 * n * tactels * view.path_steps(i);
  }
  return flops;
}

/// The same scenes, each on a sensor of its own: nu, thickness, E and length drawn.
std::vector<fem::Scene> random_sensors(std::size_t count, const fem::SensorRange& range) {
  std::vector<fem::Scene> scenes = random_patches(count);
  std::mt19937_64 generator(3);
  const auto uniform = [&](double from, double to) { return std::uniform_real_distribution(from, to)(generator); };
  for (fem::Scene& scene : scenes) {
    fem::Sensor& sensor = scene.sensor;
    sensor.poisson = uniform(range.poisson_low, range.poisson_high);
    sensor.thickness = uniform(1.4, 1.6);
    sensor.length = uniform(18, 21);
    sensor.young = uniform(1, 3);
  }
  return scenes;
}

template <class Real>
void patches(benchmark::State& state, const std::vector<fem::Scene>& scenes, const host::PatchContact<Real>& contact,
             const host::Executor& executor) {
  const int elements = contact.options().elements;
  auto batch = contact.prepare(scenes);
  batch.run();
  for (std::size_t i = 0; i < scenes.size(); i += scenes.size() / 16) {
    const auto model = contact.model_of(scenes[i].sensor);
    const fem::PatchSolver twin(*model, {.elements = elements, .most_sweeps = 400, .most_growths = 0});
    const fem::ContactStep found = batch.solution(i).steps.back(), expected = twin.solve(scenes[i]).steps.back();
    if (!(std::abs(found.P - expected.P) + std::abs(found.Q - expected.Q) <= 3e-5 * expected.P)) {
      state.SkipWithError("forces differ from the twin's");
      return;
    }
  }
  double unsolved = 0, sweeps = 0, residual = 0, flops = 0;
  {
    const typename host::PatchContact<Real>::Batch::View view(batch);
    for (std::size_t i = 0; i < scenes.size(); ++i)
      for (int k = 0; k < view.path_steps(i); ++k) {
        unsolved += static_cast<int>(view.result(i, k, RESULT_STATUS)) >= LANE_UNSOLVED;
        sweeps += view.result(i, k, RESULT_SWEEPS);
        for (int row : {RESULT_PENETRATION, RESULT_CONE, RESULT_COMPLEMENTARITY, RESULT_DRIFT})
          residual = std::max(residual, static_cast<double>(view.result(i, k, row)));
      }
    flops = patch_flops(view, scenes.size(), elements, 2 * scenes.front().sensor.tactels);
  }
  for (auto _ : state) batch.run();
  const double steps = static_cast<double>(batch.steps_in_all());
  const auto per_second = benchmark::Counter::kIsIterationInvariantRate;
  state.counters["steps_per_second"] = benchmark::Counter(steps, per_second);
  state.counters["GFLOP/s"] = benchmark::Counter(1e-9 * flops, per_second);
  state.counters["sweeps"] = sweeps / steps;
  state.counters["unsolved"] = unsolved / steps;
  state.counters["worst_residual"] = residual;
  state.counters["threads"] = executor.threads();
  state.SetLabel(executor.device().info().name);
}

template <class Real>
void patches(benchmark::State& state, int elements) {
  host::Executor executor{host::Device()};
  const auto scenes = random_patches(65536);
  patches<Real>(state, scenes,
                {executor, fem::layer_model(scenes.front().sensor), {.elements = elements, .accept = 0.02}}, executor);
}

/// `sensors` of them, by turns.
void patches_on_sensors(benchmark::State& state, std::size_t sensors) {
  host::Executor executor{host::Device()};
  constexpr fem::SensorRange range{.poisson_low = 0.3, .poisson_high = 0.499, .longest = 15};
  auto scenes = random_sensors(65536, range);
  for (std::size_t i = sensors; i < scenes.size(); ++i) scenes[i].sensor = scenes[i % sensors].sensor;
  patches<float>(state, scenes, {executor, fem::SensorFamily(range), {.elements = 12}}, executor);
}

/// Scenes of the ladder's mix (host/studies/tradeoff/scene_mix.h) on the default sensor, as `tactel tradeoff` times
/// them: 9 load steps each, of which the first takes n / 3 increments.
std::vector<fem::Scene> mixed_patches(std::size_t count) {
  std::vector<fem::Scene> scenes = host::mixed_scenes(7, count);
  for (fem::Scene& scene : scenes) scene.sensor.poisson = fem::Sensor{}.poisson;
  return scenes;
}

/// Sweeps of a scene's load path with those for its neighbours in a group of `lanes`, the mean. One lane: its own.
template <class Real>
double path_sweeps(const typename host::PatchContact<Real>::Batch& batch, std::size_t lanes) {
  const typename host::PatchContact<Real>::Batch::View view(batch);
  const std::span<const std::size_t> order = view.by_lane();
  double sweeps = 0;
  for (std::size_t first = 0; first < order.size(); first += lanes) {
    const std::size_t end = std::min(first + lanes, order.size());
    for (int k = 0; k < view.path_steps(order[first]); ++k) {
      Real most = 0;
      for (std::size_t i = first; i < end; ++i) most = std::max(most, view.result(order[i], k, RESULT_SWEEPS));
      sweeps += static_cast<double>(end - first) * most;
    }
  }
  return sweeps / static_cast<double>(order.size());
}

/// Every increment is a load step here, so that the sweeps of each are known.
template <class Real>
auto every_increment(const host::PatchContact<Real>& contact, std::vector<fem::Scene> scenes) {
  const int increments = fem::PatchOptions{.elements = contact.options().elements}.increments();
  for (fem::Scene& scene : scenes) scene.load.indentation_steps = increments;
  auto batch = contact.prepare(scenes);
  batch.run();
  return batch;
}

/// Rate of all stages; time of each in one core's us a scene; the load path beside the peak. All are medians of runs
/// that take turns in one process.
template <class Real>
void mixed(benchmark::State& state, int elements, int threads) {
  const host::Device device("basic");
  host::Executor executor(device, {.threads = threads});
  const auto scenes = mixed_patches(16384);
  const fem::LayerModel model = fem::layer_model(scenes.front().sensor);
  const host::PatchContact<Real> contact(executor, model, {.elements = elements});
  auto batch = contact.prepare(scenes);
  bench::Peak<Real> peak(device, threads);
  if (!peak.right()) return state.SkipWithError("the accumulators did not converge to 1");
  // Sweeps of whole groups, and the fresh sums of the certificate, of 4 n^2 multiply-adds a lane each.
  const auto steps = every_increment(contact, scenes);
  const double increments = static_cast<double>(steps.steps()),
               sweeps = path_sweeps<Real>(steps, device.lanes(peak.precision));
  const double flops = 8.0 * elements * elements * static_cast<double>(scenes.size()) * (sweeps + increments);
  state.counters["path_sweeps"] = path_sweeps<Real>(steps, 1);
  state.counters["path_sweeps_with_neighbours"] = sweeps;
  state.counters["path_sweeps_of_warp"] = path_sweeps<Real>(steps, 32);
  const auto seconds = [&](bool path, bool base_stress) {
    host::PatchContact<Real>::set_parts(batch, path, base_stress);
    batch.run();
    return batch.seconds();
  };
  seconds(true, true);
  std::vector<double> all, without_stress, without_path, of_peak;
  for (auto _ : state) {
    all.push_back(seconds(true, true));
    without_stress.push_back(seconds(true, false));
    without_path.push_back(seconds(false, false));
    of_peak.push_back(peak.run());
  }
  const double whole = bench::median(all), path_end = bench::median(without_stress),
               set_up = bench::median(without_path);
  const double path_rate = 1e-9 * flops / (path_end - set_up), roof = 1e-9 * peak.flops / bench::median(of_peak);
  const double us = 1e6 * threads / static_cast<double>(scenes.size());
  state.counters["steps_per_second"] = static_cast<double>(batch.steps_in_all()) / whole;
  state.counters["search_us"] = us * set_up;
  state.counters["path_us"] = us * (path_end - set_up);
  state.counters["stress_us"] = us * (whole - path_end);
  state.counters["path_GFLOP/s"] = path_rate;
  state.counters["peak_GFLOP/s"] = roof;
  state.counters["path_of_peak"] = path_rate / roof;
  state.counters["threads"] = threads;
}

/// One launch of `count` patches: a press and a drag each, so that a million fits into memory.
void contacts_at_once(benchmark::State& state, std::size_t count) {
  host::Executor executor{host::Device()};
  auto scenes = random_patches(count);
  for (fem::Scene& scene : scenes) scene.load.tangential_steps = 1;
  const host::PatchContact<float> contact(executor, fem::layer_model(scenes.front().sensor));
  auto batch = contact.prepare(scenes);
  for (auto _ : state) batch.run();
  state.counters["steps_per_second"] =
      benchmark::Counter(static_cast<double>(batch.steps_in_all()), benchmark::Counter::kIsIterationInvariantRate);
}

/// From scenes to answers on the host: layout of lanes, launch, views.
void patches_with_scenes(benchmark::State& state) {
  host::Executor executor{host::Device()};
  const auto scenes = random_patches(65536);
  const host::PatchContact<float> contact(executor, fem::layer_model(scenes.front().sensor));
  double P = 0;
  for (auto _ : state) {
    auto batch = contact.prepare(scenes);
    batch.run();
    const host::PatchContact<float>::Batch::View view(batch);
    for (const std::size_t i : view.by_lane()) P += view.result(i, 0, RESULT_P);
  }
  benchmark::DoNotOptimize(P);
  state.counters["steps_per_second"] =
      benchmark::Counter(8.0 * static_cast<double>(scenes.size()), benchmark::Counter::kIsIterationInvariantRate);
}

void patch_twin(benchmark::State& state, int elements) {
  const auto scenes = random_patches(64);
  const fem::LayerModel model = fem::layer_model(scenes.front().sensor);
  const fem::PatchSolver twin(model, {.elements = elements});
  std::size_t next = 0;
  for (auto _ : state) benchmark::DoNotOptimize(twin.solve(scenes[next++ % scenes.size()]).steps.back().P);
  state.counters["steps_per_second"] = benchmark::Counter(8, benchmark::Counter::kIsIterationInvariantRate);
}

const bool contact_registered = [] {
  const auto add = [](const char* name, auto body) {
    return benchmark::RegisterBenchmark(name, body)->Unit(benchmark::kMillisecond);
  };
  add("contact/mesh_B/fp32", [](benchmark::State& state) {
    batched<float>(state, mesh('B'), 65536, 1e-4);
  })->UseRealTime();
  add("contact/mesh_A/fp32", [](benchmark::State& state) {
    batched<float>(state, mesh('A'), 8192, 1e-4);
  })->UseRealTime();
  add("contact/mesh_B/tactels/fp32", [](benchmark::State& state) {
    batched<float>(state, mesh('B'), 65536, 1e-4, Written::tactels);
  })->UseRealTime();
  add("contact/mesh_A/tactels/fp32", [](benchmark::State& state) {
    batched<float>(state, mesh('A'), 8192, 1e-4, Written::tactels);
  })->UseRealTime();
  for (const int columns : {41, 81, 161, 321, 641})
    add(("scaling/columns:" + std::to_string(columns)).c_str(), [columns](benchmark::State& state) {
      fem::Sensor sensor = mesh('B');
      sensor.columns = columns;
      batched<float>(state, sensor, 65536 * 41 / columns * 41 / columns, 1e-4, Written::tactels);
    })->UseRealTime();
  for (const int contacts : {1, 10, 100, 1000, 10000, 100000, 1000000})
    add(("scaling/contacts:" + std::to_string(contacts)).c_str(), [contacts](benchmark::State& state) {
      contacts_at_once(state, static_cast<std::size_t>(contacts));
    })->UseRealTime();
  add("contact/mesh_B/fp32/tolerance:1e-6", [](benchmark::State& state) {
    batched<float>(state, mesh('B'), 65536, 1e-6);
  })->UseRealTime();
  add("contact/mesh_B/fp64", [](benchmark::State& state) {
    batched<double>(state, mesh('B'), 65536, 1e-4);
  })->UseRealTime();
  add("contact/mesh_A/fp64", [](benchmark::State& state) {
    batched<double>(state, mesh('A'), 8192, 1e-4);
  })->UseRealTime();
  add("contact/mesh_B/eigen_fp32", [](benchmark::State& state) { eigen<float>(state, 'B', 1e-4); });
  add("contact/mesh_A/eigen_fp32", [](benchmark::State& state) { eigen<float>(state, 'A', 1e-4); });
  add("contact/mesh_B/eigen_fp64", [](benchmark::State& state) { eigen<double>(state, 'B', 1e-4); });
  add("contact/mesh_A/eigen_fp64", [](benchmark::State& state) { eigen<double>(state, 'A', 1e-4); });
  for (const int elements : {8, 12, 16, 24}) {
    const auto named = [&](const char* part) { return "contact/patch_" + std::to_string(elements) + "/" + part; };
    const auto patch = [&](const char* part, auto body) {
      return benchmark::RegisterBenchmark(named(part).c_str(), body)->Unit(benchmark::kMillisecond);
    };
    patch("fp32", [=](benchmark::State& state) { patches<float>(state, elements); })->UseRealTime();
    patch("fp64", [=](benchmark::State& state) { patches<double>(state, elements); })->UseRealTime();
    for (const int threads : {1, 2})
      patch(("mix/fp32/threads:" + std::to_string(threads)).c_str(), [=](benchmark::State& state) {
        mixed<float>(state, elements, threads);
      })->UseRealTime();
    patch("eigen_fp64", [=](benchmark::State& state) { patch_twin(state, elements); });
  }
  add("contact/patch_12_sensors/fp32", [](benchmark::State& state) {
    patches_on_sensors(state, 65536);
  })->UseRealTime();
  for (const int sensors : {1, 16, 256, 4096, 65536})
    add(("scaling/sensors:" + std::to_string(sensors)).c_str(), [sensors](benchmark::State& state) {
      patches_on_sensors(state, static_cast<std::size_t>(sensors));
    })->UseRealTime();
  add("contact/patch_12/fp32/with_scenes", patches_with_scenes)->UseRealTime();
  add("contact/mesh_B/reference", [](benchmark::State& state) { reference(state, 'B'); });
  add("contact/mesh_A/reference", [](benchmark::State& state) { reference(state, 'A'); })->Iterations(2);
  return true;
}();

}  // namespace
