#include "host/train_online.h"

#include <algorithm>

#include "fem/value_error.h"
#include "host/forward.h"

namespace tactel::host {
namespace {

static_assert(int(nn::TrainStatus::running) == ONLINE_RUNNING && int(nn::TrainStatus::learnt) == ONLINE_LEARNT);
static_assert(int(nn::TrainStatus::cycle_limit) == ONLINE_CYCLE_LIMIT);
static_assert(int(nn::TrainStatus::not_finite) == ONLINE_NOT_FINITE);

// Places of the kernel's arguments that change from run to run.
enum Argument : unsigned { curve_argument = 3, most_cycles_argument = 10 };

int vectors_of(int numbers, int lanes) { return (numbers + lanes - 1) / lanes; }

}  // namespace

template <class Real>
TrainOnline<Real>::TrainOnline(Executor& executor, const nn::Topology& topology, const LearningInputs<Real>& inputs,
                               std::span<const OnlineMember> members, const nn::OnlineOptions& options)
    : executor_(&executor),
      topology_(topology),
      options_(options),
      inputs_(inputs),
      members_(members.begin(), members.end()),
      lanes_(executor.device().lanes(precision_of<Real>)) {
  options.validate();
  if (inputs.inputs() != topology.inputs())
    throw ValueError("network", topology.text(),
                     "a network with " + std::to_string(inputs.inputs()) + " inputs, as the set has");
  const Device& device = executor.device();
  weights_ = Buffer<Real>(device, members_.size() * network_size());
  reports_ = Buffer<OnlineReport>(device, members_.size());
  order_ = Buffer<std::uint32_t>(device, members_.size() * inputs.rows());
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
  const Program program(device, "train_online.cl", network_defines(topology, lanes_, precision_of<Real>));
  curve_ = Buffer<Real>(device, 0);
  launch_ = executor.prepare(program, "train_online", [&](cl::Kernel& kernel) {
    cl_uint i = 1;
    kernel.setArg(i++, weights_.cl_buffer());
    kernel.setArg(i++, reports_.cl_buffer());
    kernel.setArg(i++, curve_.cl_buffer());
    kernel.setArg(i++, order_.cl_buffer());
    kernel.setArg(i++, seeds_.cl_buffer());
    kernel.setArg(i++, inputs_.rows_buffer().cl_buffer());
    kernel.setArg(i++, set_of_.cl_buffer());
    kernel.setArg(i++, inputs_.targets_buffer().cl_buffer());
    kernel.setArg(i++, cl_uint{inputs_.rows()});
    kernel.setArg(i++, cl_uint{0});
    kernel.setArg(i++, cl_uint{cycle_limit()});
    kernel.setArg(i++, cl_int{options_.order == nn::PresentationOrder::permuted});
    kernel.setArg(i++, static_cast<Real>(options_.rate));
    kernel.setArg(i++, static_cast<Real>(options_.momentum));
    kernel.setArg(i++, static_cast<Real>(options_.stop_error));
  });
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
    launch_.set(curve_argument, curve_.cl_buffer());
    launch_.set(most_cycles_argument, cl_uint{most_cycles});
  }
  return {launch_, members_.size()};
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
  const OnlineReport now = report(network);
  std::vector<Real> numbers(2 * (now.cycle - from.cycle));
  curve_.read(numbers, network * curve_cycles_ * 2);
  std::vector<nn::CycleErrors> errors;
  for (std::size_t i = 0; i < numbers.size(); i += 2) errors.push_back({numbers[i], numbers[i + 1]});
  return errors;
}

// Where the kernel keeps weight (layer, neuron, input), in numbers from the network's beginning; its step follows
// `lanes` later. An input equal to the layer's fan-in is the bias.
template <class Real>
std::size_t TrainOnline<Real>::place(int layer, int neuron, int input) const {
  std::size_t vector = 0;
  for (int l = 0; l < layer; ++l)
    vector += std::size_t(topology_.fan_in(l) + 1) * vectors_of(topology_.fan_out(l), lanes_);
  const bool output = layer == topology_.layers() - 1;
  const int fan_in = topology_.fan_in(layer);
  if (output && input == fan_in) return (vector + vectors_of(fan_in, lanes_)) * 2 * lanes_;
  const int lane = (output ? input : neuron) % lanes_;
  vector += output ? input / lanes_ : input * vectors_of(topology_.fan_out(layer), lanes_) + neuron / lanes_;
  return vector * 2 * lanes_ + lane;
}

template <class Real>
std::size_t TrainOnline<Real>::network_size() const {
  return place(topology_.layers() - 1, 0, topology_.fan_in(topology_.layers() - 1)) + 2 * lanes_;
}

template <class Real>
nn::OnlineState<Real> TrainOnline<Real>::state(std::size_t network) const {
  const OnlineReport now = report(network);
  std::vector<Real> numbers(network_size());
  weights_.read(numbers, network * network_size());
  nn::OnlineState<Real> state{nn::Weights<float>(topology_)};
  state.cycle = now.cycle;
  state.status = static_cast<nn::TrainStatus>(now.status);
  for (int l = 0; l < topology_.layers(); ++l) {
    auto weights = state.weights.layer(l), steps = state.step.layer(l);
    for (int neuron = 0; neuron < topology_.fan_out(l); ++neuron) {
      for (int input = 0; input <= topology_.fan_in(l); ++input) {
        weights(neuron, input) = numbers[place(l, neuron, input)];
        steps(neuron, input) = numbers[place(l, neuron, input) + lanes_];
      }
    }
  }
  return state;
}

template <class Real>
void TrainOnline<Real>::set_state(std::size_t network, const nn::OnlineState<Real>& state) {
  std::vector<Real> numbers(network_size(), Real(0));
  for (int l = 0; l < topology_.layers(); ++l) {
    const auto weights = state.weights.layer(l), steps = state.step.layer(l);
    for (int neuron = 0; neuron < topology_.fan_out(l); ++neuron) {
      for (int input = 0; input <= topology_.fan_in(l); ++input) {
        numbers[place(l, neuron, input)] = weights(neuron, input);
        numbers[place(l, neuron, input) + lanes_] = steps(neuron, input);
      }
    }
  }
  // The output's bias is the same in every lane.
  std::fill(numbers.end() - 2 * lanes_, numbers.end() - lanes_, numbers[numbers.size() - 2 * lanes_]);
  std::fill(numbers.end() - lanes_, numbers.end(), numbers[numbers.size() - lanes_]);
  weights_.write(numbers, network * network_size());
  const OnlineReport report{static_cast<std::int32_t>(state.status), state.cycle, 0, 0};
  reports_.write(std::span(&report, 1), network);
}

template class TrainOnline<float>;
template class TrainOnline<double>;

}  // namespace tactel::host
