// SPDX-License-Identifier: Apache-2.0

// Frames a second and the time of a single frame: the forward kernels beside the same network written by hand in Eigen,
// fp32, on the same threads.
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <tactel/infer.h>

#include <chrono>

#include "host/networks/forward.h"
#include "host/networks/onnx_file.h"
#include "network_peers.h"
#include "nn/infer/network_file.h"
#include "nn/metrics.h"
#include "tests/host/networks/network_cases.h"

namespace {

using namespace tactel;

const nn::InputScaling scaling{nn::ScalingKind::set, 1.3f};

struct Case {
  nn::Topology topology;
  nn::Weights<float> weights = nn::initial_weights(topology, 1);
  nn::RowMatrix<float> frames;
  Case(int network, int batch) : topology(nn::Topology::paper(network)) {
    // With a sensor's noise: tails of bumps would be denormal numbers, at which the peers would crawl.
    const nn::RowMatrix<float> some = nn::with_noise(tactel::tests::bumps(1024, topology.inputs(), 5), 1e-3, 1).frames;
    frames = some.replicate((batch + 1023) / 1024, 1).topRows(batch);
  }
  double flops() const { return 2.0 * static_cast<double>(weights.values.size()) * static_cast<double>(frames.rows()); }
  bool right(const nn::Vector<float>& s) const {
    const Eigen::Index rows = std::min<Eigen::Index>(s.size(), 200);
    const nn::Recall<double> truth = nn::recall(nn::Weights<double>(weights), scaling, frames.topRows(rows));
    return (s.head(rows).cast<double>() - truth.slip_index).cwiseAbs().maxCoeff() < 1e-6;
  }
};

void count(benchmark::State& state, const Case& c, int threads) {
  const auto rate = benchmark::Counter::kIsIterationInvariantRate;
  state.counters["frames_per_second"] = benchmark::Counter(static_cast<double>(c.frames.rows()), rate);
  state.counters["GFLOP/s"] = benchmark::Counter(1e-9 * c.flops(), rate);
  state.counters["threads"] = threads;
}

void kernel(benchmark::State& state, int network, int threads) {
  const Case c(network, static_cast<int>(state.range(0)));
  host::Executor executor(tactel::tests::executor().device(), {.threads = threads});
  host::Forward<float> forward(executor, std::span(&c.weights, 1), scaling);
  const host::DeviceFrames frames(executor.device(), c.frames);
  forward.run(frames);
  if (!c.right(forward.result(0).slip_index)) return state.SkipWithError("S differs from the reference");
  for (auto _ : state) forward.run(frames);
  count(state, c, executor.threads());
  state.SetLabel(executor.device().info().name);
}

// Blocks of 256 frames, as fits the first-level cache; the blocks are shared out among the threads.
void eigen(benchmark::State& state, int network, int threads) {
  const Case c(network, static_cast<int>(state.range(0)));
  constexpr int block = 256;
  const int rows = static_cast<int>(c.frames.rows()), blocks = (rows + block - 1) / block;
  nn::Vector<float> s(rows);
  const bench::EigenNetwork prototype(c.weights);
  std::vector<bench::EigenNetwork> networks(blocks < threads ? 1 : threads, prototype);
  const auto one_block = [&](bench::EigenNetwork& own, int b) {
    const int count = std::min(block, rows - b * block);
    own.forward(c.frames.middleRows(b * block, count).transpose() * (1.0f / scaling.largest_stress));
    s.segment(b * block, count) = own.o.back().row(0).transpose().array() + 0.5f;
  };
  const auto all = [&] {
    if (networks.size() == 1) {
      for (int b = 0; b < blocks; ++b) one_block(networks[0], b);
    } else {
      bench::on_threads(threads, threads, [&](int thread) {
        for (int b = thread; b < blocks; b += threads) one_block(networks[thread], b);
      });
    }
  };
  all();
  if (!c.right(s)) return state.SkipWithError("S differs from the reference");
  for (auto _ : state) all();
  count(state, c, threads);
}

// The same network through tactel::infer, in the calling thread.
void infer(benchmark::State& state, int network) {
  const Case c(network, static_cast<int>(state.range(0)));
  const std::string bytes = infer::network_bytes({c.weights, scaling, 1, 0, "bumps", 0, {}});
  const SlipEstimator estimator = SlipEstimator::parse(std::as_bytes(std::span(bytes)));
  const std::span frames(c.frames.data(), static_cast<std::size_t>(c.frames.size()));
  std::vector<Answer> answers(static_cast<std::size_t>(c.frames.rows()));
  estimator.estimate(frames, answers);
  nn::Vector<float> s(c.frames.rows());
  for (Eigen::Index row = 0; row < s.size(); ++row) s(row) = answers[static_cast<std::size_t>(row)].slip_index;
  if (!c.right(s)) return state.SkipWithError("S differs from the reference");
  for (auto _ : state) benchmark::DoNotOptimize(estimator.estimate(frames, answers));
  count(state, c, 1);
}

// Latency of single calls: quantiles over some ten thousand, copies and status included.
template <class Call>
void latency(benchmark::State& state, const Case& c, const Call& call) {
  std::vector<double> microseconds;
  std::size_t row = 0;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(call(c.frames.row(row++ % c.frames.rows()).data()));
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    state.SetIterationTime(seconds);
    microseconds.push_back(1e6 * seconds);
  }
  state.counters["p50_us"] = nn::quantile(microseconds, 0.5);
  state.counters["p99_us"] = nn::quantile(microseconds, 0.99);
  state.counters["p99.9_us"] = nn::quantile(microseconds, 0.999);
}

// One frame through tactel::infer, as tactel monitor takes it.
void one_frame_infer(benchmark::State& state, int network) {
  const Case c(network, 1024);
  const std::string bytes = infer::network_bytes({c.weights, scaling, 1, 0, "bumps", 0, {}});
  const SlipEstimator estimator = SlipEstimator::parse(std::as_bytes(std::span(bytes)));
  const auto inputs = static_cast<std::size_t>(c.topology.inputs());
  nn::Vector<float> s(200);
  for (int row = 0; row < 200; ++row)
    s(row) = estimator.estimate(std::span(c.frames.row(row).data(), inputs)).slip_index;
  if (!c.right(s)) return state.SkipWithError("S differs from the reference");
  latency(state, c, [&](const float* frame) { return estimator.estimate(std::span(frame, inputs)).slip_index; });
}

void one_frame_eigen(benchmark::State& state, int network) {
  const Case c(network, 1024);
  bench::EigenOnline own(c.weights);
  const auto answer = [&](const float* frame) {
    auto& o = own.o;
    o[0] = Eigen::Map<const Eigen::VectorXf>(frame, c.topology.inputs()) * (1.0f / scaling.largest_stress);
    for (std::size_t l = 0; l < own.network.w.size(); ++l) {
      o[l + 1] = own.network.b[l];
      o[l + 1].noalias() += own.network.w[l] * o[l];
      o[l + 1] = bench::activation(o[l + 1]);
    }
    return o.back()(0) + 0.5f;
  };
  nn::Vector<float> s(200);
  for (int row = 0; row < 200; ++row) s(row) = answer(c.frames.row(row).data());
  if (!c.right(s)) return state.SkipWithError("S differs from the reference");
  latency(state, c, answer);
}

const bool forward_registered = [] {
  const int all = tactel::tests::executor().threads();
  for (const int network : {1, 5, 6}) {
    const std::string name = "forward/" + nn::Topology::paper(network).text();
    for (const int threads : all > 1 ? std::vector<int>{1, all} : std::vector<int>{1}) {
      const auto line = [&](const char* what) { return fmt::format("{}/{}/threads:{}", name, what, threads); };
      benchmark::RegisterBenchmark(line("kernel").c_str(), [=](benchmark::State& s) { kernel(s, network, threads); })
          ->Arg(1)
          ->Arg(8)
          ->Arg(16)
          ->Arg(64)
          ->Arg(4096)
          ->Arg(262144)
          ->UseRealTime()
          ->Unit(benchmark::kMicrosecond);
      benchmark::RegisterBenchmark(line("eigen").c_str(), [=](benchmark::State& s) { eigen(s, network, threads); })
          ->Arg(1)
          ->Arg(8)
          ->Arg(16)
          ->Arg(64)
          ->Arg(4096)
          ->Arg(262144)
          ->UseRealTime()
          ->Unit(benchmark::kMicrosecond);
    }
    benchmark::RegisterBenchmark((name + "/infer").c_str(), [=](benchmark::State& s) { infer(s, network); })
        ->Arg(1)
        ->Arg(8)
        ->Arg(16)
        ->Arg(64)
        ->Arg(4096)
        ->UseRealTime()
        ->Unit(benchmark::kMicrosecond);
    benchmark::RegisterBenchmark((name + "/one_frame_infer").c_str(),
                                 [=](benchmark::State& s) { one_frame_infer(s, network); })
        ->UseManualTime()
        ->Unit(benchmark::kMicrosecond);
    benchmark::RegisterBenchmark((name + "/one_frame_eigen").c_str(),
                                 [=](benchmark::State& s) { one_frame_eigen(s, network); })
        ->UseManualTime()
        ->Unit(benchmark::kMicrosecond);
  }
  return true;
}();

}  // namespace
