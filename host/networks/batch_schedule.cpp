// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>

#include "host/networks/train_batch.h"
#include "host/networks/training_schedule.h"
#include "host/support/seconds.h"

namespace tactel::host {
namespace {

// An epoch that can be broken off keeps a copy of all networks: not worth it for epochs shorter than this.
constexpr double long_epoch_seconds = 0.2;

template <class Real>
class BatchSchedule : public TrainingSchedule<Real> {
 public:
  BatchSchedule(Executor& executor, const TrainingPlan& plan, const std::vector<OnlineMember>& members)
      : executor_(executor), plan_(plan), members_(members), families_(plan.topologies.size()) {
    for (std::size_t network = 0; network < plan.topologies.size() * members.size(); ++network) {
      states_.emplace_back(nn::initial_weights(topology_of(network), member_of(network).seed));
      stopped_.push_back(false);
      families_[network / members.size()].networks.push_back(network);
    }
  }

  void take(const LearningInputs<Real>& inputs, double share_of_rate) override {
    for (Family& family : families_) keep_states(family);
    inputs_ = inputs;
    options_ = *plan_.batch;
    options_.rate *= share_of_rate;
    for (Family& family : families_) gather(family);
  }

  void run_round(std::vector<TrainedNetwork>& networks, const std::function<bool()>& go_on) override {
    for (Family& family : families_) {
      if (!family.training) continue;
      if (!run_epoch(family, networks, go_on)) return;
    }
  }

  void stop(std::size_t network) override {
    retire(network);
    shrink(families_[network / members_.size()]);
  }

  nn::Weights<Real> weights(std::size_t network) const override { return state(network).result(); }

  void store(std::size_t network, NetworkRecord<Real>& record) const override { record.state = state(network); }

  void restore(std::span<const NetworkRecord<Real>> records) override {
    for (Family& family : families_) family.networks.clear();
    for (std::size_t i = 0; i < records.size(); ++i) {
      states_[i] = records[i].state;
      stopped_[i] = !records[i].network.running();
      if (!stopped_[i]) families_[i / members_.size()].networks.push_back(i);
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

  const nn::Topology& topology_of(std::size_t network) const { return plan_.topologies[network / members_.size()]; }
  const OnlineMember& member_of(std::size_t network) const { return members_[network % members_.size()]; }

  // Puts the family's networks on the device, once there are rows.
  void gather(Family& family) {
    family.training.reset();
    if (family.networks.empty() || !inputs_) return;
    std::vector<OnlineMember> members;
    for (const std::size_t network : family.networks) members.push_back(member_of(network));
    nn::BatchOptions options = options_;
    const nn::Topology& topology = topology_of(family.networks[0]);
    options.planned_rows =
        plan_.rows.value_or(static_cast<std::uint64_t>(plan_.options.cycles(topology)) * inputs_->rows());
    family.training.emplace(executor_, topology, *inputs_, members, options);
    for (std::size_t i = 0; i < members.size(); ++i) family.training->set_state(i, states_[family.networks[i]]);
  }

  // Takes the states of its running networks off the device, and leaves those alone there.
  void keep_states(Family& family) {
    for (std::size_t i = 0; family.training && i < family.networks.size(); ++i)
      if (!stopped_[family.networks[i]]) states_[family.networks[i]] = family.training->state(i);
    std::erase_if(family.networks, [&](std::size_t network) { return stopped_[network]; });
  }

  nn::BatchState<Real> state(std::size_t network) const {
    const Family& family = families_[network / members_.size()];
    if (stopped_[network] || !family.training) return states_[network];
    const auto found = std::ranges::find(family.networks, network);
    return family.training->state(static_cast<std::size_t>(found - family.networks.begin()));
  }

  bool run_epoch(Family& family, std::vector<TrainedNetwork>& networks, const std::function<bool()>& go_on) {
    const auto start = Clock::now();
    Progress progress;
    if (go_on && family.epoch_seconds > long_epoch_seconds)
      progress = [&](std::size_t, std::size_t) { return go_on(); };
    const auto errors = family.training->train_epoch(progress);
    family.epoch_seconds = seconds_since(start);
    if (!errors) return false;
    for (std::size_t i = 0; i < family.networks.size(); ++i) {
      const std::size_t network = family.networks[i];
      if (stopped_[network] || !note_epoch(networks[network], (*errors)[i])) continue;
      retire(network);
    }
    shrink(family);
    return true;
  }

  void retire(std::size_t network) {
    states_[network] = state(network);
    stopped_[network] = true;
  }

  // Returns whether it was the network's last.
  bool note_epoch(TrainedNetwork& network, const nn::CycleErrors& errors) const {
    if (!std::isfinite(errors.sse) || !std::isfinite(errors.largest))
      network.status = nn::TrainStatus::not_finite;
    else if (!plan_.rows && errors.largest < plan_.options.stop_error)
      network.status = nn::TrainStatus::learnt;
    else if (plan_.over(network.topology, network.cycles + 1, network.rows + inputs_->rows()))
      network.status = nn::TrainStatus::cycle_limit;
    network.note_cycle(errors, inputs_->rows(), !network.running());
    return !network.running();
  }

  // Takes stopped networks off the device once they are half of those there: doing so costs more than some epochs.
  void shrink(Family& family) {
    const auto stopped = std::ranges::count_if(family.networks, [&](std::size_t network) { return stopped_[network]; });
    if (2 * static_cast<std::size_t>(stopped) < family.networks.size()) return;
    keep_states(family);
    gather(family);
  }

  Executor& executor_;
  const TrainingPlan& plan_;
  std::vector<OnlineMember> members_;
  std::optional<LearningInputs<Real>> inputs_{};
  nn::BatchOptions options_{};                ///< with the rate of the rows taken
  std::vector<Family> families_;              ///< [topologies]
  std::vector<bool> stopped_;                 ///< [networks]
  std::vector<nn::BatchState<Real>> states_;  ///< [networks] of stopped ones; others' are on the device
};

}  // namespace

template <class Real>
std::unique_ptr<TrainingSchedule<Real>> batch_schedule(Executor& executor, const TrainingPlan& plan,
                                                       const std::vector<OnlineMember>& members) {
  return std::make_unique<BatchSchedule<Real>>(executor, plan, members);
}

template std::unique_ptr<TrainingSchedule<float>> batch_schedule(Executor&, const TrainingPlan&,
                                                                 const std::vector<OnlineMember>&);
template std::unique_ptr<TrainingSchedule<double>> batch_schedule(Executor&, const TrainingPlan&,
                                                                  const std::vector<OnlineMember>&);

}  // namespace tactel::host
