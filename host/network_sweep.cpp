#include "host/network_sweep.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "fem/value_error.h"
#include "host/checksum.h"
#include "host/forward.h"
#include "host/sweep_checkpoint.h"
#include "host/sweep_schedule.h"

namespace tactel::host {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// The cycle that a learning curve keeps after this one.
std::uint32_t next_point(std::uint32_t cycle) { return cycle < 10 ? cycle + 1 : cycle + cycle / 10; }

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

std::string describe(const nn::BatchOptions& options) {
  std::string text = std::string(" batch ") + nn::name(options.rule) + ' ' + std::to_string(options.batch);
  for (const double number : {options.rate, options.momentum, options.beta1, options.beta2, options.epsilon})
    text += ' ' + exact(number);
  return text + ' ' + nn::name(options.order);
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
  const std::string limits = " stop " + exact(options.stop_error) + " limit " + std::to_string(options.cycle_limit);
  if (plan.batch) return text + limits + describe(*plan.batch);
  return text + " rate " + exact(options.rate) + " momentum " + exact(options.momentum) + limits + ' ' +
         nn::name(options.order);
}

}  // namespace

void note_cycle(SweepNetwork& network, const nn::CycleErrors& errors, bool last) {
  ++network.cycles;
  network.sse = static_cast<float>(errors.sse);
  network.largest = static_cast<float>(errors.largest);
  LearningCurve& curve = network.curve;
  if (!last && network.cycles != next_point(curve.cycle.empty() ? 0 : curve.cycle.back())) return;
  curve.cycle.push_back(network.cycles);
  curve.sse.push_back(network.sse);
  curve.largest.push_back(network.largest);
}

void SweepPlan::validate() const {
  if (topologies.empty()) throw ValueError("network", "none", "at least one network");
  if (seeds.empty()) throw ValueError("seeds", "none", "at least one seed");
  if (noises.empty()) throw ValueError("noise", "none", "at least one level, 0 for none");
  for (const double noise : noises)
    if (!(noise >= 0) || !std::isfinite(noise))
      throw ValueError("noise", std::to_string(noise), "finite and at least 0");
  options.validate();
  if (batch) batch->validate();
}

template <class Real>
struct NetworkSweep<Real>::State {
  Executor& executor;
  SweepPlan plan;
  nn::FrameSet set;
  nn::InputScaling scaling;
  std::vector<SweepNetwork> networks;  ///< [topologies][noises][seeds]
  std::unique_ptr<SweepSchedule<Real>> schedule;
  double seconds = 0;

  State(Executor& executor, const nn::FrameSet& set, const SweepPlan& plan);
  std::size_t per_topology() const { return plan.noises.size() * plan.seeds.size(); }
  bool running() const;
  std::size_t work_done() const;
  std::size_t work_of_all() const;
  bool run_round(const SweepRunOptions& options);
  nn::Weights<Real> weights(std::size_t network) const { return schedule->weights(network); }
  std::string description() const { return describe<Real>(plan, set, executor.device().lanes(precision_of<Real>)); }
};

template <class Real>
NetworkSweep<Real>::State::State(Executor& executor, const nn::FrameSet& set, const SweepPlan& plan)
    : executor(executor), plan(plan), set(set), scaling(nn::fit_scaling(plan.scaling, set)) {
  plan.validate();
  set.validate();
  std::vector<SetVariant> variants{{}};  // the clean set serves every seed; noise is drawn for each
  SweepMembers members{plan.topologies, {}};
  for (const double noise : plan.noises) {
    for (const std::uint64_t seed : plan.seeds) {
      if (noise != 0) variants.push_back({noise, seed});
      members.members.push_back({seed, noise == 0 ? 0 : static_cast<std::uint32_t>(variants.size() - 1)});
    }
  }
  const LearningInputs<Real> inputs(executor.device(), set, scaling, variants);
  schedule = plan.batch ? batch_schedule(executor, inputs, members, *plan.batch, plan.options)
                        : online_schedule(executor, inputs, members, plan.options);
  for (const nn::Topology& topology : plan.topologies)
    for (const double noise : plan.noises)
      for (const std::uint64_t seed : plan.seeds)
        networks.push_back({.topology = topology, .seed = seed, .noise = noise, .curve = {}});
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

// Returns whether to go on.
template <class Real>
bool NetworkSweep<Real>::State::run_round(const SweepRunOptions& options) {
  const std::size_t done = work_done(), all = work_of_all();
  bool going = true;
  std::function<bool()> go_on;
  if (options.progress) go_on = [&] { return going = going && options.progress(done, all); };
  std::vector<std::uint32_t> cycles;
  for (const SweepNetwork& network : networks) cycles.push_back(network.cycles);
  const auto start = Clock::now();
  schedule->run_round(networks, go_on);
  seconds += seconds_since(start);
  for (std::size_t i = 0; i < networks.size(); ++i)
    if (networks[i].cycles != cycles[i]) networks[i].seconds = seconds;
  return going && (!options.progress || options.progress(work_done(), all));
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
  return !state_->running();
}

template <class Real>
const std::vector<SweepNetwork>& NetworkSweep<Real>::networks() const {
  return state_->networks;
}

template <class Real>
nn::Weights<Real> NetworkSweep<Real>::weights(std::size_t network) const {
  return state_->weights(network);
}

template <class Real>
const nn::InputScaling& NetworkSweep<Real>::scaling() const {
  return state_->scaling;
}

template <class Real>
double NetworkSweep<Real>::patterns() const {
  double cycles = 0;
  for (const SweepNetwork& network : state_->networks) cycles += network.cycles;
  return cycles * static_cast<double>(state_->set.rows());
}

template <class Real>
double NetworkSweep<Real>::seconds() const {
  return state_->seconds;
}

template <class Real>
std::vector<std::vector<double>> NetworkSweep<Real>::absolute_errors(const nn::FrameSet& set) const {
  const DeviceFrames frames(state_->executor.device(), set.frames);
  std::vector<std::vector<double>> errors;
  while (errors.size() < state_->networks.size()) {
    std::vector<nn::Weights<Real>> weights;
    for (std::size_t i = 0; i < state_->per_topology(); ++i) weights.push_back(state_->weights(errors.size() + i));
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
  std::optional<Forward<Real>> forward;  // of one topology after the other
  std::optional<nn::Topology> its_topology;
  for (std::size_t i = 0; i < reports.size(); ++i) {
    const SweepNetwork& network = state_->networks[i];
    if (network.noise == 0) continue;
    const nn::FrameSet noisy = nn::with_noise(state_->set, network.noise, network.seed);
    const nn::Weights<Real> own = weights(i);
    if (its_topology == network.topology)
      forward->set_network(0, own);
    else
      forward.emplace(state_->executor, std::span(&own, 1), state_->scaling);
    its_topology = network.topology;
    reports[i] = nn::report_errors(nn::absolute_errors(forward->recall(noisy.frames).slip_index, noisy), noisy);
  }
  return reports;
}

template <class Real>
nn::Model NetworkSweep<Real>::model(std::size_t i, const std::string& learning_set) const {
  const SweepNetwork& network = state_->networks[i];
  const nn::FrameSet shown = nn::with_noise(state_->set, network.noise, network.seed);
  const nn::Weights<Real> own = weights(i);
  Forward<Real> forward(state_->executor, std::span(&own, 1), state_->scaling);
  const nn::Recall<Real> answer = forward.recall(shown.frames);
  return model(i, learning_set, nn::report_errors(nn::absolute_errors(answer.slip_index, shown), shown).all);
}

template <class Real>
nn::Model NetworkSweep<Real>::model(std::size_t i, const std::string& learning_set,
                                    const nn::ErrorSummary& learning_errors) const {
  const SweepNetwork& network = state_->networks[i];
  return {nn::Weights<float>(weights(i)),
          state_->scaling,
          network.seed,
          network.noise,
          learning_set,
          network.cycles,
          learning_errors};
}

template <class Real>
std::string NetworkSweep<Real>::description() const {
  return state_->description();
}

template <class Real>
void NetworkSweep<Real>::save(const std::filesystem::path& checkpoint) const {
  std::vector<NetworkRecord<Real>> records;
  for (std::size_t i = 0; i < state_->networks.size(); ++i) {
    records.push_back({state_->networks[i], {}, {}, {}});
    state_->schedule->store(i, records.back());
  }
  write_checkpoint<Real>(checkpoint, state_->description(), records);
}

template <class Real>
bool NetworkSweep<Real>::load(const std::filesystem::path& checkpoint) {
  std::vector<NetworkRecord<Real>> records;
  for (const SweepNetwork& network : state_->networks) {
    records.push_back({network, {}, {}, {}});
    state_->schedule->store(records.size() - 1, records.back());  // for its sizes
  }
  if (!read_checkpoint<Real>(checkpoint, state_->description(), records)) return false;
  state_->schedule->restore(records);
  for (std::size_t i = 0; i < records.size(); ++i) {
    state_->networks[i] = records[i].network;
    state_->seconds = std::max(state_->seconds, records[i].network.seconds);
  }
  return true;
}

template class NetworkSweep<float>;
template class NetworkSweep<double>;

}  // namespace tactel::host
