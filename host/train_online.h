#pragma once
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "host/executor.h"
#include "host/learning_inputs.h"
#include "kernels/shared/online_report.h"
#include "nn/train_online.h"

namespace tactel::host {

/// What tells networks of one topology apart.
struct OnlineMember {
  std::uint64_t seed = 0;     ///< of initial weights and of the order of patterns
  std::uint32_t variant = 0;  ///< of the learning set
};

/// Host side of kernels/train_online.cl: networks of one topology on a device, each trained pattern by pattern on a
/// variant of one learning set. Each network's course depends on its own seed and set alone, and not on how training is
/// cut into runs.
template <class Real>
class TrainOnline {
 public:
  /// Throws ValueError for options that cannot work, or inputs of another width.
  TrainOnline(Executor& executor, const nn::Topology& topology, const LearningInputs<Real>& inputs,
              std::span<const OnlineMember> members, const nn::OnlineOptions& options = {});

  /// The next `most_cycles` cycles of every network that is still running, for Executor::run. Jobs of several trainings
  /// may share a run; this training's next job only after its run.
  Job job(std::uint32_t most_cycles);
  /// The same, done at once.
  RunReport run(std::uint32_t most_cycles, const RunOptions& options = {});

  std::size_t size() const { return members_.size(); }
  const nn::Topology& topology() const { return topology_; }
  std::uint32_t cycle_limit() const;
  std::vector<OnlineReport> reports() const;  ///< [networks]
  OnlineReport report(std::size_t network) const;
  /// Errors of the cycles that the last run added to a network; `from` is the network's report before that run.
  std::vector<nn::CycleErrors> curve(std::size_t network, const OnlineReport& from) const;

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
