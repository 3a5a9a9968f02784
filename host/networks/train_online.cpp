// SPDX-License-Identifier: Apache-2.0
#include "host/networks/train_online.h"

#include <algorithm>
#include <bit>

#include "fem/numbers/value_error.h"
#include "host/device/unwritten.h"
#include "host/networks/forward.h"
#include "kernels/shared/network_work.h"
#include "kernels/shared/random_streams.h"
#include "nn/philox.h"

namespace tactel::host {
namespace {

static_assert(int(nn::TrainStatus::running) == ONLINE_RUNNING && int(nn::TrainStatus::learnt) == ONLINE_LEARNT);
static_assert(int(nn::TrainStatus::cycle_limit) == ONLINE_CYCLE_LIMIT);
static_assert(int(nn::TrainStatus::not_finite) == ONLINE_NOT_FINITE);
static_assert(int(nn::RandomStream::order) == ORDER_STREAM && int(nn::RandomStream::reading) == READING_STREAM);
static_assert(int(nn::RandomStream::gain) == GAIN_STREAM && int(nn::RandomStream::instance) == INSTANCE_STREAM);

std::size_t ceil_div(std::size_t numbers, std::size_t in_each) { return (numbers + in_each - 1) / in_each; }

// Numbers of a group's weights of one layer, steps included.
std::size_t layer_size(const nn::Topology& topology, int layer, std::size_t lanes, std::size_t together) {
  return 2 * lanes * (topology.fan_in(layer) + 1) * ceil_div(topology.fan_out(layer), lanes / together);
}

// Networks in the lanes of a group, when there are enough. Side by side they fill the lanes better, and hide each
// other's latency; but their second layers, which every pattern reads and writes, have to fit the first-level cache.
template <class Real>
std::size_t networks_together(const nn::Topology& topology, std::size_t lanes) {
  constexpr std::size_t cache = 36 << 10;
  if (topology.hidden_layers() == 1) return std::min<std::size_t>(lanes, 4);
  const std::size_t together = std::min<std::size_t>(lanes, 2);
  return layer_size(topology, 1, lanes, together) * sizeof(Real) > cache ? 1 : together;
}

// Numbers of a group's weights, steps included; those into the output neuron are an input to a lane.
std::size_t group_size(const nn::Topology& topology, std::size_t lanes, std::size_t together) {
  const int last = topology.layers() - 1;
  std::size_t size = 2 * lanes * (ceil_div(topology.fan_in(last), lanes / together) + 1);
  for (int l = 0; l < last; ++l) size += layer_size(topology, l, lanes, together);
  return size;
}

}  // namespace

// One for each input and the bias, or for each hidden neuron.
std::size_t group_items(const Device& device, const nn::Topology& topology) {
  int hidden = 0;
  for (int l = 0; l < topology.hidden_layers(); ++l) hidden += topology.fan_out(l);
  const auto items = std::bit_ceil(static_cast<std::size_t>(std::max({hidden, topology.inputs() + 1, 32})));
  return device.info().type == DeviceType::gpu && items <= MOST_GROUP_ITEMS ? items : 1;
}

template <class Real>
TrainOnline<Real>::TrainOnline(Executor& executor, const nn::Topology& topology, const LearningInputs<Real>& inputs,
                               std::span<const OnlineMember> members, const nn::OnlineOptions& options)
    : executor_(&executor),
      topology_(topology),
      options_(options),
      inputs_(inputs),
      members_(members.begin(), members.end()),
      together_(networks_together<Real>(topology, executor.device().lanes(precision_of<Real>))),
      group_items_(group_items(executor.device(), topology)) {
  options.validate();
  if (topology.has_bound())
    throw ValueError("network", topology.text(), "a network with one output: a bound is learnt by mini-batches");
  if (topology.hidden_activation() != nn::Activation::logistic)
    throw ValueError("network", topology.text(), "logistic neurons: others are learnt by mini-batches");
  if (inputs.inputs() != topology.inputs())
    throw ValueError("network", topology.text(),
                     "a network with " + std::to_string(inputs.inputs()) + " inputs, as the set has");
  const Device& device = executor.device();
  const int lanes = device.lanes(precision_of<Real>);
  const std::size_t slots = ceil_div(members_.size(), together_) * together_;
  weights_ = Buffer<Real>(device, members_.size() * 2 * topology.weight_count());
  reports_ = Buffer<OnlineReport>(device, members_.size());
  vectors_ = Buffer<Real>(device, std::max(slots / together_ * group_size(topology, lanes, together_),
                                           2 * together_ * group_size(topology, lanes, 1)));
  curve_ = Buffer<Real>(device, 0);
  order_ = Buffer<std::uint32_t>(device, slots * inputs.rows());
  slots_ = Buffer<std::uint32_t>(device, slots);
  std::vector<std::uint32_t> set_of;
  std::vector<std::uint64_t> seeds;
  for (const OnlineMember& member : members_) {
    set_of.push_back(member.variant);
    seeds.push_back(member.seed);
  }
  set_of_ = Buffer<std::uint32_t>(device, std::span<const std::uint32_t>(set_of));
  seeds_ = Buffer<std::uint64_t>(device, std::span<const std::uint64_t>(seeds));
  for (std::size_t i = 0; i < members_.size(); ++i)
    set_state(i, nn::OnlineState<Real>(nn::initial_weights(topology, members_[i].seed)));
  launch(members_.size() < 2 * together_ ? 1 : together_);  // as job() begins
}

// The launch with this number of networks side by side, compiled at its first use.
template <class Real>
Launch& TrainOnline<Real>::launch(std::size_t together) {
  if (const auto found = launches_.find(together); found != launches_.end()) return found->second;
  const Device& device = executor_->device();
  Defines defines = network_defines(topology_, device.lanes(precision_of<Real>), precision_of<Real>);
  const bool by_groups = group_items_ > 1;
  if (by_groups)
    defines.emplace_back("GROUP_ITEMS", std::to_string(group_items_));
  else
    defines.emplace_back("NETWORKS", std::to_string(together));
  const std::string kernel = by_groups ? "train_group" : "train_online";
  const Program program(device, kernel + ".cl", defines);
  const Launch launch = executor_->prepare(program, kernel, [&](KernelArguments& kernel) {
    kernel.set("weights", weights_);
    kernel.set("reports", reports_);
    kernel.set("curve", curve_);
    if (!by_groups) kernel.set("vectors", vectors_);
    kernel.set("order", order_);
    kernel.set("slots", slots_);
    kernel.set("seeds", seeds_);
    kernel.set("inputs", inputs_.rows_buffer());
    kernel.set("set_of", set_of_);
    kernel.set("targets", inputs_.targets_buffer());
    kernel.set("rows", std::uint32_t{inputs_.rows()});
    kernel.set("most_cycles", std::uint32_t{0});
    kernel.set("cycle_limit", std::uint32_t{cycle_limit()});
    kernel.set("permuted", std::int32_t{options_.order == nn::PresentationOrder::permuted});
    kernel.set("rate", static_cast<Real>(options_.rate));
    kernel.set("momentum", static_cast<Real>(options_.momentum));
    kernel.set("stop_error", static_cast<Real>(options_.stop_error));
  });
  return launches_.emplace(together, launch).first->second;
}

template <class Real>
std::uint32_t TrainOnline<Real>::cycle_limit() const {
  return static_cast<std::uint32_t>(options_.cycles(topology_));
}

template <class Real>
Job TrainOnline<Real>::job(std::uint32_t most_cycles) {
  if (most_cycles != curve_cycles_) {
    curve_cycles_ = most_cycles;
    curve_ = Buffer<Real>(executor_->device(), members_.size() * most_cycles * 2);
  }
  std::vector<std::uint32_t> slots = running();
  const std::size_t together = slots.size() < 2 * together_ ? 1 : together_;  // half empty groups gain nothing
  const std::size_t groups = ceil_div(slots.size(), together);
  slots.resize(slots_.size(), NO_NETWORK);
  slots_.write(slots);
  Launch& next = launch(together);
  next.set("curve", curve_);
  next.set("most_cycles", std::uint32_t{most_cycles});
  return {next, groups * group_items_};
}

// Networks that have stopped leave their lanes to others.
template <class Real>
std::vector<std::uint32_t> TrainOnline<Real>::running() const {
  std::vector<std::uint32_t> running;
  const std::vector<OnlineReport> found = reports();
  for (std::uint32_t i = 0; i < found.size(); ++i)
    if (found[i].status == ONLINE_RUNNING) running.push_back(i);
  return running;
}

template <class Real>
RunReport TrainOnline<Real>::run(std::uint32_t most_cycles, const RunOptions& options) {
  RunOptions one_by_one = options;
  one_by_one.largest_chunk = 1;
  const Job next = job(most_cycles);
  return executor_->run(std::span(&next, 1), one_by_one);
}

template <class Real>
std::vector<OnlineReport> TrainOnline<Real>::reports() const {
  std::vector<OnlineReport> reports(members_.size());
  reports_.read(reports);
  return reports;
}

template <class Real>
OnlineReport TrainOnline<Real>::report(std::size_t network) const {
  OnlineReport report{};
  reports_.read(std::span(&report, 1), network);
  return report;
}

template <class Real>
std::vector<nn::CycleErrors> TrainOnline<Real>::curve(std::size_t network, const OnlineReport& from) const {
  const OnlineReport last = report(network);
  std::vector<Real> numbers(2 * (last.cycle - from.cycle));
  curve_.read(numbers, network * curve_cycles_ * 2);
  std::vector<nn::CycleErrors> errors;
  for (std::size_t i = 0; i < numbers.size(); i += 2) errors.push_back({numbers[i], numbers[i + 1]});
  return errors;
}

template <class Real>
nn::OnlineState<Real> TrainOnline<Real>::state(std::size_t network) const {
  const OnlineReport last = report(network);
  nn::OnlineState<Real> state{nn::Weights<float>(topology_)};
  const std::size_t count = topology_.weight_count();
  weights_.read(state.weights.values, 2 * network * count);
  weights_.read(state.step.values, (2 * network + 1) * count);
  if (last.cycle > 0 && (state.weights.layer(0).array() == 0).all()) refuse_unwritten(executor_->device());
  state.cycle = last.cycle;
  state.status = static_cast<nn::TrainStatus>(last.status);
  return state;
}

template <class Real>
void TrainOnline<Real>::set_state(std::size_t network, const nn::OnlineState<Real>& state) {
  const std::size_t count = topology_.weight_count();
  weights_.write(state.weights.values, 2 * network * count);
  weights_.write(state.step.values, (2 * network + 1) * count);
  const OnlineReport report{static_cast<std::int32_t>(state.status), state.cycle, 0, 0};
  reports_.write(std::span(&report, 1), network);
}

template class TrainOnline<float>;
template class TrainOnline<double>;

}  // namespace tactel::host
