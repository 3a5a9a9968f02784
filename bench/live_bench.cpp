// SPDX-License-Identifier: Apache-2.0

// Live frames of the pads of a hand: all pads by one launch of kernels/forward.cl, and by tactel::infer in the calling
// thread, with and without a bound.
#include <benchmark/benchmark.h>

#include <cmath>

#include "host/live/live_estimator.h"
#include "tests/host/networks/bounded_model.h"

namespace {

using namespace tactel;
using tactel::tests::bounded_model;

nn::Model model_of(bool bound) {
  if (bound) return bounded_model("42-21-3", nn::ScalingKind::frame);
  return {nn::initial_weights(nn::Topology::parse("42-21-1"), 7), {nn::ScalingKind::frame, 1}, 7, 0, "bumps", 1, {}};
}

bool same(float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }

void live(benchmark::State& state, bool on_device, bool bound) {
  const auto pads = static_cast<std::size_t>(state.range(0));
  const nn::Model model = model_of(bound);
  const std::vector<const nn::Model*> models(pads, &model);
  const auto host = host::host_estimator(models),
             kernel = host::device_estimator(tactel::tests::executor().device(), models);
  // Some frames in turn, with a sensor's noise.
  constexpr std::size_t turns = 16;
  const nn::RowMatrix<float> rows =
      nn::with_noise(tactel::tests::bumps(static_cast<int>(turns * pads), 42, 5), 1e-3, 1).frames;
  const auto frame = [&](std::size_t turn) {
    return std::span<const float>(rows.data() + turn % turns * pads * 42, pads * 42);
  };
  std::vector<Answer> answers(pads), expected(pads);
  for (std::size_t turn = 0; turn < turns; ++turn) {
    kernel->estimate(frame(turn), answers);
    host->estimate(frame(turn), expected);
    for (std::size_t i = 0; i < pads; ++i)
      if (!same(answers[i].slip_index, expected[i].slip_index) || !same(answers[i].slip_upper, expected[i].slip_upper))
        return state.SkipWithError("the device's answers differ from the host's");
  }
  const auto& measured = on_device ? kernel : host;
  std::size_t turn = 0;
  for (auto _ : state) measured->estimate(frame(turn++), answers);
  state.counters["answers_per_second"] =
      benchmark::Counter(static_cast<double>(pads), benchmark::Counter::kIsIterationInvariantRate);
  if (on_device) state.SetLabel(tactel::tests::executor().device().info().name);
}

BENCHMARK_CAPTURE(live, kernel, true, false)->Arg(1)->Arg(2)->Arg(16)->Arg(64);
BENCHMARK_CAPTURE(live, host, false, false)->Arg(1)->Arg(2)->Arg(16)->Arg(64);
BENCHMARK_CAPTURE(live, kernel_bound, true, true)->Arg(1)->Arg(2)->Arg(16)->Arg(64);
BENCHMARK_CAPTURE(live, host_bound, false, true)->Arg(1)->Arg(2)->Arg(16)->Arg(64);

}  // namespace
