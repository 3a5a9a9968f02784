// SPDX-License-Identifier: Apache-2.0

// Load steps a second of contacts on pads: random scenes of nine kinds of indenters on one sensor, eight drags each,
// certificate, slip index and the stress under 4 x 4 tactels written out. Beside the multiply-add peak in the same
// turns.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "bench/fma_peak.h"
#include "fem/pad/pad_mix.h"
#include "host/contact/pads/pad_contact.h"
#include "host/contact/pads/pad_search.h"
#include "kernels/shared/contact_layout.h"
#include "kernels/shared/pad_layout.h"

namespace {

using namespace tactel;

using Batch = host::PadContact<float>::Batch;

/// Whether the kernel gives the twin's forces in some scenes.
bool right(const Batch& batch, const std::vector<fem::PadScene>& scenes, const fem::PadLayer& layer, int cells) {
  fem::PadOptions options;
  options.cells = cells;
  const fem::PadSolver twin(layer, options);
  for (std::size_t i = 0; i < scenes.size(); i += scenes.size() / 16) {
    const fem::PadStep found = batch.solution(i).steps.back(),
                       expected = twin.solve_on(batch.cells(i), batch.scene(i)).steps.back();
    if (!(std::abs(found.P - expected.P) + (found.Q - expected.Q).norm() <= 3e-3 * expected.P)) return false;
  }
  return true;
}

/// Multiplications and additions that the asked increments of these scenes need: nine products of each pair of cells
/// that touch in a sweep, and of each cell with them in the fresh sums. Those of increments between, of lanes that wait
/// and of windows wider than the contact do not count.
double useful_flops(const Batch& batch, const std::vector<fem::PadScene>& scenes, int cells) {
  double flops = 0;
  for (std::size_t i = 0; i < scenes.size(); ++i)
    for (int k = 0; k < 1 + static_cast<int>(scenes[i].load.drags.size()); ++k) {
      const double touch = batch.result(i, k, RESULT_STICKING) + batch.result(i, k, RESULT_SLIPPING);
      flops += 18 * touch * (touch * batch.result(i, k, RESULT_SWEEPS) + cells * cells);
    }
  return flops;
}

/// The kernels on a batch that lies ready, or end to end: from scenes to answers, tables and programs known before.
void pads(benchmark::State& state, int cells, int threads, bool end_to_end) {
  host::Executor executor{host::Device(), {.threads = threads}};
  const host::PadContact<float> contact(executor, {.cells = cells});
  const fem::PadSensor sensor;
  fem::PadMix mix(3, &sensor);
  std::vector<fem::PadScene> scenes(end_to_end ? 10000 : cells == 8 ? 8192 : 2048);
  for (fem::PadScene& scene : scenes) scene = mix();
  Batch batch = contact.prepare(scenes);
  batch.run();
  if (!right(batch, scenes, *contact.layer({sensor.poisson}), cells)) {
    state.SkipWithError("forces differ from the twin's");
    return;
  }
  double unsolved = 0, sweeps = 0;
  for (std::size_t i = 0; i < scenes.size(); ++i)
    for (int k = 0; k < 9; ++k) {
      unsolved += static_cast<int>(batch.result(i, k, RESULT_STATUS)) >= LANE_UNSOLVED;
      sweeps += batch.result(i, k, RESULT_SWEEPS);
    }
  bench::Peak<float> peak(executor.device(), threads);
  if (!peak.right()) {
    state.SkipWithError("the peak's sums are wrong");
    return;
  }
  std::vector<double> peaks, runs;
  for (auto _ : state) {
    const auto began = std::chrono::steady_clock::now();
    if (end_to_end) batch = contact.prepare(scenes);
    batch.run();
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
    state.PauseTiming();
    runs.push_back(end_to_end ? took.count() : batch.seconds());
    peaks.push_back(peak.flops / peak.run() * 1e-9);
    state.ResumeTiming();
  }
  const double steps = static_cast<double>(batch.steps_in_all()), seconds = bench::median(runs);
  const double gflops = 1e-9 * useful_flops(batch, scenes, cells) / seconds;
  state.counters["steps_per_second"] = steps / seconds;
  state.counters["useful_GFLOP/s"] = gflops;
  state.counters["peak_GFLOP/s"] = bench::median(peaks);
  state.counters["of_peak"] = gflops / bench::median(peaks);
  state.counters["filled"] = batch.filled();
  state.counters["sweeps"] = sweeps / steps;
  state.counters["unsolved"] = unsolved / steps;
  if (end_to_end) state.counters["kernel_part"] = batch.seconds() / runs.back();
  state.SetLabel(executor.device().info().name);
}

/// Contacts found on one thread, beside the twin's rate on some of them.
void pads_searched(benchmark::State& state) {
  host::Executor executor{host::Device(), {.threads = 1}};
  const host::PadSearch<float> search(executor);
  const fem::PadSensor sensor;
  const fem::PadLayer layer(sensor.poisson);
  fem::PadMix mix(3, &sensor);
  std::vector<fem::PadScene> scenes(8192);
  for (fem::PadScene& scene : scenes) scene = mix();
  const auto found = search.find(scenes);
  const auto began = std::chrono::steady_clock::now();
  constexpr std::size_t some = 256;
  for (std::size_t i = 0; i < some; ++i)
    if (!(std::abs(found[i].P / fem::find_pad_contact(scenes[i], layer).P - 1) <= 5e-3)) {
      state.SkipWithError("forces differ from the twin's");
      return;
    }
  const std::chrono::duration<double> twin = std::chrono::steady_clock::now() - began;
  for (auto _ : state) benchmark::DoNotOptimize(search.find(scenes));
  state.counters["scenes_per_second"] =
      benchmark::Counter(static_cast<double>(scenes.size()), benchmark::Counter::kIsIterationInvariantRate);
  state.counters["twin_scenes_per_second"] = some / twin.count();
}

/// What comes before the kernel for each scene: search, cells, tables of their own, layout.
void pads_prepared(benchmark::State& state, int cells) {
  host::Executor executor{host::Device(), {.threads = 1}};
  const host::PadContact<float> contact(executor, {.cells = cells});
  const fem::PadSensor sensor;
  fem::PadMix mix(3, &sensor);
  std::vector<fem::PadScene> scenes(4096);
  for (fem::PadScene& scene : scenes) scene = mix();
  contact.prepare(scenes);
  for (auto _ : state) benchmark::DoNotOptimize(contact.prepare(scenes));
  state.counters["scenes_per_second"] =
      benchmark::Counter(static_cast<double>(scenes.size()), benchmark::Counter::kIsIterationInvariantRate);
}

const bool pad_registered = [] {
  benchmark::RegisterBenchmark("contact/pad_search/fp32/threads:1", pads_searched)
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
  for (const int cells : {8, 12}) {
    const std::string name = fmt::format("contact/pad_{}", cells);
    for (const int threads : {1, 2}) {
      for (const bool end_to_end : {false, true})
        benchmark::RegisterBenchmark(
            fmt::format("{}{}/fp32/threads:{}", name, end_to_end ? "_end_to_end" : "", threads).c_str(),
            [=](benchmark::State& state) { pads(state, cells, threads, end_to_end); })
            ->Unit(benchmark::kMillisecond)
            ->UseRealTime();
    }
    benchmark::RegisterBenchmark((name + "/prepare").c_str(), [=](benchmark::State& state) {
      pads_prepared(state, cells);
    })->Unit(benchmark::kMillisecond);
  }
  return true;
}();

}  // namespace
