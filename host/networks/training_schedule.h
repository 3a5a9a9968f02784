// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "host/networks/learning_inputs.h"
#include "host/networks/network_training.h"
#include "host/networks/train_online.h"
#include "host/networks/training_checkpoint.h"

namespace tactel::host {

/// Networks of a schedule: for every topology, these members.
struct TrainingMembers {
  std::vector<nn::Topology> topologies;
  std::vector<OnlineMember> members;  ///< of each topology
  std::size_t size() const { return topologies.size() * members.size(); }
};

/// Training of the networks of a NetworkTraining. Networks are numbered [topologies][members].
template <class Real>
class TrainingSchedule {
 public:
  virtual ~TrainingSchedule() = default;
  /// Trains some cycles of every running network and records the result in `networks`. Calls `go_on`
  /// repeatedly; false ends the round early.
  virtual void run_round(std::vector<TrainedNetwork>& networks, const std::function<bool()>& go_on) = 0;
  virtual nn::Weights<Real> weights(std::size_t network) const = 0;
  /// Fills in the numbers of a record of a known network.
  virtual void store(std::size_t network, NetworkRecord<Real>& record) const = 0;
  /// Restores all networks from records.
  virtual void restore(std::span<const NetworkRecord<Real>> records) = 0;
};

/// Returns a schedule that trains pattern by pattern (train_online.h).
template <class Real>
std::unique_ptr<TrainingSchedule<Real>> online_schedule(Executor& executor, const LearningInputs<Real>& inputs,
                                                        const TrainingMembers& members,
                                                        const nn::OnlineOptions& options);
/// Returns a schedule of mini-batches (train_batch.h). Of `limits` it uses stop_error and the limit of cycles.
template <class Real>
std::unique_ptr<TrainingSchedule<Real>> batch_schedule(Executor& executor, const LearningInputs<Real>& inputs,
                                                       const TrainingMembers& members, const nn::BatchOptions& options,
                                                       const nn::OnlineOptions& limits);

/// Records one more cycle of a network. Its curve keeps the first ten cycles, then cycles a tenth apart, and the
/// last.
void note_cycle(TrainedNetwork& network, const nn::CycleErrors& errors, bool last);

extern template std::unique_ptr<TrainingSchedule<float>> online_schedule(Executor&, const LearningInputs<float>&,
                                                                         const TrainingMembers&,
                                                                         const nn::OnlineOptions&);
extern template std::unique_ptr<TrainingSchedule<double>> online_schedule(Executor&, const LearningInputs<double>&,
                                                                          const TrainingMembers&,
                                                                          const nn::OnlineOptions&);
extern template std::unique_ptr<TrainingSchedule<float>> batch_schedule(Executor&, const LearningInputs<float>&,
                                                                        const TrainingMembers&, const nn::BatchOptions&,
                                                                        const nn::OnlineOptions&);
extern template std::unique_ptr<TrainingSchedule<double>> batch_schedule(Executor&, const LearningInputs<double>&,
                                                                         const TrainingMembers&,
                                                                         const nn::BatchOptions&,
                                                                         const nn::OnlineOptions&);

}  // namespace tactel::host
