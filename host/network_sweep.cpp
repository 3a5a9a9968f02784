#include "host/network_sweep.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "fem/value_error.h"
#include "host/checksum.h"
#include "host/forward.h"
#include "host/sweep_checkpoint.h"

namespace tactel::host {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double round_seconds = 0.5;          ///< aimed at: progress, checkpoints and Ctrl-C wait for a round
constexpr std::uint32_t longest_round = 1024;  ///< cycles; the kernel's curve buffer holds a round

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Cycles that a learning curve keeps: the first ten, then a tenth apart.
std::uint32_t next_point(std::uint32_t cycle) { return cycle < 10 ? cycle + 1 : cycle + cycle / 10; }

void note_cycle(LearningCurve& curve, std::uint32_t cycle, const nn::CycleErrors& errors) {
  curve.cycle.push_back(cycle);
  curve.sse.push_back(static_cast<float>(errors.sse));
  curve.largest.push_back(static_cast<float>(errors.largest));
}

std::string exact(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%a", number);
  return text;
}

std::uint64_t set_hash(const nn::FrameSet& set) {
  const auto bytes = [](const float* data, Eigen::Index count) {
    return std::string_view(reinterpret_cast<const char*>(data), static_cast<std::size_t>(count) * sizeof(float));
  };
  return checksum(bytes(set.frames.data(), set.frames.size())) ^
         (checksum(bytes(set.slip_index.data(), set.slip_index.size())) << 1);
}

/// All that a sweep's bits depend on.
template <class Real>
std::string describe(const SweepPlan& plan, const nn::FrameSet& set, int lanes) {
  std::string text = "precision " + std::to_string(sizeof(Real)) + " lanes " + std::to_string(lanes) + " scaling " +
                     nn::name(plan.scaling) + " set " + std::to_string(set.rows()) + " " +
                     std::to_string(set_hash(set)) + " networks";
  for (const nn::Topology& topology : plan.topologies) text += ' ' + topology.text();
  text += " seeds";
  for (const std::uint64_t seed : plan.seeds) text += ' ' + std::to_string(seed);
  text += " noises";
  for (const double noise : plan.noises) text += ' ' + exact(noise);
  const nn::OnlineOptions& options = plan.options;
  return text + " rate " + exact(options.rate) + " momentum " + exact(options.momentum) + " stop " +
         exact(options.stop_error) + " limit " + std::to_string(options.cycle_limit) + ' ' + nn::name(options.order);
}

}  // namespace

void SweepPlan::validate() const {
  if (topologies.empty()) throw ValueError("network", "none", "at least one network");
  if (seeds.empty()) throw ValueError("seeds", "none", "at least one seed");
  if (noises.empty()) throw ValueError("noise", "none", "at least one level, 0 for none");
  for (const double noise : noises)
    if (!(noise >= 0) || !std::isfinite(noise))
      throw ValueError("noise", std::to_string(noise), "finite and at least 0");
  options.validate();
}

template <class Real>
struct NetworkSweep<Real>::State {
  Executor& executor;
  SweepPlan plan;
  nn::FrameSet set;
  nn::InputScaling scaling;
  std::vector<SweepNetwork> networks;        ///< [topologies][noises][seeds]
  std::vector<TrainOnline<Real>> trainings;  ///< [topologies]
  std::uint32_t round_cycles = 4;
  double patterns = 0, seconds = 0;

  State(Executor& executor, const nn::FrameSet& set, const SweepPlan& plan);
  std::size_t per_topology() const { return plan.noises.size() * plan.seeds.size(); }
  TrainOnline<Real>& training_of(std::size_t network) { return trainings[network / per_topology()]; }
  std::size_t place(std::size_t network) const { return network % per_topology(); }
  bool running() const;
  std::size_t work_done() const;
  std::size_t work_of_all() const;
  bool run_round(const SweepRunOptions& options);
  void collect(std::size_t network);
  std::string description() const { return describe<Real>(plan, set, executor.device().lanes(precision_of<Real>)); }
};

template <class Real>
NetworkSweep<Real>::State::State(Executor& executor, const nn::FrameSet& set, const SweepPlan& plan)
    : executor(executor), plan(plan), set(set), scaling(nn::fit_scaling(plan.scaling, set)) {
  plan.validate();
  set.validate();
  std::vector<SetVariant> variants{{}};  // the clean set serves every seed; noise is drawn for each
  std::vector<OnlineMember> members;
  for (const double noise : plan.noises) {
    for (const std::uint64_t seed : plan.seeds) {
      if (noise != 0) variants.push_back({noise, seed});
      members.push_back({seed, noise == 0 ? 0 : static_cast<std::uint32_t>(variants.size() - 1)});
    }
  }
  const LearningInputs<Real> inputs(executor.device(), set, scaling, variants);
  for (const nn::Topology& topology : plan.topologies) {
    trainings.emplace_back(executor, topology, inputs, members, plan.options);
    for (const double noise : plan.noises)
      for (const std::uint64_t seed : plan.seeds)
        networks.push_back({.topology = topology, .seed = seed, .noise = noise, .curve = {}});
  }
}

template <class Real>
bool NetworkSweep<Real>::State::running() const {
  return std::any_of(networks.begin(), networks.end(),
                     [](const SweepNetwork& n) { return n.status == nn::TrainStatus::running; });
}

// In weight updates; a network that has stopped counts as done.
template <class Real>
std::size_t NetworkSweep<Real>::State::work_done() const {
  std::size_t done = 0;
  for (const SweepNetwork& n : networks) {
    const std::size_t cycles = n.status == nn::TrainStatus::running ? n.cycles : plan.options.cycles(n.topology);
    done += cycles * n.topology.weight_count() * set.rows();
  }
  return done;
}

template <class Real>
std::size_t NetworkSweep<Real>::State::work_of_all() const {
  std::size_t all = 0;
  for (const SweepNetwork& n : networks)
    all += plan.options.cycles(n.topology) * n.topology.weight_count() * set.rows();
  return all;
}

// Reads what the last round did to a network.
template <class Real>
void NetworkSweep<Real>::State::collect(std::size_t i) {
  SweepNetwork& network = networks[i];
  const OnlineReport from{0, network.cycles, 0, 0};
  const OnlineReport now = training_of(i).report(place(i));
  if (now.cycle == network.cycles) return;
  const std::vector<nn::CycleErrors> errors = training_of(i).curve(place(i), from);
  network.status = static_cast<nn::TrainStatus>(now.status);
  for (const nn::CycleErrors& cycle : errors) {
    ++network.cycles;
    const bool last = network.cycles == now.cycle && network.status != nn::TrainStatus::running;
    const std::uint32_t before = network.curve.cycle.empty() ? 0 : network.curve.cycle.back();
    if (last || network.cycles == next_point(before)) note_cycle(network.curve, network.cycles, cycle);
  }
  network.sse = now.sse;
  network.largest = now.largest;
  patterns += static_cast<double>(errors.size()) * static_cast<double>(set.rows());
}

// Some cycles of every network; largest networks first, so that the threads end together.
template <class Real>
bool NetworkSweep<Real>::State::run_round(const SweepRunOptions& options) {
  std::vector<TrainOnline<Real>*> order;
  for (TrainOnline<Real>& training : trainings) order.push_back(&training);
  std::stable_sort(order.begin(), order.end(), [](const auto* a, const auto* b) {
    return a->topology().weight_count() > b->topology().weight_count();
  });
  std::vector<Job> jobs;
  for (TrainOnline<Real>* training : order) jobs.push_back(training->job(round_cycles));
  RunOptions run{.progress = {}, .largest_chunk = 1};
  const std::size_t done = work_done(), all = work_of_all();
  if (options.progress) run.progress = [&](std::size_t, std::size_t) { return options.progress(done, all); };
  const RunReport report = executor.run(jobs, run);
  for (std::size_t i = 0; i < networks.size(); ++i)
    if (networks[i].status == nn::TrainStatus::running) collect(i);
  seconds += report.seconds;
  const double pace = round_seconds / std::max(report.seconds, 1e-3);
  round_cycles = std::clamp(static_cast<std::uint32_t>(round_cycles * std::min(pace, 4.0)), 1u, longest_round);
  return !report.cancelled;
}

template <class Real>
NetworkSweep<Real>::NetworkSweep(Executor& executor, const nn::FrameSet& set, const SweepPlan& plan)
    : state_(std::make_unique<State>(executor, set, plan)) {}

template <class Real>
NetworkSweep<Real>::~NetworkSweep() = default;

template <class Real>
bool NetworkSweep<Real>::run(const SweepRunOptions& options) {
  auto written = Clock::now();
  bool going = true;
  while (going && state_->running()) {
    going = state_->run_round(options);
    if (!options.checkpoint.empty() && seconds_since(written) > options.checkpoint_seconds) {
      save(options.checkpoint);
      written = Clock::now();
    }
  }
  if (!options.checkpoint.empty()) save(options.checkpoint);
  if (going && options.progress) options.progress(state_->work_of_all(), state_->work_of_all());
  return !state_->running();
}

template <class Real>
const std::vector<SweepNetwork>& NetworkSweep<Real>::networks() const {
  return state_->networks;
}

template <class Real>
nn::Weights<Real> NetworkSweep<Real>::weights(std::size_t network) const {
  return state_->training_of(network).state(state_->place(network)).weights;
}

template <class Real>
const nn::InputScaling& NetworkSweep<Real>::scaling() const {
  return state_->scaling;
}

template <class Real>
double NetworkSweep<Real>::patterns() const {
  return state_->patterns;
}

template <class Real>
double NetworkSweep<Real>::seconds() const {
  return state_->seconds;
}

template <class Real>
std::vector<std::vector<double>> NetworkSweep<Real>::absolute_errors(const nn::FrameSet& set) const {
  const DeviceFrames frames(state_->executor.device(), set.frames);
  std::vector<std::vector<double>> errors;
  for (const TrainOnline<Real>& training : state_->trainings) {
    std::vector<nn::Weights<Real>> weights;
    for (std::size_t i = 0; i < training.size(); ++i) weights.push_back(training.state(i).weights);
    Forward<Real> forward(state_->executor, std::span<const nn::Weights<Real>>(weights), state_->scaling);
    forward.run(frames);
    for (std::size_t i = 0; i < weights.size(); ++i)
      errors.push_back(nn::absolute_errors(forward.result(i).slip_index, set));
  }
  return errors;
}

template <class Real>
std::vector<nn::ErrorReport> NetworkSweep<Real>::recall(const nn::FrameSet& set) const {
  std::vector<nn::ErrorReport> reports;
  for (const std::vector<double>& errors : absolute_errors(set)) reports.push_back(nn::report_errors(errors, set));
  return reports;
}

template <class Real>
std::vector<nn::ErrorReport> NetworkSweep<Real>::recall_learning_set() const {
  std::vector<nn::ErrorReport> reports = recall(state_->set);
  for (std::size_t i = 0; i < reports.size(); ++i) {
    const SweepNetwork& network = state_->networks[i];
    if (network.noise == 0) continue;
    const nn::FrameSet noisy = nn::with_noise(state_->set, network.noise, network.seed);
    const nn::Weights<Real> own = weights(i);
    Forward<Real> forward(state_->executor, std::span(&own, 1), state_->scaling);
    reports[i] = nn::report_errors(nn::absolute_errors(forward.recall(noisy.frames).slip_index, noisy), noisy);
  }
  return reports;
}

template <class Real>
nn::Model NetworkSweep<Real>::model(std::size_t i, const std::string& learning_set) const {
  const SweepNetwork& network = state_->networks[i];
  const nn::FrameSet shown = nn::with_noise(state_->set, network.noise, network.seed);
  const nn::Weights<Real> own = weights(i);
  Forward<Real> forward(state_->executor, std::span(&own, 1), state_->scaling);
  const nn::ErrorReport errors =
      nn::report_errors(nn::absolute_errors(forward.recall(shown.frames).slip_index, shown), shown);
  return {nn::Weights<float>(own), state_->scaling, network.seed, network.noise, learning_set,
          network.cycles,          errors.all};
}

template <class Real>
void NetworkSweep<Real>::save(const std::filesystem::path& checkpoint) const {
  std::vector<NetworkRecord<Real>> records;
  for (std::size_t i = 0; i < state_->networks.size(); ++i) {
    nn::OnlineState<Real> state = state_->training_of(i).state(state_->place(i));
    records.push_back({state_->networks[i], std::move(state.weights.values), std::move(state.step.values)});
  }
  write_checkpoint<Real>(checkpoint, state_->description(), records);
}

template <class Real>
bool NetworkSweep<Real>::load(const std::filesystem::path& checkpoint) {
  std::vector<NetworkRecord<Real>> records;
  for (const SweepNetwork& network : state_->networks) records.push_back({network, {}, {}});
  if (!read_checkpoint<Real>(checkpoint, state_->description(), records)) return false;
  for (std::size_t i = 0; i < records.size(); ++i) {
    nn::OnlineState<Real> state{nn::Weights<float>(records[i].network.topology)};
    state.weights.values = std::move(records[i].weights);
    state.step.values = std::move(records[i].steps);
    state.cycle = records[i].network.cycles;
    state.status = records[i].network.status;
    state_->training_of(i).set_state(state_->place(i), state);
    state_->networks[i] = records[i].network;
  }
  return true;
}

template class NetworkSweep<float>;
template class NetworkSweep<double>;

}  // namespace tactel::host
