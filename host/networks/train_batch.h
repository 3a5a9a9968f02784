// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "host/device/executor.h"
#include "host/networks/learning_inputs.h"
#include "host/networks/train_online.h"
#include "nn/train_batch.h"

namespace tactel::host {

/// Launcher of kernels/train_batch.cl: networks of one topology on a device, trained on mini-batches of variants
/// of one learning set. Batches of up to one slice run in one kernel, a work-item a network. Larger batches are
/// split into slices, network by network. Where there are group_items, kernels/train_group_batch.cl has a work-group a
/// network or slice, and slices of many networks go side by side. The training of a network depends on its seed, set
/// and options, not on the number of threads.
template <class Real>
class TrainBatch {
 public:
  static constexpr std::uint32_t slice = 128;  ///< patterns

  /// Throws ValueError for invalid options, or inputs of another width.
  TrainBatch(Executor& executor, const nn::Topology& topology, const LearningInputs<Real>& inputs,
             std::span<const OnlineMember> members, const nn::BatchOptions& options = {});

  /// Trains the next epoch of every network. Progress counts patterns. Returns the errors of each network.
  /// Returns none when cancelled; the networks are then as before the epoch.
  std::optional<std::vector<nn::CycleErrors>> train_epoch(const Progress& progress = {});

  std::size_t size() const { return members_.size(); }
  const nn::Topology& topology() const { return topology_; }
  nn::BatchState<Real> state(std::size_t network) const;
  /// Sets the state of a network. All networks must be set to the same epoch and number of updates.
  void set_state(std::size_t network, const nn::BatchState<Real>& state);

 private:
  std::size_t numbers() const;
  void prepare();
  void upload_order();
  std::vector<Real> factors(std::uint32_t first_batch, std::uint32_t batches) const;
  bool run_small_batches(const Progress& progress, std::vector<nn::CycleErrors>& errors);
  bool run_large_batches(const Progress& progress, std::vector<nn::CycleErrors>& errors);
  void unpack(const Buffer<Real>& from, std::size_t network, nn::Weights<Real>& to) const;
  void pack(const nn::Weights<Real>& from, std::size_t network, Buffer<Real>& to);

  Executor* executor_;
  nn::Topology topology_;
  nn::BatchOptions options_;
  LearningInputs<Real> inputs_;
  std::vector<OnlineMember> members_;
  int lanes_;
  std::size_t items_;                      ///< of a work-group; 1 where there is none
  std::size_t slices_ = 0;                 ///< of large batches, at once
  std::uint64_t updates_ = 0, shown_ = 0;  ///< until this epoch; rows
  std::uint32_t epoch_ = 0;
  Buffer<Real> weights_, first_, second_;  ///< [networks][numbers]
  Buffer<Real> mean_;                      ///< the same; one number where no mean is taken
  Buffer<Real> sums_;                      ///< [networks, or slices_][numbers]
  Buffer<Real> errors_;                    ///< [networks][batches of a launch][2] or [slices_][2]
  Buffer<Real> factors_;                   ///< [batches of a launch][4]
  Buffer<std::uint32_t> order_, set_of_;
  Launch learn_, update_;
};

extern template class TrainBatch<float>;
extern template class TrainBatch<double>;

}  // namespace tactel::host
