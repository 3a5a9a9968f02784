// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "host/device/executor.h"
#include "host/networks/learning_inputs.h"
#include "kernels/shared/online_report.h"
#include "nn/train_online.h"

namespace tactel::host {

/// Data in which networks of one topology differ.
struct OnlineMember {
  std::uint64_t seed = 0;     ///< of initial weights and of the order of patterns
  std::uint32_t variant = 0;  ///< of the learning set
};

/// Returns the items of a work-group of a GPU that holds a network of this topology, of up to 127 inputs and 128 hidden
/// neurons, in its registers; else 1.
std::size_t group_items(const Device& device, const nn::Topology& topology);

/// Launcher of kernels/train_online.cl: networks of one topology on a device, each trained pattern by pattern on
/// a variant of one learning set; where there are group_items, of kernels/train_group.cl. The
/// training of a network depends on its own seed and set alone, not on the division into runs.
template <class Real>
class TrainOnline {
 public:
  /// Throws ValueError for invalid options, or inputs of another width.
  TrainOnline(Executor& executor, const nn::Topology& topology, const LearningInputs<Real>& inputs,
              std::span<const OnlineMember> members, const nn::OnlineOptions& options = {});

  /// Returns a job for Executor::run: the next `most_cycles` cycles of every running network. Jobs of several
  /// trainings may share a run. The next job of a training requires the run of the previous one.
  Job job(std::uint32_t most_cycles);
  /// Creates and runs such a job.
  RunReport run(std::uint32_t most_cycles, const RunOptions& options = {});

  std::size_t size() const { return members_.size(); }
  const nn::Topology& topology() const { return topology_; }
  std::uint32_t cycle_limit() const;
  std::vector<OnlineReport> reports() const;  ///< [networks]
  OnlineReport report(std::size_t network) const;
  /// Returns the errors of the cycles that the last run added to a network. `from` is the report of the network
  /// before that run.
  std::vector<nn::CycleErrors> curve(std::size_t network, const OnlineReport& from) const;

  /// Throws DeviceError where a driver has left the weights unwritten, as Mesa's rusticl does.
  nn::OnlineState<Real> state(std::size_t network) const;
  void set_state(std::size_t network, const nn::OnlineState<Real>& state);

 private:
  Launch& launch(std::size_t together);
  std::vector<std::uint32_t> running() const;

  Executor* executor_;
  nn::Topology topology_;
  nn::OnlineOptions options_;
  LearningInputs<Real> inputs_;
  std::vector<OnlineMember> members_;
  std::size_t together_;          ///< networks in the lanes of a group, when there are many
  std::size_t group_items_;       ///< of a work-group that trains a network; 1: an item trains several
  Buffer<Real> weights_;          ///< [networks][weights, steps], each as nn::Weights
  Buffer<OnlineReport> reports_;  ///< [networks]
  Buffer<Real> curve_;            ///< [networks][cycles of the last run][2]
  Buffer<Real> vectors_;          ///< scratch
  Buffer<std::uint32_t> order_, slots_, set_of_;
  Buffer<std::uint64_t> seeds_;
  std::uint32_t curve_cycles_ = 0;
  std::map<std::size_t, Launch> launches_;  ///< by networks in the lanes of a group
};

extern template class TrainOnline<float>;
extern template class TrainOnline<double>;

}  // namespace tactel::host
