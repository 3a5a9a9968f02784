// SPDX-License-Identifier: Apache-2.0
#include "host/networks/forward.h"

#include <algorithm>
#include <stdexcept>

#include "fem/numbers/value_error.h"
#include "host/device/unwritten.h"
#include "kernels/shared/frame_status.h"
#include "kernels/shared/network_work.h"
#include "nn/features.h"

namespace tactel::host {
namespace {

static_assert(int(nn::FrameStatus::ok) == FRAME_OK && int(nn::FrameStatus::no_stress) == FRAME_NO_STRESS);
static_assert(int(nn::FrameStatus::not_finite) == FRAME_NOT_FINITE && int(nn::FrameStatus::overflow) == FRAME_OVERFLOW);
static_assert(nn::Bound::touching_share == TOUCHING_SHARE);
static_assert(nn::InputScaling::smallest_stress == SMALLEST_STRESS && nn::least_divisor == LEAST_DIVISOR);
static_assert(nn::InputScaling::large_stress == LARGE_STRESS && nn::InputScaling::large_scale == LARGE_SCALE);
static_assert(nn::InputScaling::rest_scale == REST_SCALE);
static_assert(nn::usual_friction == USUAL_FRICTION && nn::usual_spread == USUAL_SPREAD);

/// Stands in place of a status until the kernel has written it.
constexpr std::uint8_t unwritten = 0xff;

Buffer<std::uint8_t> marked(const Device& device, std::size_t count) {
  return {device, std::span<const std::uint8_t>(std::vector<std::uint8_t>(count, unwritten))};
}

void check_width(const nn::Topology& topology, int numbers, int given) {
  if (given != numbers)
    throw ValueError("inputs", std::to_string(given) + " a frame",
                     std::to_string(numbers) + " for the network " + topology.text());
}

template <class Real>
Real factor_of(const nn::InputScaling& scaling) {
  if (scaling.kind == nn::ScalingKind::rest) return static_cast<Real>(nn::InputScaling::rest_scale);
  return Real(1) / static_cast<Real>(scaling.largest_stress);
}

template <class Real>
const nn::Topology& common_topology(std::span<const nn::Weights<Real>> networks) {
  if (networks.empty()) throw std::invalid_argument("no networks");
  for (const auto& network : networks)
    if (network.topology != networks[0].topology) throw std::invalid_argument("networks of different topologies");
  return networks[0].topology;
}

/// network_defines, whether there is a bound, the normal stresses of the newest frame where they are not half of the
/// input, whether its last frame is the rest, and the features.
Defines forward_defines(const nn::Topology& topology, const nn::InputScaling& scaling, bool bound, int lanes,
                        Precision precision) {
  Defines defines = network_defines(topology, lanes, precision);
  defines.push_back({"BOUND", bound ? "1" : "0"});
  const int numbers = scaling.numbers(topology.inputs()), stresses = numbers - scaling.told();
  if (stresses < 1 || stresses % (scaling.axes * scaling.history) != 0)
    throw ValueError("history", std::to_string(scaling.history),
                     "frames of equal width in the network " + topology.text());
  if (scaling.history > 1 || scaling.axes != 2 || scaling.friction)
    defines.push_back({"NORMALS", std::to_string(scaling.normals(numbers))});
  const bool rested = scaling.kind == nn::ScalingKind::rest;
  if (rested) defines.push_back({"RESTED", "1"});
  if (scaling.friction) defines.push_back({"TOLD", std::to_string(scaling.told())});
  if (rested || scaling.friction || scaling.features != nn::Features::frame)
    for (const auto& [key, number] : {std::pair{"STRESSES", stresses}, {"SHOWN", scaling.shown()}})
      defines.push_back({key, std::to_string(number)});
  if (scaling.features == nn::Features::frame) return defines;
  const int tactels = scaling.normals(numbers);
  if (tactels % scaling.columns != 0)
    throw ValueError("scaling.columns", std::to_string(scaling.columns),
                     "a divisor of the " + std::to_string(tactels) + " tactels");
  for (const auto& [key, number] : {std::pair{"FEATURES", scaling.features == nn::Features::pad ? 2 : 1},
                                    {"GRID_COLUMNS", scaling.columns},
                                    {"GRID_ROWS", tactels / scaling.columns},
                                    {"SQUARE", int{scaling.square}}})
    defines.push_back({key, std::to_string(number)});
  return defines;
}

/// A bound as kernels/forward.cl has it.
template <class Real>
std::vector<Real> bound_numbers(const nn::Bound& bound, int inputs) {
  bound.validate(inputs);
  std::vector<Real> all{static_cast<Real>(bound.tactels), bound.unlike_above};
  const auto append = [&](const std::vector<float>& numbers) { all.insert(all.end(), numbers.begin(), numbers.end()); };
  const std::vector<float>* const edges[] = {&bound.touching, &bound.slip_index, &bound.width, &bound.distance};
  for (const auto* feature : edges) all.push_back(static_cast<Real>(feature->size()));
  append(bound.centre);
  for (int first = 0; first < inputs; first += BOUND_COLUMNS)
    for (int j = 0; j < inputs; ++j)
      for (int i = first; i < first + BOUND_COLUMNS; ++i)
        all.push_back(i < inputs ? bound.whitening[static_cast<std::size_t>(j) * static_cast<std::size_t>(inputs) +
                                                   static_cast<std::size_t>(i)]
                                 : 0);
  for (const auto* feature : edges) append(*feature);
  append(bound.upper_correction);
  append(bound.interval_correction);
  return all;
}

/// [bounds][numbers of the longest]; one number where there is none.
template <class Real>
std::vector<Real> all_bounds(std::span<const nn::Bound* const> bounds, int inputs) {
  std::vector<std::vector<Real>> each;
  std::size_t longest = 1;
  for (const nn::Bound* bound : bounds)
    longest = std::max(longest, each.emplace_back(bound_numbers<Real>(*bound, inputs)).size());
  std::vector<Real> all;
  for (std::vector<Real>& numbers : each) {
    numbers.resize(longest);
    all.insert(all.end(), numbers.begin(), numbers.end());
  }
  all.resize(std::max<std::size_t>(all.size(), 1));
  return all;
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
Forward<Real>::Forward(Executor& executor, std::span<const nn::Weights<Real>> networks, const nn::InputScaling& scaling,
                       std::span<const nn::Bound* const> bounds)
    : executor_(&executor),
      topology_(common_topology(networks)),
      networks_(networks.size()),
      answers_(bounds.empty() ? static_cast<std::size_t>(topology_.outputs()) : 4),
      numbers_(scaling.numbers(topology_.inputs())) {
  scaling.validate();
  if (!bounds.empty() && (bounds.size() != networks_ || !topology_.has_bound()))
    throw std::invalid_argument("bounds of other networks");
  const Device& device = executor.device();
  std::vector<Real> all;
  for (const auto& network : networks) all.insert(all.end(), network.values.begin(), network.values.end());
  weights_ = Buffer<Real>(device, std::span<const Real>(all));
  const std::vector<Real> bound = all_bounds<Real>(bounds, topology_.inputs());
  bounds_ = Buffer<Real>(device, std::span<const Real>(bound));
  const Buffer<float> no_frames(device, 1);
  slip_index_ = Buffer<Real>(device, 1);
  status_ = marked(device, 1);
  const Program program(
      device, "forward.cl",
      forward_defines(topology_, scaling, !bounds.empty(), device.lanes(precision_of<Real>), precision_of<Real>));
  launch_ = executor.prepare(program, "forward", [&](KernelArguments& kernel) {
    kernel.set("weights", weights_);
    kernel.set("frames", no_frames);
    kernel.set("slip_index", slip_index_);
    kernel.set("status", status_);
    kernel.set("rows", std::uint32_t{1});
    kernel.set("tiles", std::uint32_t{1});
    kernel.set("by_frame", std::int32_t{scaling.kind == nn::ScalingKind::frame});
    kernel.set("factor", factor_of<Real>(scaling));
    kernel.set("usual", static_cast<Real>(scaling.usual_stress));
    kernel.set("bounds", bounds_);
    kernel.set("bound_numbers", static_cast<std::uint32_t>(bound.size() / networks_));
  });
}

template <class Real>
void Forward<Real>::set_network(std::size_t network, const nn::Weights<Real>& weights) {
  if (weights.topology != topology_) throw std::invalid_argument("a network of another topology");
  weights_.write(weights.values, network * weights.values.size());
}

template <class Real>
void Forward<Real>::run(const DeviceFrames& frames, const RunOptions& options) {
  check_width(topology_, numbers_, frames.inputs());
  const std::uint32_t tile = FRAME_VECTORS * static_cast<std::uint32_t>(executor_->device().lanes(precision_of<Real>));
  const std::uint32_t tiles = (frames.rows() + tile - 1) / tile;
  const std::size_t numbers = networks_ * answers_ * frames.rows();
  if (numbers > slip_index_.size()) {
    slip_index_ = Buffer<Real>(executor_->device(), numbers);
    status_ = marked(executor_->device(), networks_ * frames.rows());
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
nn::Recall<Real> Forward<Real>::result(std::size_t network) {
  nn::Recall<Real> answer;
  read(network, answer);
  return answer;
}

template <class Real>
void Forward<Real>::read(std::size_t network, nn::Recall<Real>& answer) {
  read_.resize(answers_ * rows_);
  slip_index_.read(std::span<Real>(read_), network * read_.size());
  answer.status.resize(rows_);
  const std::span status(reinterpret_cast<std::uint8_t*>(answer.status.data()), rows_);
  status_.read(status, network * rows_);
  if (std::ranges::find(status, unwritten) != status.end()) refuse_unwritten(executor_->device());
  const auto numbers = [&](std::size_t which) { return read_.begin() + static_cast<std::ptrdiff_t>(which * rows_); };
  const auto take = [&](nn::Vector<Real>& to, std::size_t which) {
    to.resize(rows_);
    std::copy_n(numbers(which), rows_, to.data());
  };
  take(answer.slip_index, 0);
  if (answers_ == 3) take(answer.upper, 1), take(answer.lower, 2);
  if (answers_ != 4) return;
  answer.bounds.resize(rows_);
  for (std::uint32_t row = 0; row < rows_; ++row) {
    const auto number = [&](std::size_t which) { return static_cast<float>(numbers(which)[row]); };
    const auto status = static_cast<std::uint8_t>(answer.status[row]);
    answer.bounds[row] = {number(1), {number(2), number(3)}, (status & FRAME_UNLIKE) != 0};
    answer.status[row] = static_cast<nn::FrameStatus>(status % FRAME_UNLIKE);
  }
}

template <class Real>
nn::Recall<Real> Forward<Real>::recall(const nn::RowMatrix<float>& frames) {
  run(DeviceFrames(executor_->device(), frames));
  return result(0);
}

template class Forward<float>;
template class Forward<double>;

}  // namespace tactel::host
