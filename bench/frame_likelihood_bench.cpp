// SPDX-License-Identifier: Apache-2.0

// Densities a second of readings under the rows of a bank, beside the multiply-add peak of the same run.
#include <benchmark/benchmark.h>

#include <cmath>

#include "host/networks/frame_likelihood.h"
#include "tests/host/networks/network_cases.h"

namespace {

using namespace tactel;

void kernel(benchmark::State& state, int history) {
  const nn::ReadingModel model{.inputs = 42, .history = history, .noise = 0.01, .gain = 0.1};
  const nn::RowMatrix<float> bank = testing::bumps(50'000, model.size(), 4).frames.array() + 0.01f;
  const nn::RowMatrix<float> readings = nn::draw_readings(model, bank.topRows(64), 3);
  host::FrameLikelihood<float> likelihood(testing::executor(), model, bank);
  const nn::RowMatrix<float> answer = likelihood(readings);
  const auto size = static_cast<std::size_t>(model.size());
  for (Eigen::Index k = 0; k < 64; ++k) {
    const double twin = nn::log_likelihood(model, {bank.row(7 * k).data(), size}, {readings.row(k).data(), size});
    if (!(std::abs(answer(k, 7 * k) - twin) <= 1e-5 * std::abs(twin) + 1e-3))
      return state.SkipWithError("a density differs from the reference");
  }
  for (auto _ : state) benchmark::DoNotOptimize(likelihood(readings).data());
  const auto rate = benchmark::Counter::kIsIterationInvariantRate;
  const double densities = 64.0 * 50'000;
  state.counters["densities_per_second"] = benchmark::Counter(densities, rate);
  // A number of a frame takes a difference and a multiply-add for r.f, then a difference and two multiply-adds.
  state.counters["GFLOP/s"] = benchmark::Counter(1e-9 * 8 * densities * model.size(), rate);
  state.SetLabel(testing::executor().device().info().name);
}

BENCHMARK_CAPTURE(kernel, likelihood / 1_frame / fp32, 1)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(kernel, likelihood / 4_frames / fp32, 4)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
