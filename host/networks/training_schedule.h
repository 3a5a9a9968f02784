// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "host/networks/learning_inputs.h"
#include "host/networks/train_online.h"
#include "host/networks/training_checkpoint.h"
#include "host/networks/training_plan.h"

namespace tactel::host {

/// Training of the networks of a NetworkTraining. Networks are numbered [topologies][members].
template <class Real>
class TrainingSchedule {
 public:
  virtual ~TrainingSchedule() = default;
  /// Takes the rows of the next cycles, and the share of the learning rate that they are learnt at.
  virtual void take(const LearningInputs<Real>& inputs, double share_of_rate) = 0;
  /// Trains some cycles of every running network and records the result in `networks`. Calls `go_on`
  /// repeatedly; false ends the round early.
  virtual void run_round(std::vector<TrainedNetwork>& networks, const std::function<bool()>& go_on) = 0;
  /// Trains a network no more, whose status says why. Pattern by pattern there is no such reason.
  virtual void stop(std::size_t) {}
  virtual nn::Weights<Real> weights(std::size_t network) const = 0;
  /// Fills in the numbers of a record of a known network.
  virtual void store(std::size_t network, NetworkRecord<Real>& record) const = 0;
  /// Restores all networks from records.
  virtual void restore(std::span<const NetworkRecord<Real>> records) = 0;
};

/// Returns a schedule of a plan: pattern by pattern (train_online.h), which takes rows once, or by mini-batches
/// (train_batch.h). `members`: of each topology.
template <class Real>
std::unique_ptr<TrainingSchedule<Real>> online_schedule(Executor& executor, const TrainingPlan& plan,
                                                        const std::vector<OnlineMember>& members);
template <class Real>
std::unique_ptr<TrainingSchedule<Real>> batch_schedule(Executor& executor, const TrainingPlan& plan,
                                                       const std::vector<OnlineMember>& members);

}  // namespace tactel::host
