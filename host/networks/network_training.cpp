// SPDX-License-Identifier: Apache-2.0
#include "host/networks/network_training.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "fem/numbers/value_error.h"
#include "host/networks/forward.h"
#include "host/networks/train_online.h"
#include "host/networks/training_schedule.h"
#include "host/networks/validation.h"
#include "host/support/errors.h"
#include "host/support/made_ahead.h"
#include "host/support/seconds.h"

namespace tactel::host {

Device training_device(const Device& device, const TrainingPlan& plan) {
  const bool by_groups = std::ranges::all_of(
      plan.topologies, [&](const nn::Topology& topology) { return group_items(device, topology) > 1; });
  return by_groups ? device : device.for_training();
}

template <class Real>
NetworkTraining<Real>::NetworkTraining(Executor& executor, const nn::FrameSet& set, const TrainingPlan& plan)
    : NetworkTraining(executor, nullptr, &set, plan) {}

template <class Real>
NetworkTraining<Real>::NetworkTraining(Executor& executor, FrameStream& stream, const TrainingPlan& plan)
    : NetworkTraining(executor, &stream, nullptr, plan) {}

template <class Real>
NetworkTraining<Real>::NetworkTraining(Executor& executor, FrameStream* stream, const nn::FrameSet* set,
                                       const TrainingPlan& plan)
    : executor_(executor), plan_(plan), stream_(stream) {
  plan.validate();
  source_ = stream != nullptr ? stream->description() : set_description(*set);
  if (stream != nullptr)
    take_first_block();
  else
    set_ = *set;
  set_.validate();
  scaling_ = nn::fit_scaling(plan.scaling, set_, plan.features);
  view_ = nn::LearningView(scaling_, set_.frames);
  for (nn::Topology& topology : plan_.topologies) topology = topology.with_inputs(scaling_.inputs(topology.inputs()));
  learnt_ = nn::learnt_ranges(set_);
  if (stream != nullptr && std::ranges::any_of(plan.topologies, &nn::Topology::has_bound))
    bound_ = bound_of(plan.noises[0], plan.seeds[0]);
  std::vector<OnlineMember> members;  // of each topology: the clean rows serve every seed, noise is drawn for each
  std::uint32_t noisy = std::ranges::count(plan.noises, 0.0) > 0 ? 1 : 0;
  for (const double noise : plan.noises)
    for (const std::uint64_t seed : plan.seeds) members.push_back({seed, noise == 0 ? 0 : noisy++});
  for (const nn::Topology& topology : plan_.topologies)
    for (const double noise : plan.noises)
      for (const std::uint64_t seed : plan.seeds)
        networks_.push_back({.topology = topology, .seed = seed, .noise = noise});
  schedule_ =
      plan.batch ? batch_schedule<Real>(executor, plan_, members) : online_schedule<Real>(executor, plan_, members);
  if (plan.validation) validation_ = std::make_unique<Validation<Real>>(executor, plan_, scaling_, networks_.size());
  if (stream == nullptr) schedule_->take(*made_block(0).inputs, 1);
}

template <class Real>
NetworkTraining<Real>::~NetworkTraining() = default;

template <class Real>
void NetworkTraining<Real>::take_first_block() {
  const auto start = Clock::now();
  for (; first_ < stream_->blocks() && set_.rows() == 0; ++first_) set_ = stream_->block(first_);
  if (set_.rows() == 0)
    throw ConfigError(stream_->name(), "slip_index", "of no row solved", "at least one row to learn from");
  --first_;
  first_seconds_ = seconds_since(start);
}

// Noise of a stream is drawn anew for every block.
template <class Real>
typename NetworkTraining<Real>::Block NetworkTraining<Real>::made_block(std::uint64_t k) try {
  const auto start = Clock::now();
  nn::FrameSet rows;
  if (stream_ != nullptr) rows = k == first_ ? std::exchange(set_, {}) : stream_->block(k);
  const nn::FrameSet& shown = stream_ != nullptr ? rows : set_;
  Block block;
  block.rows_seconds = seconds_since(start);
  if (shown.rows() == 0) return block;
  std::vector<SetVariant> variants;
  if (std::ranges::count(plan_.noises, 0.0) > 0) variants.emplace_back();
  for (const double noise : plan_.noises)
    for (const std::uint64_t seed : plan_.seeds)
      if (noise != 0) variants.push_back({noise, seed + (k << 20)});
  block.inputs.emplace(executor_.device(), shown, scaling_, variants, view_);
  block.inputs_seconds = seconds_since(start) - block.rows_seconds;
  return block;
} catch (const ValueError& error) {
  if (stream_ == nullptr) throw;
  throw ConfigError(stream_->name(), fmt::format("{} of block {}", error.key, k), error.value, error.allowed);
}

template <class Real>
nn::Bound NetworkTraining<Real>::bound_of(double noise, std::uint64_t seed) const {
  const nn::FrameSet shown = nn::with_noise(set_, noise, seed);
  nn::Bound bound = nn::uncalibrated_bound(nn::scale_frames<float>(scaling_, shown.frames),
                                           scaling_.normals(static_cast<int>(shown.frames.cols())));
  bound.level = plan_.batch->level;
  return bound;
}

template <class Real>
bool NetworkTraining<Real>::running() const {
  return std::ranges::any_of(networks_, &TrainedNetwork::running);
}

// In weight updates; a network that has stopped counts as done.
template <class Real>
std::size_t NetworkTraining<Real>::work(bool of_all) const {
  std::size_t work = 0;
  for (const TrainedNetwork& n : networks_) {
    const std::uint64_t all = plan_.rows ? *plan_.rows : plan_.options.cycles(n.topology) * set_.rows();
    work += n.topology.weight_count() * (of_all || !n.running() ? all : std::min(n.rows, all));
  }
  return work;
}

template <class Real>
bool NetworkTraining<Real>::run(const TrainingRunOptions& options) {
  auto written = Clock::now();
  if (stream_ != nullptr && block_ > first_) set_ = {};
  if (stream_ != nullptr && block_ <= first_)
    seconds_ += first_seconds_, stages_.rows += first_seconds_, stages_.all += first_seconds_;
  const int threads = stream_ != nullptr ? stream_->at_once() : 0;
  MadeAhead<Block> blocks(block_, threads, static_cast<std::size_t>(threads) + 2,
                          [this](std::uint64_t k) { return made_block(k); });
  // The blocks under way at the end of a training are of no use.
  const std::unique_ptr<FrameStream, decltype([](FrameStream* stream) { stream->stop(); })> stop_at_end(stream_);
  bool going = true;
  while (going && running()) {
    going = run_round(blocks, options);
    if (options.checkpoint.empty() || seconds_since(written) <= options.checkpoint_seconds) continue;
    save(options.checkpoint);
    written = Clock::now();
  }
  if (!options.checkpoint.empty()) save(options.checkpoint);
  if (running()) return false;
  for (std::size_t i = 0; i < networks_.size(); ++i)  // errors may be finite where outputs saturate
    if (!nn::all_finite(weights(i))) networks_[i].status = nn::TrainStatus::not_finite;
  return true;
}

// Returns true to continue. A block of a stream is learnt as a whole.
template <class Real>
bool NetworkTraining<Real>::run_round(MadeAhead<Block>& blocks, const TrainingRunOptions& options) {
  const auto start = Clock::now();
  const std::size_t done = work(false), all = work(true);
  std::vector<std::uint32_t> cycles;
  for (const TrainedNetwork& network : networks_) cycles.push_back(network.cycles);
  bool going = true;
  std::function<bool()> go_on;
  if (options.progress && stream_ == nullptr) go_on = [&] { return going = going && options.progress(done, all); };
  auto taken = start;
  auto rows = static_cast<std::uint32_t>(stream_ != nullptr ? 0 : set_.rows());  // a stream's thread takes set_
  if (stream_ != nullptr) {
    const Block block = blocks.next();
    taken = Clock::now();
    rows = take(block, options.log) ? block.inputs->rows() : 0;
  }
  if (rows > 0) schedule_->run_round(networks_, go_on);
  if (rows > 0 && validation_) validate(cycles, rows);
  if (options.recall != nullptr) judge(cycles, *options.recall);
  const double seconds = seconds_since(start);
  seconds_ += seconds;
  stages_.training += seconds_since(taken), stages_.all += seconds * (1 + blocks.threads());
  for (std::size_t i = 0; i < networks_.size(); ++i)
    if (networks_[i].cycles != cycles[i]) networks_[i].seconds = seconds_;
  return going && (!options.progress || options.progress(work(false), all));
}

// Takes the stream's next block. Returns false where it has no rows.
template <class Real>
bool NetworkTraining<Real>::take(const Block& block, const LogSink& log) {
  ++block_;
  stages_.rows += block.rows_seconds, stages_.inputs += block.inputs_seconds;
  if (!block.inputs) {
    if (block_ <= stream_->blocks() && log)
      log(LogLevel::warning, stream_->name() + ": a block without a row that was solved with a slippage index");
    for (TrainedNetwork& network : networks_) network.cycles += network.running();
    return false;
  }
  const double left = 1 - static_cast<double>(rows()) / static_cast<double>(*plan_.rows);
  schedule_->take(*block.inputs, plan_.batch->cosine ? 1 : std::max(TrainingPlan::last_rate, left));
  return true;
}

// Judges the networks that have a new cycle, of so many rows, by the validation set. `cycles`: before it.
template <class Real>
void NetworkTraining<Real>::validate(std::span<const std::uint32_t> cycles, std::uint32_t rows) {
  for (std::size_t i = 0; i < networks_.size(); ++i) {
    TrainedNetwork& network = networks_[i];
    if (network.cycles == cycles[i]) continue;
    const double error = validation_->judge(i, network, last_weights(i));
    if (validation_->in_vain(network)) {
      network.stop_early(rows);
      schedule_->stop(i);
    }
    if (network.curve.back().cycle == network.cycles) network.curve.back().validation = error;
  }
}

// Judges the networks whose curves have a new point. `cycles`: before it.
template <class Real>
void NetworkTraining<Real>::judge(std::span<const std::uint32_t> cycles, const nn::FrameSet& recall_set) {
  std::vector<std::vector<double>> errors;
  for (std::size_t i = 0; i < networks_.size(); ++i) {
    TrainedNetwork& network = networks_[i];
    if (network.cycles == cycles[i] || network.curve.empty() || network.curve.back().cycle != network.cycles) continue;
    if (errors.empty()) errors = absolute_errors(recall_set, [this](std::size_t k) { return last_weights(k); });
    const bool good = network.status != nn::TrainStatus::not_finite;
    network.curve.back().recall = good ? static_cast<float>(nn::report_errors(errors[i], recall_set).all.mean) : NAN;
  }
}

template <class Real>
nn::Weights<Real> NetworkTraining<Real>::last_weights(std::size_t network) const {
  const nn::Weights<Real> learnt = schedule_->weights(network);
  return view_.empty() ? nn::weights_of_frames(learnt, plan_.history.frames) : view_.weights_of_inputs(learnt);
}

template <class Real>
nn::Weights<Real> NetworkTraining<Real>::weights(std::size_t network) const {
  if (!validation_ || validation_->best(network).empty()) return last_weights(network);
  nn::Weights<Real> best(networks_[network].topology);
  best.values = validation_->best(network);
  return best;
}

template <class Real>
double NetworkTraining<Real>::patterns() const {
  double patterns = 0;
  for (const TrainedNetwork& network : networks_) patterns += static_cast<double>(network.rows);
  return patterns;
}

template <class Real>
std::uint64_t NetworkTraining<Real>::rows() const {
  if (stream_ == nullptr) return static_cast<std::uint64_t>(set_.rows());
  return std::ranges::max(networks_, {}, &TrainedNetwork::rows).rows;
}

template <class Real>
std::vector<std::vector<double>> NetworkTraining<Real>::absolute_errors(const nn::FrameSet& set) const {
  return absolute_errors(set, [this](std::size_t network) { return weights(network); });
}

template <class Real>
template <class WeightsOf>
std::vector<std::vector<double>> NetworkTraining<Real>::absolute_errors(const nn::FrameSet& set,
                                                                        const WeightsOf& weights_of) const {
  const DeviceFrames frames(executor_.device(), set.frames);
  std::vector<std::vector<double>> errors;
  while (errors.size() < networks_.size()) {
    std::vector<nn::Weights<Real>> weights_of_group;
    for (std::size_t i = 0; i < plan_.noises.size() * plan_.seeds.size(); ++i)
      weights_of_group.push_back(weights_of(errors.size() + i));
    Forward<Real> forward(executor_, std::span<const nn::Weights<Real>>(weights_of_group), scaling_);
    forward.run(frames);
    for (std::size_t i = 0; i < weights_of_group.size(); ++i)
      errors.push_back(nn::absolute_errors(forward.result(i).slip_index, set));
  }
  return errors;
}

template <class Real>
std::vector<double> NetworkTraining<Real>::slip_index(std::size_t network, const nn::FrameSet& set) const {
  const nn::Weights<Real> trained = weights(network);
  Forward<Real> forward(executor_, std::span(&trained, 1), scaling_);
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
  if (stream_ != nullptr) {
    nn::ErrorReport counted;
    counted.all.count = rows();
    return std::vector(networks_.size(), counted);
  }
  std::vector<nn::ErrorReport> reports = recall(set_);
  std::optional<Forward<Real>> forward;  // of one topology after the other
  std::optional<nn::Topology> its_topology;
  for (std::size_t i = 0; i < reports.size(); ++i) {
    const TrainedNetwork& network = networks_[i];
    if (network.noise == 0) continue;
    const nn::FrameSet noisy = nn::with_noise(set_, network.noise, network.seed);
    const nn::Weights<Real> trained = weights(i);
    if (its_topology == network.topology)
      forward->set_network(0, trained);
    else
      forward.emplace(executor_, std::span(&trained, 1), scaling_);
    its_topology = network.topology;
    reports[i] = nn::report_errors(nn::absolute_errors(forward->recall(noisy.frames).slip_index, noisy), noisy);
  }
  return reports;
}

template <class Real>
nn::Model NetworkTraining<Real>::model(std::size_t i, const std::string& learning_set,
                                       const nn::ErrorSummary& learning_errors) const {
  const TrainedNetwork& network = networks_[i];
  nn::Model model{nn::Weights<float>(weights(i)),
                  scaling_,
                  network.seed,
                  network.noise,
                  learning_set,
                  network.best_cycle > 0 ? network.best_cycle : network.cycles,
                  learning_errors,
                  plan_.history,
                  plan_.magnitude,
                  plan_.target};
  model.learnt = learnt_;
  model.learnt.alarm_at = plan_.alarm_at;
  if (network.topology.has_bound()) model.bound = bound_ ? *bound_ : bound_of(network.noise, network.seed);
  return model;
}

template <class Real>
std::string NetworkTraining<Real>::description(const TrainingPlan& plan) const {
  return training_description(source_, executor_.device().lanes(precision_of<Real>), precision_of<Real>, plan);
}

template <class Real>
std::vector<NetworkRecord<Real>> NetworkTraining<Real>::records() const {
  std::vector<NetworkRecord<Real>> records;
  for (std::size_t i = 0; i < networks_.size(); ++i) {
    records.push_back({networks_[i], nn::BatchState<Real>(nn::Weights<float>(networks_[i].topology))});
    schedule_->store(i, records.back());
    if (validation_) records.back().best = validation_->best(i);
  }
  return records;
}

// Whether a training by this plan can have come there: nothing runs beyond its limit, weights are kept where the plan
// says so, and networks that still learn by mini-batches are in step: those of a topology, and all those of a stream.
template <class Real>
bool NetworkTraining<Real>::possible(std::span<const NetworkRecord<Real>> records) const {
  std::map<std::string, std::tuple<std::uint64_t, std::uint64_t, std::uint64_t, std::uint64_t>> steps;
  for (const NetworkRecord<Real>& record : records) {
    const TrainedNetwork& network = record.network;
    if (!network.curve.empty() && network.curve.back().cycle > network.cycles) return false;
    const bool averaged = plan_.batch && plan_.batch->average > 0 && record.state.updates > 0;
    if (record.state.mean.values.empty() == averaged || record.best.empty() != (network.best_cycle == 0)) return false;
    if (network.best_cycle > (plan_.validation ? network.cycles : 0)) return false;
    if (!network.running()) continue;
    if (plan_.over(network.topology, network.cycles, network.rows)) return false;
    if (!plan_.batch) continue;
    const std::tuple step{network.cycles, network.rows, record.state.epoch, record.state.updates};
    const std::string together = stream_ != nullptr ? "all" : network.topology.text();
    if (steps.try_emplace(together, step).first->second != step) return false;
  }
  return true;
}

template <class Real>
void NetworkTraining<Real>::save(const std::filesystem::path& checkpoint) const {
  write_checkpoint<Real>(checkpoint, description(), records());
}

template <class Real>
bool NetworkTraining<Real>::load(const std::filesystem::path& checkpoint, const std::vector<std::uint64_t>& seeds) {
  TrainingPlan part = plan_;
  part.seeds = seeds;
  const auto in_part = [&](const NetworkRecord<Real>& record) {
    return std::ranges::find(seeds, record.network.seed) != seeds.end();
  };
  std::vector<NetworkRecord<Real>> all = records(), read;
  std::ranges::copy_if(all, std::back_inserter(read), in_part);
  if (!read_checkpoint<Real>(checkpoint, description(part), read)) return false;
  for (auto from = read.begin(); NetworkRecord<Real> & record : all)
    if (in_part(record)) record = *from++;
  if (!possible(all)) throw ConfigError(checkpoint.string(), "checkpoint", "damaged", "whole; delete it to start anew");
  schedule_->restore(all);
  for (std::size_t i = 0; i < all.size(); ++i) {
    networks_[i] = all[i].network;
    if (validation_) validation_->best(i) = all[i].best;
    seconds_ = std::max(seconds_, networks_[i].seconds);
    if (stream_ != nullptr) block_ = std::max<std::uint64_t>(block_, networks_[i].cycles);
  }
  return true;
}

template class NetworkTraining<float>;
template class NetworkTraining<double>;

}  // namespace tactel::host
