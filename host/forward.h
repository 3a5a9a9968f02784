#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "host/buffer.h"
#include "host/executor.h"
#include "host/learning_inputs.h"
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

/// Host side of kernels/forward.cl for batches: networks of one topology and scaling on a device. What a frame yields
/// does not depend on its batch, its place or the number of threads, and is what ForwardOne yields.
template <class Real>
class Forward {
 public:
  Forward(Executor& executor, std::span<const nn::Weights<Real>> networks, const nn::InputScaling& scaling);

  /// Another network of the same topology in the place of one. Throws std::invalid_argument for another topology.
  void set_network(std::size_t network, const nn::Weights<Real>& weights);

  /// Every network on every frame. Throws ValueError for frames of another width.
  void run(const DeviceFrames& frames, const RunOptions& options = {});
  /// What the last run found for a network.
  nn::Recall<Real> result(std::size_t network) const;
  /// Both, for the first network.
  nn::Recall<Real> recall(const nn::RowMatrix<float>& frames);

  std::size_t networks() const { return networks_; }

 private:
  Executor* executor_;
  nn::Topology topology_;
  std::size_t networks_;
  std::uint32_t rows_ = 0;
  Buffer<Real> weights_, slip_index_;
  Buffer<std::uint8_t> status_;
  Launch launch_;
};

/// S of one frame.
template <class Real>
struct FrameAnswer {
  Real slip_index = 0;  ///< 0..1; NaN where the status says that there is none
  nn::FrameStatus status = nn::FrameStatus::ok;
};

/// One frame at a time, by the shortest way: in the calling thread, about a microsecond on PoCL's `basic`, copies
/// included.
template <class Real>
class ForwardOne {
 public:
  ForwardOne(Executor& executor, const nn::Weights<Real>& weights, const nn::InputScaling& scaling);
  /// frame: [inputs] MPa, normal stresses first. Throws ValueError for another width. One thread at a time.
  FrameAnswer<Real> operator()(std::span<const float> frame);

 private:
  Executor* executor_;
  nn::Topology topology_;
  std::vector<Real> frame_;  ///< scratch, [inputs]
  Buffer<Real> all_;         ///< answer, scaling, frame and weights (kernels/shared/one_frame.h)
  Launch launch_;
};

extern template class Forward<float>;
extern template class Forward<double>;
extern template class ForwardOne<float>;
extern template class ForwardOne<double>;

/// The compile-time values of a network's kernels.
Defines network_defines(const nn::Topology& topology, int lanes, Precision precision);

}  // namespace tactel::host
