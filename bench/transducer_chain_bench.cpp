// SPDX-License-Identifier: Apache-2.0

// Load steps a second of the transducer chain, copies in and out included; what the parts cost.
#include <benchmark/benchmark.h>

#include "tests/host/sets/transducer_cases.h"

namespace {

using namespace tactel;

void chain(benchmark::State& state, const nn::Transducer& transducer, int channels) {
  const tactel::tests::TransducerCase some(8192, channels);
  std::vector<float> signal = some.stress;
  host::TransducerChain chain(tactel::tests::executor(), transducer, 11, channels);
  chain.run(some.contacts, signal);
  if (!(tactel::tests::largest_difference(signal, some.by_twin(transducer, channels)) < 3e-6))
    return state.SkipWithError("readings differ from the twin");
  tactel::tests::executor().clear_times();
  double seconds = 0;
  for (auto _ : state) {
    signal = some.stress;
    chain.run(some.contacts, signal);
  }
  for (const auto& [name, time] : tactel::tests::executor().times()) seconds += time.seconds;
  const double steps = static_cast<double>(signal.size()) / channels * static_cast<double>(state.iterations());
  state.counters["steps_per_second"] = benchmark::Counter(steps, benchmark::Counter::kIsRate);
  state.counters["in_kernel_steps_per_core_second"] = steps / seconds;
  state.SetLabel(tactel::tests::executor().device().info().name);
}

const bool transducer_chain_registered = [] {
  for (const int channels : {16, 42}) {
    const auto add = [&](const char* part, const nn::Transducer& transducer) {
      const std::string name = std::string("transducer_chain/") + part + "/" + std::to_string(channels);
      benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& s) {
        chain(s, transducer, channels);
      })->UseRealTime();
    };
    add("gain", {.gain_spread = 0.1});
    add("high_pass", {.time_constant = 1, .step_time = 0.05});
    add("noise", {.noise = 0.03});
    add("all_parts", tactel::tests::all_parts);
    add("skin_parts", tactel::tests::skin_parts);
  }
  return true;
}();

}  // namespace
