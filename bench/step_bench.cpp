// SPDX-License-Identifier: Apache-2.0

// Steps a second of contacts with one pad, by motion and by wrench: bowls of two radii over 8 x 8 cells that wander and
// slide. Beside the multiply-add peak in the same turns. And the latency of one and two contacts.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <vector>

#include "bench/fma_peak.h"
#include "bench/stepped_bowls.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_step.h"
#include "kernels/shared/pad_step_layout.h"

namespace {

using namespace tactel;
using Steps = host::PadStepper<float>;

constexpr int steps_a_way = 50;

double number(const Steps& steps, std::size_t contact, int row) {
  return static_cast<double>(steps.results()[contact * STEP_RESULT_ROWS + static_cast<std::size_t>(row)]);
}

/// Whether the kernel gives the twin's forces of the first contact on its way.
bool right(const bench::Bowls& bowls, host::Executor& executor) {
  Steps steps = bowls.steps(executor);
  fem::PadOptions options;
  options.cells = bowls.cells.n;
  fem::SteppedContact twin(fem::pad_layer(bowls.pad.poisson), bowls.pad, bowls.cells, bowls.friction[0], options);
  const Eigen::Map<const Eigen::ArrayXd> heights(bowls.heights.data(), bowls.cells.count());
  twin.set_surface({heights, Eigen::ArrayXd::Ones(heights.size())});
  for (int k = 0; k < 12; ++k) {
    const std::vector<double> pose = bowls.pose(k);
    steps.move(pose);
    const fem::SteppedState expected = twin.move(pose[0], {pose[1], pose[2], pose[3]});
    for (int row = 0; row < 4; ++row)
      if (!(std::abs(number(steps, 0, row) - expected.force[row]) <= 5e-3 * expected.force[0])) return false;
  }
  return true;
}

/// Multiplications and additions that the steps need: nine products of each pair of cells that touch in a sweep, and
/// once for the fresh sums. Those of lanes that wait, and of cells nearby, do not count.
double useful_flops(const Steps& steps) {
  double flops = 0;
  for (std::size_t c = 0; c < steps.count(); ++c) {
    const double touch = number(steps, c, STEP_RESULT_TOUCH);
    flops += 18 * touch * touch * (number(steps, c, STEP_RESULT_SWEEPS) + 1);
  }
  return flops;
}

void stepped(benchmark::State& state, std::size_t count, int threads, bool by_wrench) {
  host::Executor executor{host::Device(), {.threads = threads}};
  const bench::Bowls bowls(count, 1);
  if (!right(bowls, executor)) {
    state.SkipWithError("forces differ from the twin's");
    return;
  }
  Steps steps = bowls.steps(executor);
  std::vector<double> P(count);
  for (int k = 0; k < 4; ++k) steps.move(bowls.pose(k));
  for (std::size_t c = 0; c < count; ++c) P[c] = number(steps, c, STEP_RESULT_P);
  std::vector<std::vector<double>> way;
  way.reserve(steps_a_way);
  for (int k = 0; k < steps_a_way; ++k) way.push_back(by_wrench ? bowls.wrench(k, P, 0.8) : bowls.pose(k + 4));
  bench::Peak<float> peak(executor.device(), threads);
  if (!peak.right()) {
    state.SkipWithError("the peak's sums are wrong");
    return;
  }
  std::vector<double> peaks, runs;
  double sweeps = 0, solves = 0, unmet = 0, flops = 0;
  for (auto _ : state) {
    steps.reset();
    for (int k = 0; k < 4; ++k) steps.move(bowls.pose(k));
    sweeps = solves = unmet = flops = 0;
    double seconds = 0;
    for (const std::vector<double>& to : way) {
      const auto began = std::chrono::steady_clock::now();
      by_wrench ? steps.press(to) : steps.move(to);
      seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
      flops += useful_flops(steps);
      for (std::size_t c = 0; c < count; ++c) {
        sweeps += number(steps, c, STEP_RESULT_SWEEPS), solves += number(steps, c, STEP_RESULT_SOLVES);
        unmet += (static_cast<int>(number(steps, c, STEP_RESULT_FLAGS)) & STEP_UNMET) != 0;
      }
    }
    state.SetIterationTime(seconds);
    runs.push_back(seconds);
    peaks.push_back(peak.flops / peak.run() * 1e-9);
  }
  const double all = static_cast<double>(count) * steps_a_way, seconds = bench::median(runs);
  state.counters["steps_per_second"] = all / seconds;
  state.counters["us_a_launch"] = 1e6 * seconds / steps_a_way;
  state.counters["sweeps"] = sweeps / all;
  state.counters["solves"] = solves / all;
  state.counters["unmet"] = unmet / all;
  state.counters["MFLOP_a_step"] = 1e-6 * flops / all;
  state.counters["useful_GFLOP/s"] = 1e-9 * flops / seconds;
  state.counters["peak_GFLOP/s"] = bench::median(peaks);
  state.counters["of_peak"] = 1e-9 * flops / seconds / bench::median(peaks);
  state.SetLabel(executor.device().info().name);
}

/// One contact by the twin on the host, in fp64.
void twin_stepped(benchmark::State& state) {
  const bench::Bowls bowls(1, 1);
  fem::PadOptions options;
  options.cells = bowls.cells.n;
  const Eigen::Map<const Eigen::ArrayXd> heights(bowls.heights.data(), bowls.cells.count());
  const fem::PadLayer layer = fem::pad_layer(bowls.pad.poisson);
  for (auto _ : state) {
    fem::SteppedContact twin(layer, bowls.pad, bowls.cells, bowls.friction[0], options);
    twin.set_surface({heights, Eigen::ArrayXd::Ones(heights.size())});
    double seconds = 0;
    for (int k = 0; k < steps_a_way + 4; ++k) {
      const std::vector<double> pose = bowls.pose(k);
      const auto began = std::chrono::steady_clock::now();
      benchmark::DoNotOptimize(twin.move(pose[0], {pose[1], pose[2], pose[3]}));
      if (k >= 4) seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    }
    state.SetIterationTime(seconds);
    state.counters["us_a_step"] = 1e6 * seconds / steps_a_way;
  }
}

const bool step_registered = [] {
  benchmark::RegisterBenchmark("step/motion/twin", twin_stepped)->Unit(benchmark::kMillisecond)->UseManualTime();
  for (const bool by_wrench : {false, true})
    for (const std::size_t count : {1, 2, 16, 256, 4096})
      for (const int threads : {1, 2}) {
        if (threads == 2 && count < 256) continue;
        benchmark::RegisterBenchmark(
            fmt::format("step/{}/contacts:{}/threads:{}", by_wrench ? "wrench" : "motion", count, threads).c_str(),
            [=](benchmark::State& state) { stepped(state, count, threads, by_wrench); })
            ->Unit(benchmark::kMillisecond)
            ->UseManualTime();
      }
  return true;
}();

}  // namespace
