// SPDX-License-Identifier: Apache-2.0

// The roof that other figures are held against: FMA peak through PoCL with explicit vectors; and what a launch costs.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>

#include "bench/fma_peak.h"

namespace {

using namespace tactel;
using namespace tactel::host;
using tactel::bench::Peak;
using tactel::bench::peak_program;
using Clock = std::chrono::steady_clock;

const Device& device(const char* choice) {
  static std::map<std::string, Device> opened;
  const auto found = opened.find(choice);
  return found != opened.end() ? found->second : opened.emplace(choice, Device(choice)).first->second;
}

template <class Real>
void fma_peak(benchmark::State& state, int threads) {
  Peak<Real> peak(device("basic"), threads);
  if (!peak.right()) return state.SkipWithError("the accumulators did not converge to 1");
  std::vector<double> seconds;
  for (auto _ : state) seconds.push_back(peak.run());
  state.counters["GFLOP/s"] = 1e-9 * peak.flops / bench::median(seconds);
  state.counters["threads"] = threads;
  state.SetLabel(peak.executor.device().info().name);
}

/// Median and tails of one call, us, beside the mean that the benchmark itself reports.
template <class Call>
void latency(benchmark::State& state, const Call& call) {
  std::vector<double> us;
  for (auto _ : state) {
    const auto start = Clock::now();
    call();
    us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count());
  }
  std::ranges::sort(us);
  const auto quantile = [&](double part) {
    return us[static_cast<std::size_t>(part * static_cast<double>(us.size() - 1))];
  };
  state.counters["p50_us"] = quantile(0.5);
  state.counters["p99_us"] = quantile(0.99);
  state.counters["p99.9_us"] = quantile(0.999);
}

void launch_here(benchmark::State& state, const char* choice) {
  Peak<float> peak(device(choice), 1, 1, 1);
  latency(state, [&] { peak.executor.run_here(peak.launch); });
}

// Two groups of some 50 us of work each: what sharing it costs beyond half of it.
void launch_shared(benchmark::State& state, int threads) {
  Peak<float> peak(device("basic"), threads, 2, 1 << 14);
  if (!peak.right()) return state.SkipWithError("the accumulators did not converge to 1");
  latency(state, [&] { peak.executor.run(peak.launch, peak.groups); });
}

// A program that PoCL has in its cache, from its name to the first result.
void program_from_cache(benchmark::State& state) {
  const Device& basic = device("basic");
  Executor executor(basic);
  Buffer<float> out(basic, 16);
  for (auto _ : state)
    executor.run(peak_program(basic, Precision::fp32), "fma_peak", 1, [&](KernelArguments& kernel) {
      kernel.set(1, out);
      kernel.set(2, 1);
    });
}

const bool device_registered = [] {
  const auto add = [](const char* name, auto&& body) {
    return benchmark::RegisterBenchmark(name, body)->UseRealTime();
  };
  add("device/fma_peak/fp32/threads:1", [](benchmark::State& state) { fma_peak<float>(state, 1); });
  add("device/fma_peak/fp32/threads:2", [](benchmark::State& state) { fma_peak<float>(state, 2); });
  add("device/fma_peak/fp64/threads:1", [](benchmark::State& state) { fma_peak<double>(state, 1); });
  add("device/fma_peak/fp64/threads:2", [](benchmark::State& state) { fma_peak<double>(state, 2); });
  add("device/launch/basic", [](benchmark::State& state) { launch_here(state, "basic"); });
  add("device/launch/pthread", [](benchmark::State& state) { launch_here(state, "pthread"); });
  add("device/two_groups/threads:1", [](benchmark::State& state) { launch_shared(state, 1); });
  add("device/two_groups/threads:2", [](benchmark::State& state) { launch_shared(state, 2); });
  add("device/program_from_cache", program_from_cache)->Unit(benchmark::kMillisecond);
  return true;
}();

}  // namespace
