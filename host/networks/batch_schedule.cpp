// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "host/networks/train_batch.h"
#include "host/networks/training_schedule.h"

namespace tactel::host {
namespace {

using Clock = std::chrono::steady_clock;

// An epoch that can be broken off keeps a copy of all networks: not worth it for epochs shorter than this.
constexpr double long_epoch_seconds = 0.2;

template <class Real>
class BatchSchedule : public TrainingSchedule<Real> {
 public:
  BatchSchedule(Executor& executor, const LearningInputs<Real>& inputs, const TrainingMembers& members,
                const nn::BatchOptions& options, const nn::OnlineOptions& limits)
      : executor_(executor), inputs_(inputs), members_(members), options_(options), limits_(limits) {
    for (std::size_t network = 0; network < members.size(); ++network) {
      states_.emplace_back(nn::initial_weights(topology_of(network), member_of(network).seed));
      stopped_.push_back(false);
      if (network % members.members.size() == 0) families_.push_back({});
      families_.back().networks.push_back(network);
    }
    for (Family& family : families_) gather(family);
  }

  void run_round(std::vector<TrainedNetwork>& networks, const std::function<bool()>& go_on) override {
    for (Family& family : families_) {
      if (!family.training) continue;
      if (!run_epoch(family, networks, go_on)) return;
    }
  }

  nn::Weights<Real> weights(std::size_t network) const override { return state(network).weights; }

  void store(std::size_t network, NetworkRecord<Real>& record) const override { record.state = state(network); }

  void restore(std::span<const NetworkRecord<Real>> records) override {
    for (Family& family : families_) family.networks.clear();
    for (std::size_t i = 0; i < records.size(); ++i) {
      nn::BatchState<Real>& state = states_[i];
      state = records[i].state;
      state.epoch = records[i].network.cycles;
      state.updates = std::uint64_t{state.epoch} * updates_of_an_epoch();
      stopped_[i] = records[i].network.status != nn::TrainStatus::running;
      if (!stopped_[i]) families_[i / members_.members.size()].networks.push_back(i);
    }
    for (Family& family : families_) gather(family);
  }

 private:
  /// Networks of one topology. Those that run are at the same epoch.
  struct Family {
    std::vector<std::size_t> networks{};         ///< on the device
    std::optional<TrainBatch<Real>> training{};  ///< of those; none when all have stopped
    double epoch_seconds = 0;                    ///< of the last one
  };

  const nn::Topology& topology_of(std::size_t network) const {
    return members_.topologies[network / members_.members.size()];
  }
  const OnlineMember& member_of(std::size_t network) const {
    return members_.members[network % members_.members.size()];
  }
  std::uint64_t updates_of_an_epoch() const {
    const auto batch = static_cast<std::uint64_t>(options_.batch);
    return (inputs_.rows() + batch - 1) / batch;
  }

  // Puts the family's networks on the device.
  void gather(Family& family) {
    family.training.reset();
    if (family.networks.empty()) return;
    std::vector<OnlineMember> members;
    for (const std::size_t network : family.networks) members.push_back(member_of(network));
    family.training.emplace(executor_, topology_of(family.networks[0]), inputs_, members, options_);
    for (std::size_t i = 0; i < members.size(); ++i) family.training->set_state(i, states_[family.networks[i]]);
  }

  nn::BatchState<Real> state(std::size_t network) const {
    if (stopped_[network]) return states_[network];
    const Family& family = families_[network / members_.members.size()];
    const auto found = std::ranges::find(family.networks, network);
    return family.training->state(static_cast<std::size_t>(found - family.networks.begin()));
  }

  bool run_epoch(Family& family, std::vector<TrainedNetwork>& networks, const std::function<bool()>& go_on) {
    const auto start = Clock::now();
    Progress progress;
    if (go_on && family.epoch_seconds > long_epoch_seconds)
      progress = [&](std::size_t, std::size_t) { return go_on(); };
    const auto errors = family.training->train_epoch(progress);
    family.epoch_seconds = std::chrono::duration<double>(Clock::now() - start).count();
    if (!errors) return false;
    for (std::size_t i = 0; i < family.networks.size(); ++i) {
      const std::size_t network = family.networks[i];
      if (stopped_[network] || !note_epoch(networks[network], (*errors)[i])) continue;
      states_[network] = family.training->state(i);
      stopped_[network] = true;
    }
    shrink(family);
    return true;
  }

  // Returns whether it was the network's last.
  bool note_epoch(TrainedNetwork& network, const nn::CycleErrors& errors) const {
    const auto epoch = static_cast<int>(network.cycles) + 1;
    if (!std::isfinite(errors.sse) || !std::isfinite(errors.largest))
      network.status = nn::TrainStatus::not_finite;
    else if (errors.largest < limits_.stop_error)
      network.status = nn::TrainStatus::learnt;
    else if (epoch >= limits_.cycles(network.topology))
      network.status = nn::TrainStatus::cycle_limit;
    const bool last = network.status != nn::TrainStatus::running;
    note_cycle(network, errors, last);
    return last;
  }

  // Takes stopped networks off the device once they are half of those there: doing so costs more than some epochs.
  void shrink(Family& family) {
    const auto stopped = std::ranges::count_if(family.networks, [&](std::size_t network) { return stopped_[network]; });
    if (2 * static_cast<std::size_t>(stopped) < family.networks.size()) return;
    for (std::size_t i = 0; i < family.networks.size(); ++i)
      if (!stopped_[family.networks[i]]) states_[family.networks[i]] = family.training->state(i);
    std::erase_if(family.networks, [&](std::size_t network) { return stopped_[network]; });
    gather(family);
  }

  Executor& executor_;
  LearningInputs<Real> inputs_;
  TrainingMembers members_;
  nn::BatchOptions options_;
  nn::OnlineOptions limits_;
  std::vector<Family> families_;              ///< [topologies]
  std::vector<bool> stopped_;                 ///< [networks]
  std::vector<nn::BatchState<Real>> states_;  ///< [networks] of stopped ones; others' are on the device
};

}  // namespace

template <class Real>
std::unique_ptr<TrainingSchedule<Real>> batch_schedule(Executor& executor, const LearningInputs<Real>& inputs,
                                                       const TrainingMembers& members, const nn::BatchOptions& options,
                                                       const nn::OnlineOptions& limits) {
  return std::make_unique<BatchSchedule<Real>>(executor, inputs, members, options, limits);
}

template std::unique_ptr<TrainingSchedule<float>> batch_schedule(Executor&, const LearningInputs<float>&,
                                                                 const TrainingMembers&, const nn::BatchOptions&,
                                                                 const nn::OnlineOptions&);
template std::unique_ptr<TrainingSchedule<double>> batch_schedule(Executor&, const LearningInputs<double>&,
                                                                  const TrainingMembers&, const nn::BatchOptions&,
                                                                  const nn::OnlineOptions&);

}  // namespace tactel::host
