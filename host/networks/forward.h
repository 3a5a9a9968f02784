// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "host/device/buffer.h"
#include "host/device/executor.h"
#include "host/networks/learning_inputs.h"
#include "nn/forward.h"
#include "nn/model.h"

namespace tactel::host {

/// Frames on a device: [rows, inputs] in MPa, normal stresses first. Cheap to copy.
class DeviceFrames {
 public:
  DeviceFrames(const Device& device, const nn::RowMatrix<float>& frames);
  std::uint32_t rows() const { return rows_; }
  int inputs() const { return inputs_; }
  const Buffer<float>& buffer() const { return buffer_; }

 private:
  std::uint32_t rows_;
  int inputs_;
  Buffer<float> buffer_;
};

/// Launcher of kernels/forward.cl for batches: networks of one topology and scaling on a device. The answer to a
/// frame does not depend on its batch, its position or the number of threads, and in fp32 equals that of
/// tactel::SlipEstimator.
template <class Real>
class Forward {
 public:
  /// `bounds`: of each network, for the bound of S instead of its quantiles; or none.
  Forward(Executor& executor, std::span<const nn::Weights<Real>> networks, const nn::InputScaling& scaling,
          std::span<const nn::Bound* const> bounds = {});

  /// Replaces a network by another of the same topology. Throws std::invalid_argument for another topology.
  void set_network(std::size_t network, const nn::Weights<Real>& weights);

  /// Evaluates every network on every frame. Throws ValueError for frames of another width.
  void run(const DeviceFrames& frames, const RunOptions& options = {});
  /// Returns the answers of a network in the last run.
  nn::Recall<Real> result(std::size_t network);
  /// The same; allocates nothing where `answer` has as many rows already.
  void read(std::size_t network, nn::Recall<Real>& answer);
  /// Runs the first network and returns its answers.
  nn::Recall<Real> recall(const nn::RowMatrix<float>& frames);

  std::size_t networks() const { return networks_; }

 private:
  Executor* executor_;
  nn::Topology topology_;
  std::size_t networks_, answers_;  ///< answers_: numbers of a frame
  int numbers_;                     ///< of an input
  std::uint32_t rows_ = 0;
  std::uint64_t bound_ = 0;  ///< frames that the launch has as its arguments: the id of their buffer
  std::vector<Real> read_;   ///< [answers_][rows] of one network
  Buffer<Real> weights_, bounds_, slip_index_;
  Buffer<std::uint8_t> status_;
  Launch launch_;
};

extern template class Forward<float>;
extern template class Forward<double>;

/// Returns the compile-time values of the kernels of a network.
Defines network_defines(const nn::Topology& topology, int lanes, Precision precision);

}  // namespace tactel::host
