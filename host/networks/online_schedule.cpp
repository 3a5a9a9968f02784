// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "host/device/unwritten.h"
#include "host/networks/training_schedule.h"

namespace tactel::host {
namespace {

constexpr double round_seconds = 0.5;          ///< aimed at: progress, checkpoints and Ctrl-C wait for a round
constexpr std::uint32_t longest_round = 1024;  ///< cycles; the kernel's curve buffer holds a round

template <class Real>
class OnlineSchedule : public TrainingSchedule<Real> {
 public:
  OnlineSchedule(Executor& executor, const TrainingPlan& plan, const std::vector<OnlineMember>& members)
      : executor_(executor), plan_(plan), members_(members) {}

  void take(const LearningInputs<Real>& inputs, double) override {
    rows_ = inputs.rows();
    for (const nn::Topology& topology : plan_.topologies)
      trainings_.emplace_back(executor_, topology, inputs, members_, plan_.options);
  }

  void run_round(std::vector<TrainedNetwork>& networks, const std::function<bool()>& go_on) override {
    RunOptions run{.progress = {}, .largest_chunk = 1};
    if (go_on) run.progress = [&](std::size_t, std::size_t) { return go_on(); };
    const RunReport report = executor_.run(jobs(), run);
    for (std::size_t i = 0; i < networks.size(); ++i)
      if (networks[i].running() && !collect(i, networks[i]) && !report.cancelled) refuse_unwritten(executor_.device());
    const double pace = round_seconds / std::max(report.seconds, 1e-3);
    round_cycles_ = std::clamp(static_cast<std::uint32_t>(round_cycles_ * std::min(pace, 4.0)), 1u, longest_round);
  }

  nn::Weights<Real> weights(std::size_t network) const override { return state(network).weights; }

  void store(std::size_t network, NetworkRecord<Real>& record) const override {
    nn::OnlineState<Real> learnt = state(network);
    record.state.weights = std::move(learnt.weights);
    record.state.first = std::move(learnt.step);
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
      trainings_[i / members_.size()].set_state(i % members_.size(), state);
    }
  }

 private:
  nn::OnlineState<Real> state(std::size_t network) const {
    return trainings_[network / members_.size()].state(network % members_.size());
  }

  // The largest networks first, so that the threads end together.
  std::vector<Job> jobs() {
    std::vector<TrainOnline<Real>*> order;
    for (TrainOnline<Real>& training : trainings_) order.push_back(&training);
    std::stable_sort(order.begin(), order.end(), [](const auto* a, const auto* b) {
      return a->topology().weight_count() > b->topology().weight_count();
    });
    std::vector<Job> jobs;
    jobs.reserve(order.size());
    for (TrainOnline<Real>* training : order) jobs.push_back(training->job(round_cycles_));
    return jobs;
  }

  // Reads what the last round did to a network. Returns whether it did anything.
  bool collect(std::size_t i, TrainedNetwork& network) {
    const TrainOnline<Real>& training = trainings_[i / members_.size()];
    const std::size_t place = i % members_.size();
    const OnlineReport from{0, network.cycles, 0, 0};
    const OnlineReport report = training.report(place);
    if (report.cycle == network.cycles) return false;
    const std::vector<nn::CycleErrors> errors = training.curve(place, from);
    network.status = static_cast<nn::TrainStatus>(report.status);
    for (const nn::CycleErrors& cycle : errors)
      network.note_cycle(cycle, rows_, network.cycles + 1 == report.cycle && !network.running());
    network.sse = report.sse;
    network.largest = report.largest;
    return true;
  }

  Executor& executor_;
  const TrainingPlan& plan_;
  std::vector<OnlineMember> members_;
  std::vector<TrainOnline<Real>> trainings_;  ///< [topologies]
  std::uint32_t rows_ = 0;                    ///< of a cycle
  std::uint32_t round_cycles_ = 4;
};

}  // namespace

template <class Real>
std::unique_ptr<TrainingSchedule<Real>> online_schedule(Executor& executor, const TrainingPlan& plan,
                                                        const std::vector<OnlineMember>& members) {
  return std::make_unique<OnlineSchedule<Real>>(executor, plan, members);
}

template std::unique_ptr<TrainingSchedule<float>> online_schedule(Executor&, const TrainingPlan&,
                                                                  const std::vector<OnlineMember>&);
template std::unique_ptr<TrainingSchedule<double>> online_schedule(Executor&, const TrainingPlan&,
                                                                   const std::vector<OnlineMember>&);

}  // namespace tactel::host
