// SPDX-License-Identifier: Apache-2.0
#include "host/networks/network_training.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "fem/value_error.h"
#include "host/networks/forward.h"
#include "host/networks/training_checkpoint.h"
#include "host/networks/training_schedule.h"
#include "host/support/checksum.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// The cycle that a learning curve keeps after this one.
std::uint64_t next_point(std::uint64_t cycle) { return cycle < 10 ? cycle + 1 : cycle + cycle / 10; }

std::string exact_text(double number) {
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
    text += ' ' + exact_text(number);
  return text + ' ' + nn::name(options.order);
}

}  // namespace

template <class Real>
std::string training_description(const Executor& executor, const nn::FrameSet& set, const TrainingPlan& plan) {
  const int lanes = executor.device().lanes(precision_of<Real>);
  std::string text = "precision " + std::to_string(sizeof(Real)) + " lanes " + std::to_string(lanes) + " scaling " +
                     nn::name(plan.scaling) + " set " + std::to_string(set.rows()) + " " +
                     std::to_string(set_hash(set)) + " networks";
  for (const nn::Topology& topology : plan.topologies) text += ' ' + topology.text();
  text += " seeds";
  for (const std::uint64_t seed : plan.seeds) text += ' ' + std::to_string(seed);
  text += " noises";
  for (const double noise : plan.noises) text += ' ' + exact_text(noise);
  const nn::OnlineOptions& options = plan.options;
  const std::string limits =
      " stop " + exact_text(options.stop_error) + " limit " + std::to_string(options.cycle_limit);
  if (plan.batch) {
    const bool bound = std::ranges::any_of(plan.topologies, &nn::Topology::has_bound);
    return text + limits + describe(*plan.batch) + (bound ? " level " + exact_text(plan.batch->level) : "");
  }
  return text + " rate " + exact_text(options.rate) + " momentum " + exact_text(options.momentum) + limits + ' ' +
         nn::name(options.order);
}

void note_cycle(TrainedNetwork& network, const nn::CycleErrors& errors, bool last) {
  ++network.cycles;
  network.sse = static_cast<float>(errors.sse);
  network.largest = static_cast<float>(errors.largest);
  LearningCurve& curve = network.curve;
  if (!last && network.cycles != next_point(curve.cycle.empty() ? 0 : curve.cycle.back())) return;
  curve.cycle.push_back(network.cycles);
  curve.sse.push_back(network.sse);
  curve.largest.push_back(network.largest);
}

void TrainingPlan::validate() const {
  if (topologies.empty()) throw ValueError("network", "none", "at least one network");
  if (seeds.empty()) throw ValueError("seeds", "none", "at least one seed");
  if (noises.empty()) throw ValueError("noise", "none", "at least one level, 0 for none");
  for (const double noise : noises)
    if (!(noise >= 0 && noise <= 1))
      throw ValueError("noise", std::to_string(noise), "a fraction of the largest stress, 0 to 1: 0.1 for 10 %");
  for (const nn::Topology& topology : topologies) {
    if (batch) break;
    if (topology.has_bound())
      throw ValueError("network", topology.text(), "one output, or --schedule batch for the heads of a bound");
    if (topology.hidden_activation() != nn::Activation::logistic)
      throw ValueError("network", topology.text(), "logistic neurons, or --schedule batch");
  }
  options.validate();
  if (batch) batch->validate();
}

template <class Real>
struct NetworkTraining<Real>::State {
  Executor& executor;
  TrainingPlan plan;
  nn::FrameSet set;
  nn::InputScaling scaling;
  std::vector<TrainedNetwork> networks;  ///< [topologies][noises][seeds]
  std::unique_ptr<TrainingSchedule<Real>> schedule;
  double seconds = 0;

  State(Executor& executor, const nn::FrameSet& set, const TrainingPlan& plan);
  std::size_t per_topology() const { return plan.noises.size() * plan.seeds.size(); }
  bool running() const;
  std::size_t work_done() const;
  std::size_t work_of_all() const;
  bool run_round(const TrainingRunOptions& options);
  nn::Weights<Real> weights(std::size_t network) const {
    return nn::weights_of_frames(schedule->weights(network), set.history);
  }
  std::vector<NetworkRecord<Real>> records() const;
  bool possible(std::span<const NetworkRecord<Real>> records) const;
  std::string description() const { return training_description<Real>(executor, set, plan); }
};

template <class Real>
NetworkTraining<Real>::State::State(Executor& executor, const nn::FrameSet& set, const TrainingPlan& plan)
    : executor(executor), plan(plan), set(set), scaling(nn::fit_scaling(plan.scaling, set)) {
  plan.validate();
  set.validate();
  std::vector<SetVariant> variants{{}};  // the clean set serves every seed; noise is drawn for each
  TrainingMembers members{plan.topologies, {}};
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
bool NetworkTraining<Real>::State::running() const {
  return std::any_of(networks.begin(), networks.end(),
                     [](const TrainedNetwork& n) { return n.status == nn::TrainStatus::running; });
}

// In weight updates; a network that has stopped counts as done.
template <class Real>
std::size_t NetworkTraining<Real>::State::work_done() const {
  std::size_t done = 0;
  for (const TrainedNetwork& n : networks) {
    const std::size_t cycles = n.status == nn::TrainStatus::running ? n.cycles : plan.options.cycles(n.topology);
    done += cycles * n.topology.weight_count() * set.rows();
  }
  return done;
}

template <class Real>
std::size_t NetworkTraining<Real>::State::work_of_all() const {
  std::size_t all = 0;
  for (const TrainedNetwork& n : networks)
    all += plan.options.cycles(n.topology) * n.topology.weight_count() * set.rows();
  return all;
}

// Returns true to continue.
template <class Real>
bool NetworkTraining<Real>::State::run_round(const TrainingRunOptions& options) {
  const std::size_t done = work_done(), all = work_of_all();
  bool going = true;
  std::function<bool()> go_on;
  if (options.progress) go_on = [&] { return going = going && options.progress(done, all); };
  std::vector<std::uint32_t> cycles;
  for (const TrainedNetwork& network : networks) cycles.push_back(network.cycles);
  const auto start = Clock::now();
  schedule->run_round(networks, go_on);
  seconds += seconds_since(start);
  for (std::size_t i = 0; i < networks.size(); ++i)
    if (networks[i].cycles != cycles[i]) networks[i].seconds = seconds;
  return going && (!options.progress || options.progress(work_done(), all));
}

template <class Real>
NetworkTraining<Real>::NetworkTraining(Executor& executor, const nn::FrameSet& set, const TrainingPlan& plan)
    : state_(std::make_unique<State>(executor, set, plan)) {}

template <class Real>
NetworkTraining<Real>::~NetworkTraining() = default;

template <class Real>
bool NetworkTraining<Real>::run(const TrainingRunOptions& options) {
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
const std::vector<TrainedNetwork>& NetworkTraining<Real>::networks() const {
  return state_->networks;
}

template <class Real>
nn::Weights<Real> NetworkTraining<Real>::weights(std::size_t network) const {
  return state_->weights(network);
}

template <class Real>
const nn::InputScaling& NetworkTraining<Real>::scaling() const {
  return state_->scaling;
}

template <class Real>
double NetworkTraining<Real>::patterns() const {
  double cycles = 0;
  for (const TrainedNetwork& network : state_->networks) cycles += network.cycles;
  return cycles * static_cast<double>(state_->set.rows());
}

template <class Real>
double NetworkTraining<Real>::seconds() const {
  return state_->seconds;
}

template <class Real>
std::vector<std::vector<double>> NetworkTraining<Real>::absolute_errors(const nn::FrameSet& set) const {
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
std::vector<double> NetworkTraining<Real>::slip_index(std::size_t network, const nn::FrameSet& set) const {
  const nn::Weights<Real> own = weights(network);
  Forward<Real> forward(state_->executor, std::span(&own, 1), state_->scaling);
  const auto answer = forward.recall(set.frames);
  return {answer.slip_index.begin(), answer.slip_index.end()};
}

template <class Real>
std::vector<nn::ErrorReport> NetworkTraining<Real>::recall(const nn::FrameSet& set) const {
  std::vector<nn::ErrorReport> reports;
  for (const std::vector<double>& errors : absolute_errors(set)) reports.push_back(nn::report_errors(errors, set));
  return reports;
}

template <class Real>
std::vector<nn::ErrorReport> NetworkTraining<Real>::recall_learning_set() const {
  std::vector<nn::ErrorReport> reports = recall(state_->set);
  std::optional<Forward<Real>> forward;  // of one topology after the other
  std::optional<nn::Topology> its_topology;
  for (std::size_t i = 0; i < reports.size(); ++i) {
    const TrainedNetwork& network = state_->networks[i];
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
nn::Model NetworkTraining<Real>::model(std::size_t i, const std::string& learning_set) const {
  const TrainedNetwork& network = state_->networks[i];
  const nn::FrameSet shown = nn::with_noise(state_->set, network.noise, network.seed);
  const nn::Weights<Real> own = weights(i);
  Forward<Real> forward(state_->executor, std::span(&own, 1), state_->scaling);
  const nn::Recall<Real> answer = forward.recall(shown.frames);
  return model(i, learning_set, nn::report_errors(nn::absolute_errors(answer.slip_index, shown), shown).all);
}

template <class Real>
nn::Model NetworkTraining<Real>::model(std::size_t i, const std::string& learning_set,
                                       const nn::ErrorSummary& learning_errors) const {
  const TrainedNetwork& network = state_->networks[i];
  nn::Model model{nn::Weights<float>(weights(i)),
                  state_->scaling,
                  network.seed,
                  network.noise,
                  learning_set,
                  network.cycles,
                  learning_errors,
                  state_->plan.history,
                  state_->plan.magnitude};
  if (network.topology.has_bound()) {
    const nn::FrameSet shown = nn::with_noise(state_->set, network.noise, network.seed);
    model.bound = nn::uncalibrated_bound(nn::scale_frames<float>(state_->scaling, shown.frames),
                                         network.topology.inputs() / (2 * model.history.frames));
    model.bound->level = state_->plan.batch->level;
  }
  return model;
}

template <class Real>
std::string NetworkTraining<Real>::description() const {
  return state_->description();
}

template <class Real>
std::vector<NetworkRecord<Real>> NetworkTraining<Real>::State::records() const {
  std::vector<NetworkRecord<Real>> records;
  for (std::size_t i = 0; i < networks.size(); ++i) {
    records.push_back({networks[i], nn::BatchState<Real>(nn::Weights<float>(networks[i].topology))});
    schedule->store(i, records.back());
  }
  return records;
}

// Whether a training by this plan can have come there: nothing runs beyond its limit of cycles, and networks of one
// topology that still learn by mini-batches are at the same epoch.
template <class Real>
bool NetworkTraining<Real>::State::possible(std::span<const NetworkRecord<Real>> records) const {
  std::map<std::string, std::uint32_t> epoch;
  for (const NetworkRecord<Real>& record : records) {
    const TrainedNetwork& network = record.network;
    const auto limit = static_cast<std::uint32_t>(plan.options.cycles(network.topology));
    const bool runs = network.status == nn::TrainStatus::running;
    if (network.cycles > limit || (runs && network.cycles == limit)) return false;
    if (!network.curve.cycle.empty() && network.curve.cycle.back() > network.cycles) return false;
    if (plan.batch && runs &&
        epoch.try_emplace(network.topology.text(), network.cycles).first->second != network.cycles)
      return false;
  }
  return true;
}

template <class Real>
void NetworkTraining<Real>::save(const std::filesystem::path& checkpoint) const {
  const std::vector<NetworkRecord<Real>> records = state_->records();
  write_checkpoint<Real>(checkpoint, state_->description(), records);
}

template <class Real>
bool NetworkTraining<Real>::load(const std::filesystem::path& checkpoint) {
  std::vector<NetworkRecord<Real>> records = state_->records();  // for their sizes
  if (!read_checkpoint<Real>(checkpoint, state_->description(), records)) return false;
  if (!state_->possible(records))
    throw ConfigError(checkpoint.string(), "checkpoint", "damaged", "whole; delete it to start anew");
  state_->schedule->restore(records);
  for (std::size_t i = 0; i < records.size(); ++i) {
    state_->networks[i] = records[i].network;
    state_->seconds = std::max(state_->seconds, records[i].network.seconds);
  }
  return true;
}

template std::string training_description<float>(const Executor&, const nn::FrameSet&, const TrainingPlan&);
template std::string training_description<double>(const Executor&, const nn::FrameSet&, const TrainingPlan&);
template class NetworkTraining<float>;
template class NetworkTraining<double>;

}  // namespace tactel::host
