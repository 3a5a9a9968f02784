// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>

#include "host/networks/training_schedule.h"

namespace tactel::host {
namespace {

constexpr double round_seconds = 0.5;          ///< aimed at: progress, checkpoints and Ctrl-C wait for a round
constexpr std::uint32_t longest_round = 1024;  ///< cycles; the kernel's curve buffer holds a round

template <class Real>
class OnlineSchedule : public TrainingSchedule<Real> {
 public:
  OnlineSchedule(Executor& executor, const LearningInputs<Real>& inputs, const TrainingMembers& members,
                 const nn::OnlineOptions& options)
      : executor_(executor), per_topology_(members.members.size()) {
    for (const nn::Topology& topology : members.topologies)
      trainings_.emplace_back(executor, topology, inputs, members.members, options);
  }

  void run_round(std::vector<TrainedNetwork>& networks, const std::function<bool()>& go_on) override {
    RunOptions run{.progress = {}, .largest_chunk = 1};
    if (go_on) run.progress = [&](std::size_t, std::size_t) { return go_on(); };
    const double seconds = executor_.run(jobs(), run).seconds;
    for (std::size_t i = 0; i < networks.size(); ++i)
      if (networks[i].status == nn::TrainStatus::running) collect(i, networks[i]);
    const double pace = round_seconds / std::max(seconds, 1e-3);
    round_cycles_ = std::clamp(static_cast<std::uint32_t>(round_cycles_ * std::min(pace, 4.0)), 1u, longest_round);
  }

  nn::Weights<Real> weights(std::size_t network) const override { return state(network).weights; }

  void store(std::size_t network, NetworkRecord<Real>& record) const override {
    nn::OnlineState<Real> now = state(network);
    record.state.weights = std::move(now.weights);
    record.state.first = std::move(now.step);
    record.state.second.values.clear();
  }

  void restore(std::span<const NetworkRecord<Real>> records) override {
    for (std::size_t i = 0; i < records.size(); ++i) {
      const NetworkRecord<Real>& record = records[i];
      nn::OnlineState<Real> state{nn::Weights<float>(record.network.topology)};
      state.weights = record.state.weights;
      state.step = record.state.first;
      state.cycle = record.network.cycles;
      state.status = record.network.status;
      trainings_[i / per_topology_].set_state(i % per_topology_, state);
    }
  }

 private:
  nn::OnlineState<Real> state(std::size_t network) const {
    return trainings_[network / per_topology_].state(network % per_topology_);
  }

  // The largest networks first, so that the threads end together.
  std::vector<Job> jobs() {
    std::vector<TrainOnline<Real>*> order;
    for (TrainOnline<Real>& training : trainings_) order.push_back(&training);
    std::stable_sort(order.begin(), order.end(), [](const auto* a, const auto* b) {
      return a->topology().weight_count() > b->topology().weight_count();
    });
    std::vector<Job> jobs;
    for (TrainOnline<Real>* training : order) jobs.push_back(training->job(round_cycles_));
    return jobs;
  }

  // Reads what the last round did to a network.
  void collect(std::size_t i, TrainedNetwork& network) {
    const TrainOnline<Real>& training = trainings_[i / per_topology_];
    const std::size_t place = i % per_topology_;
    const OnlineReport from{0, network.cycles, 0, 0};
    const OnlineReport now = training.report(place);
    if (now.cycle == network.cycles) return;
    const std::vector<nn::CycleErrors> errors = training.curve(place, from);
    network.status = static_cast<nn::TrainStatus>(now.status);
    for (const nn::CycleErrors& cycle : errors)
      note_cycle(network, cycle, network.cycles + 1 == now.cycle && network.status != nn::TrainStatus::running);
    network.sse = now.sse;
    network.largest = now.largest;
  }

  Executor& executor_;
  std::size_t per_topology_;
  std::vector<TrainOnline<Real>> trainings_;  ///< [topologies]
  std::uint32_t round_cycles_ = 4;
};

}  // namespace

template <class Real>
std::unique_ptr<TrainingSchedule<Real>> online_schedule(Executor& executor, const LearningInputs<Real>& inputs,
                                                        const TrainingMembers& members,
                                                        const nn::OnlineOptions& options) {
  return std::make_unique<OnlineSchedule<Real>>(executor, inputs, members, options);
}

template std::unique_ptr<TrainingSchedule<float>> online_schedule(Executor&, const LearningInputs<float>&,
                                                                  const TrainingMembers&, const nn::OnlineOptions&);
template std::unique_ptr<TrainingSchedule<double>> online_schedule(Executor&, const LearningInputs<double>&,
                                                                   const TrainingMembers&, const nn::OnlineOptions&);

}  // namespace tactel::host
