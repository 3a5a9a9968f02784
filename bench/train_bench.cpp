// SPDX-License-Identifier: Apache-2.0

// Patterns a second and time to a given error: the training kernels beside the same rules written by hand in Eigen,
// fp32, and beside FANN for pattern-by-pattern training; same set, same threads.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <memory>

#include "host/networks/network_training.h"
#include "host/networks/train_batch.h"
#include "network_peers.h"
#include "tests/host/networks/network_cases.h"

namespace {

using namespace tactel;
using host::OnlineMember;

constexpr int rows = 700;  ///< patterns in the set
constexpr float rate = 0.1f, momentum = 0.9f;

const nn::FrameSet& set() {
  // A sensor's noise keeps the tails of bumps from becoming denormal numbers, at which the peers would crawl.
  static const nn::FrameSet set = nn::with_noise(tactel::tests::bumps(rows, 42, 3), 1e-3, 1);
  return set;
}
const nn::InputScaling& scaling() {
  static const nn::InputScaling scaling = nn::fit_scaling(nn::ScalingKind::set, set());
  return scaling;
}
const nn::TrainingSet<float>& shown() {
  static const nn::TrainingSet<float> shown = nn::training_set<float>(set(), scaling());
  return shown;
}
const host::LearningInputs<float>& inputs() {
  static const std::vector<host::SetVariant> clean{{}};
  static const host::LearningInputs<float> inputs(tactel::tests::executor().device(), set(), scaling(), clean);
  return inputs;
}

/// Operations of the rule: forward 2, backward 2 (not below the first layer), step and weight 4 operations a weight.
double flops_of_pattern(const nn::Topology& topology) {
  const auto all = static_cast<double>(topology.weight_count()), first = static_cast<double>(topology.layer_offset(1));
  return 6 * all + 2 * (all - first);
}

void count(benchmark::State& state, double patterns, double flops, int threads) {
  const auto each = benchmark::Counter::kIsIterationInvariantRate;
  state.counters["patterns_per_second"] = benchmark::Counter(patterns, each);
  state.counters["GFLOP/s"] = benchmark::Counter(1e-9 * flops, each);
  state.counters["threads"] = threads;
}

// Largest difference of the weights to the reference after two cycles; fp32 leaves some 1e-6.
bool learns_like_reference(host::TrainOnline<float>& training, std::uint64_t seed) {
  training.run(2);
  nn::OnlineState<double> reference(nn::initial_weights(training.topology(), seed));
  nn::train_online(reference, nn::training_set<double>(set(), scaling()), {.stop_error = 0}, seed, 2);
  return tactel::tests::largest_difference(training.state(0).weights.values, reference.weights.values) < 1e-4;
}

// The six networks with `seeds` seeds each, in one pool.
void online_sweep(benchmark::State& state, int threads, int seeds) {
  constexpr int cycles = 4;  // a launch, as trainings of this size have it between looks at the clock
  host::Executor executor(tactel::tests::executor().device(), {.threads = threads});
  std::vector<OnlineMember> members;
  for (int seed = 0; seed < seeds; ++seed) members.push_back({static_cast<std::uint64_t>(seed), 0});
  std::vector<host::TrainOnline<float>> trainings;
  double flops = 0;
  for (const int network : {5, 2, 4, 6, 1, 3}) {  // longest first
    trainings.emplace_back(executor, nn::Topology::paper(network), inputs(), members,
                           nn::OnlineOptions{.stop_error = 0, .cycle_limit = 1 << 30});
    if (!learns_like_reference(trainings.back(), 0)) return state.SkipWithError("weights differ from the reference");
    flops += flops_of_pattern(nn::Topology::paper(network)) * rows * seeds;
  }
  std::vector<host::Job> jobs;
  for (auto& training : trainings) jobs.push_back(training.job(cycles));
  for (auto _ : state) executor.run(jobs, {.progress = {}, .largest_chunk = 1});
  count(state, 6.0 * rows * seeds * cycles, flops * cycles, executor.threads());
  state.SetLabel(executor.device().info().name);
}

// The same of the Eigen peer after one cycle, by its output neuron.
bool eigen_learns_like_reference(const nn::Topology& topology) {
  bench::EigenOnline own(nn::initial_weights(topology, 1));
  for (const std::uint32_t row : nn::presentation_order(nn::PresentationOrder::permuted, 1, 0, rows))
    own.learn(shown().inputs.row(row).transpose(), shown().target(row), rate, momentum);
  nn::OnlineState<double> reference(nn::initial_weights(topology, 1));
  nn::train_online(reference, nn::training_set<double>(set(), scaling()), {.stop_error = 0}, 1, 1);
  const auto last = reference.weights.layer(topology.layers() - 1);
  const int in = topology.fan_in(topology.layers() - 1);
  return (own.network.w.back().cast<double>() - last.leftCols(in)).cwiseAbs().maxCoeff() < 1e-4;
}

template <class Make>
void online_peer(benchmark::State& state, int threads, const Make& make_learner) {
  const std::vector<std::uint32_t> order = nn::presentation_order(nn::PresentationOrder::permuted, 1, 0, rows);
  double flops = 0;
  using Learner = decltype(make_learner(nn::Topology::paper(1)));
  std::vector<Learner> learners;
  const std::vector<int> networks{5, 5, 2, 2, 4, 4, 6, 6, 1, 1, 3, 3};  // two seeds of each, longest first
  for (const int network : networks) {
    if (!eigen_learns_like_reference(nn::Topology::paper(network)))
      return state.SkipWithError("weights differ from the reference");
    learners.push_back(make_learner(nn::Topology::paper(network)));
    flops += flops_of_pattern(nn::Topology::paper(network)) * rows;
  }
  for (auto _ : state)
    bench::on_threads(threads, static_cast<int>(learners.size()), [&](int i) {
      for (const std::uint32_t row : order) (*learners[i])(shown().inputs.row(row).data(), shown().target(row));
    });
  count(state, static_cast<double>(rows * networks.size()), flops, threads);
}

using LearnOne = std::function<void(const float*, float)>;

std::unique_ptr<LearnOne> eigen_learner(const nn::Topology& topology) {
  auto own = std::make_shared<bench::EigenOnline>(nn::initial_weights(topology, 1));
  return std::make_unique<LearnOne>([own, n = topology.inputs()](const float* x, float target) {
    own->learn(Eigen::Map<const Eigen::VectorXf>(x, n), target, rate, momentum);
  });
}

#ifdef TACTEL_FANN
std::unique_ptr<LearnOne> fann_learner(const nn::Topology& topology) {
  auto own = std::make_shared<bench::FannOnline>(topology);
  return std::make_unique<LearnOne>([own](const float* x, float target) { own->learn(x, target); });
}
#endif

// Networks of one topology on one thread.
void online_one(benchmark::State& state, int network, int seeds) {
  host::Executor executor(tactel::tests::executor().device(), {.threads = 1});
  const nn::Topology topology = nn::Topology::paper(network);
  std::vector<OnlineMember> members;
  for (int seed = 0; seed < seeds; ++seed) members.push_back({static_cast<std::uint64_t>(seed), 0});
  host::TrainOnline<float> training(executor, topology, inputs(), members, {.stop_error = 0, .cycle_limit = 1 << 30});
  if (!learns_like_reference(training, 0)) return state.SkipWithError("weights differ from the reference");
  const host::Job job = training.job(10);
  for (auto _ : state) executor.run(std::span(&job, 1));
  count(state, 10.0 * rows * seeds, 10 * rows * seeds * flops_of_pattern(topology), 1);
}

template <class Make>
void online_one_peer(benchmark::State& state, int network, const Make& make_learner) {
  const nn::Topology topology = nn::Topology::paper(network);
  const auto learner = make_learner(topology);
  for (auto _ : state)
    for (int row = 0; row < rows; ++row) (*learner)(shown().inputs.row(row).data(), shown().target(row));
  count(state, rows, rows * flops_of_pattern(topology), 1);
}

void batches(benchmark::State& state, int network, nn::BatchRule rule, int threads) {
  host::Executor executor(tactel::tests::executor().device(), {.threads = threads});
  const nn::Topology topology = nn::Topology::paper(network);
  // Batches of up to a slice keep one thread busy for each network, so there are as many networks as threads.
  const int networks = state.range(0) <= host::TrainBatch<float>::slice ? threads : 1;
  std::vector<OnlineMember> members;
  for (int i = 0; i < networks; ++i) members.push_back({static_cast<std::uint64_t>(i), 0});
  const nn::BatchOptions options{.rule = rule, .batch = static_cast<int>(state.range(0)), .rate = 1e-3};
  host::TrainBatch<float> training(executor, topology, inputs(), members, options);
  training.train_epoch();
  nn::BatchState<double> reference(nn::initial_weights(topology, 0));
  nn::train_epoch(reference, nn::training_set<double>(set(), scaling()), options, 0);
  if (!(tactel::tests::largest_difference(training.state(0).weights.values, reference.weights.values) < 1e-3))
    return state.SkipWithError("weights differ from the reference");
  for (auto _ : state) training.train_epoch();
  count(state, double(rows) * networks, rows * networks * flops_of_pattern(topology), threads);
}

void batches_eigen(benchmark::State& state, int network, int threads) {
  const int batch = static_cast<int>(state.range(0));
  const nn::Topology topology = nn::Topology::paper(network);
  std::vector<bench::EigenNetwork> networks(threads, bench::EigenNetwork(nn::initial_weights(topology, 0)));
  const Eigen::MatrixXf x = shown().inputs.transpose();
  for (auto _ : state)
    bench::on_threads(threads, threads, [&](int i) {
      for (int begin = 0; begin < rows; begin += batch) {
        const int count = std::min(batch, rows - begin);
        networks[i].forward(x.middleCols(begin, count));
        const Eigen::RowVectorXf error = shown().target.segment(begin, count).transpose() - networks[i].o.back();
        networks[i].backward(error / static_cast<float>(count));
        networks[i].update(rate, momentum);
      }
    });
  count(state, double(rows) * threads, rows * threads * flops_of_pattern(topology), threads);
}

constexpr double wanted_sse = 0.5;  ///< over the 700 patterns: a root mean square error of 0.027

// Seconds of learning until a cycle's sum of squared errors falls below wanted_sse; learn_cycle returns it.
template <class LearnCycle>
void time_to_error(benchmark::State& state, const LearnCycle& learn_cycle, int most_cycles) {
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    int cycles = 0;
    double sse = INFINITY;
    while (sse > wanted_sse && cycles < most_cycles) sse = learn_cycle(cycles++);
    state.SetIterationTime(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    state.counters["cycles"] = cycles;
    state.counters["sse"] = sse;
    if (sse > wanted_sse) state.SetLabel("not reached");
  }
}

void to_error_online(benchmark::State& state) {
  host::Executor executor(tactel::tests::executor().device(), {.threads = 1});
  const std::vector<OnlineMember> members{{1, 0}};
  host::TrainOnline<float> training(executor, nn::Topology::paper(6), inputs(), members, {.stop_error = 0});
  time_to_error(
      state, [&](int) { return training.run(1), training.report(0).sse; }, 5000);
}

void to_error_eigen(benchmark::State& state) {
  bench::EigenOnline own(nn::initial_weights(nn::Topology::paper(6), 1));
  const auto cycle = [&](int c) {
    own.sse = 0;
    for (const std::uint32_t row : nn::presentation_order(nn::PresentationOrder::permuted, 1, c, rows))
      own.learn(shown().inputs.row(row).transpose(), shown().target(row), rate, momentum);
    return own.sse;
  };
  time_to_error(state, cycle, 5000);
}

void to_error_batch(benchmark::State& state, const nn::BatchOptions& options) {
  host::Executor executor(tactel::tests::executor().device(), {.threads = 1});
  const std::vector<OnlineMember> members{{1, 0}};
  host::TrainBatch<float> training(executor, nn::Topology::paper(6), inputs(), members, options);
  time_to_error(
      state, [&](int) { return training.train_epoch()->at(0).sse; }, 20000);
}

const bool train_registered = [] {
  const auto add = [](const std::string& name, auto body) {
    return benchmark::RegisterBenchmark(name.c_str(), body)->Unit(benchmark::kMillisecond);
  };
  const int all = tactel::tests::executor().threads();
  add("train/online/6x100/kernel", [=](benchmark::State& s) { online_sweep(s, all, 100); })->UseRealTime();
  add("train/online/6x1/kernel/threads:1", [](benchmark::State& s) { online_sweep(s, 1, 1); })->UseRealTime();
  add("train/online/6x2/eigen", [=](benchmark::State& s) { online_peer(s, all, eigen_learner); })->UseRealTime();
  add("train/online/6x2/eigen/threads:1", [](benchmark::State& s) { online_peer(s, 1, eigen_learner); })->UseRealTime();
#ifdef TACTEL_FANN
  add("train/online/6x2/fann", [=](benchmark::State& s) { online_peer(s, all, fann_learner); })->UseRealTime();
  add("train/online/6x2/fann/threads:1", [](benchmark::State& s) { online_peer(s, 1, fann_learner); })->UseRealTime();
#endif
  for (const int network : {1, 2, 3, 4, 5, 6}) {
    const std::string name = "train/online/" + nn::Topology::paper(network).text();
    add(name + "/kernel/seeds:1", [=](benchmark::State& s) { online_one(s, network, 1); });
    add(name + "/kernel/seeds:16", [=](benchmark::State& s) { online_one(s, network, 16); });
    add(name + "/eigen", [=](benchmark::State& s) { online_one_peer(s, network, eigen_learner); });
#ifdef TACTEL_FANN
    add(name + "/fann", [=](benchmark::State& s) { online_one_peer(s, network, fann_learner); });
#endif
  }
  for (const int threads : all > 1 ? std::vector<int>{1, all} : std::vector<int>{1}) {
    const std::string name = "train/batch/42-42-21-1", suffix = "/threads:" + std::to_string(threads);
    add(name + "/delta" + suffix, [=](benchmark::State& s) { batches(s, 6, nn::BatchRule::delta, threads); })
        ->Arg(8)
        ->Arg(64)
        ->Arg(rows)
        ->UseRealTime();
    add(name + "/adam" + suffix, [=](benchmark::State& s) { batches(s, 6, nn::BatchRule::adam, threads); })
        ->Arg(8)
        ->Arg(64)
        ->Arg(rows)
        ->UseRealTime();
    add(name + "/eigen_delta" + suffix, [=](benchmark::State& s) { batches_eigen(s, 6, threads); })
        ->Arg(8)
        ->Arg(64)
        ->Arg(rows)
        ->UseRealTime();
  }
  add("train/to_sse/online/kernel", to_error_online)->UseManualTime()->Iterations(1);
  add("train/to_sse/online/eigen", to_error_eigen)->UseManualTime()->Iterations(1);
  for (const int batch : {8, 64}) {
    const std::string size = std::to_string(batch);
    add("train/to_sse/batch:" + size + "/delta",
        [=](benchmark::State& s) {
          to_error_batch(s, {.rule = nn::BatchRule::delta, .batch = batch, .rate = 0.1 * batch});
        })
        ->UseManualTime()
        ->Iterations(1);
    add("train/to_sse/batch:" + size + "/adam",
        [=](benchmark::State& s) { to_error_batch(s, {.rule = nn::BatchRule::adam, .batch = batch, .rate = 2e-3}); })
        ->UseManualTime()
        ->Iterations(1);
  }
  return true;
}();

}  // namespace
