// SPDX-License-Identifier: Apache-2.0
#include "host/networks/forward.h"

#include <limits>
#include <stdexcept>

#include "fem/value_error.h"
#include "kernels/shared/frame_status.h"
#include "kernels/shared/network_work.h"

namespace tactel::host {
namespace {

static_assert(int(nn::FrameStatus::ok) == FRAME_OK && int(nn::FrameStatus::no_stress) == FRAME_NO_STRESS);
static_assert(int(nn::FrameStatus::not_finite) == FRAME_NOT_FINITE && int(nn::FrameStatus::overflow) == FRAME_OVERFLOW);
static_assert(nn::InputScaling::smallest_stress == SMALLEST_STRESS);
static_assert(nn::InputScaling::large_stress == LARGE_STRESS && nn::InputScaling::large_scale == LARGE_SCALE);

void check_width(const nn::Topology& topology, std::size_t inputs) {
  if (inputs != static_cast<std::size_t>(topology.inputs()))
    throw ValueError("inputs", std::to_string(inputs) + " a frame",
                     std::to_string(topology.inputs()) + " for the network " + topology.text());
}

template <class Real>
Real factor_of(const nn::InputScaling& scaling) {
  return Real(1) / static_cast<Real>(scaling.largest_stress);
}

template <class Real>
const nn::Topology& common_topology(std::span<const nn::Weights<Real>> networks) {
  if (networks.empty()) throw std::invalid_argument("no networks");
  for (const auto& network : networks)
    if (network.topology != networks[0].topology) throw std::invalid_argument("networks of different topologies");
  return networks[0].topology;
}

/// network_defines, and the normal stresses of the newest frame where they are not half of the input.
Defines forward_defines(const nn::Topology& topology, const nn::InputScaling& scaling, int lanes, Precision precision) {
  Defines defines = network_defines(topology, lanes, precision);
  if (topology.inputs() % (scaling.axes * scaling.history) != 0)
    throw ValueError("history", std::to_string(scaling.history),
                     "frames of equal width in the network " + topology.text());
  if (scaling.history > 1 || scaling.axes != 2)
    defines.push_back({"NORMALS", std::to_string(scaling.normals(topology.inputs()))});
  return defines;
}

}  // namespace

Defines network_defines(const nn::Topology& topology, int lanes, Precision precision) {
  const auto& widths = topology.widths();
  return {{"LANES", std::to_string(lanes)},
          {"REAL", real_type(precision)},
          {"INPUTS", std::to_string(widths[0])},
          {"HIDDEN1", std::to_string(widths[1])},
          {"HIDDEN2", std::to_string(topology.hidden_layers() > 1 ? widths[2] : 0)},
          {"OUTPUTS", std::to_string(topology.outputs())},
          {"LEAKY_RELU", topology.hidden_activation() == nn::Activation::leaky_relu ? "1" : "0"}};
}

DeviceFrames::DeviceFrames(const Device& device, const nn::RowMatrix<float>& frames)
    : rows_(static_cast<std::uint32_t>(frames.rows())),
      inputs_(static_cast<int>(frames.cols())),
      buffer_(device, std::span<const float>(frames.data(), static_cast<std::size_t>(frames.size()))) {
  if (frames.rows() >= std::int64_t{1} << 31)
    throw ValueError("inputs", std::to_string(frames.rows()) + " rows", "fewer than 2^31 rows");
}

template <class Real>
Forward<Real>::Forward(Executor& executor, std::span<const nn::Weights<Real>> networks, const nn::InputScaling& scaling)
    : executor_(&executor), topology_(common_topology(networks)), networks_(networks.size()) {
  scaling.validate();
  const Device& device = executor.device();
  std::vector<Real> all;
  for (const auto& network : networks) all.insert(all.end(), network.values.begin(), network.values.end());
  weights_ = Buffer<Real>(device, std::span<const Real>(all));
  const Buffer<float> no_frames(device, 1);
  slip_index_ = Buffer<Real>(device, 1);
  status_ = Buffer<std::uint8_t>(device, 1);
  const Program program(device, "forward.cl",
                        forward_defines(topology_, scaling, device.lanes(precision_of<Real>), precision_of<Real>));
  launch_ = executor.prepare(program, "forward", [&](KernelArguments& kernel) {
    kernel.set("weights", weights_);
    kernel.set("frames", no_frames);
    kernel.set("slip_index", slip_index_);
    kernel.set("status", status_);
    kernel.set("rows", std::uint32_t{1});
    kernel.set("tiles", std::uint32_t{1});
    kernel.set("by_frame", std::int32_t{scaling.kind == nn::ScalingKind::frame});
    kernel.set("factor", factor_of<Real>(scaling));
  });
}

template <class Real>
void Forward<Real>::set_network(std::size_t network, const nn::Weights<Real>& weights) {
  if (weights.topology != topology_) throw std::invalid_argument("a network of another topology");
  weights_.write(weights.values, network * weights.values.size());
}

template <class Real>
void Forward<Real>::run(const DeviceFrames& frames, const RunOptions& options) {
  check_width(topology_, static_cast<std::size_t>(frames.inputs()));
  const std::uint32_t tile = FRAME_VECTORS * static_cast<std::uint32_t>(executor_->device().lanes(precision_of<Real>));
  const std::uint32_t tiles = (frames.rows() + tile - 1) / tile;
  const std::size_t numbers = networks_ * topology_.outputs() * frames.rows();
  if (numbers > slip_index_.size()) {
    slip_index_ = Buffer<Real>(executor_->device(), numbers);
    status_ = Buffer<std::uint8_t>(executor_->device(), networks_ * frames.rows());
    bound_ = 0;
  }
  if (bound_ != frames.buffer().id()) {  // arguments take a part of a microsecond
    bound_ = 0;
    rows_ = frames.rows();
    launch_.bind([&](KernelArguments& kernel) {
      kernel.set("frames", frames.buffer());
      kernel.set("slip_index", slip_index_);
      kernel.set("status", status_);
      kernel.set("rows", std::uint32_t{rows_});
      kernel.set("tiles", std::uint32_t{tiles});
    });
    bound_ = frames.buffer().id();
  }
  if (networks_ * tiles == 1 && !options.progress) return executor_->run_here(launch_);
  RunOptions equal = options;
  equal.equal_groups = true;
  executor_->run(launch_, networks_ * tiles, equal);
}

template <class Real>
nn::Recall<Real> Forward<Real>::result(std::size_t network) const {
  nn::Recall<Real> answer{nn::Vector<Real>(rows_), std::vector<nn::FrameStatus>(rows_), {}, {}};
  const auto read = [&](nn::Vector<Real>& to, std::size_t output) {
    to.resize(rows_);
    slip_index_.read(std::span<Real>(to.data(), rows_), (network * topology_.outputs() + output) * rows_);
  };
  read(answer.slip_index, 0);
  if (topology_.has_bound()) read(answer.upper, 1), read(answer.lower, 2);
  status_.read(std::span(reinterpret_cast<std::uint8_t*>(answer.status.data()), rows_), network * rows_);
  return answer;
}

template <class Real>
nn::Recall<Real> Forward<Real>::recall(const nn::RowMatrix<float>& frames) {
  run(DeviceFrames(executor_->device(), frames));
  return result(0);
}

template class Forward<float>;
template class Forward<double>;

}  // namespace tactel::host
