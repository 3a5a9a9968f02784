// SPDX-License-Identifier: Apache-2.0
#include "host/networks/train_batch.h"

#include <algorithm>
#include <cmath>

#include "fem/numbers/value_error.h"
#include "host/device/unwritten.h"
#include "host/networks/forward.h"
#include "kernels/shared/network_work.h"

namespace tactel::host {
namespace {

constexpr std::uint32_t launch_patterns = 1 << 16;  ///< that one launch of train_batch learns from, about: 10 ms
constexpr std::size_t groups_at_once = 512;         ///< work-groups that fill a GPU

int padded(int numbers, int lanes) { return (numbers + lanes - 1) / lanes * lanes; }

std::uint32_t parts_of(std::uint32_t whole, std::uint32_t part) { return (whole + part - 1) / part; }

/// Stands in place of an error until a kernel has written it.
constexpr int unwritten = -1;

void add(nn::CycleErrors& errors, double sse, double largest, const Device& device) {
  if (sse == unwritten) refuse_unwritten(device);
  errors.sse += sse;
  errors.largest = std::max(errors.largest, largest);
}

}  // namespace

template <class Real>
TrainBatch<Real>::TrainBatch(Executor& executor, const nn::Topology& topology, const LearningInputs<Real>& inputs,
                             std::span<const OnlineMember> members, const nn::BatchOptions& options)
    : executor_(&executor),
      topology_(topology),
      options_(options),
      inputs_(inputs),
      members_(members.begin(), members.end()),
      lanes_(executor.device().lanes(precision_of<Real>)),
      items_(group_items(executor.device(), topology)) {
  options.validate();
  if (inputs.inputs() != topology.inputs())
    throw ValueError("network", topology.text(),
                     "a network with " + std::to_string(inputs.inputs()) + " inputs, as the set has");
  const Device& device = executor.device();
  const auto batch = static_cast<std::uint32_t>(std::min<std::int64_t>(options.batch, inputs.rows()));
  options_.batch = static_cast<int>(batch);
  const std::size_t many = members_.size(), slices = parts_of(batch, slice);
  slices_ = items_ == 1 ? slices : std::max(slices, std::min(groups_at_once, many * slices));
  const std::size_t batches = std::max<std::uint32_t>(1, launch_patterns / batch);
  weights_ = Buffer<Real>(device, many * numbers());
  first_ = Buffer<Real>(device, many * numbers());
  second_ = Buffer<Real>(device, many * numbers());
  mean_ = Buffer<Real>(device, options.average > 0 ? many * numbers() : 1);
  sums_ = Buffer<Real>(device, std::max(many, slices_) * numbers());
  const std::vector<Real> marks(std::max(many * batches, slices_) * 2, unwritten);
  errors_ = Buffer<Real>(device, std::span<const Real>(marks));
  factors_ = Buffer<Real>(device, batches * 4);
  order_ = Buffer<std::uint32_t>(device, many * inputs.rows());
  std::vector<std::uint32_t> set_of;
  for (const OnlineMember& member : members_) set_of.push_back(member.variant);
  set_of_ = Buffer<std::uint32_t>(device, std::span<const std::uint32_t>(set_of));
  for (std::size_t i = 0; i < many; ++i)
    set_state(i, nn::BatchState<Real>(nn::initial_weights(topology, members_[i].seed)));
  prepare();
}

template <class Real>
void TrainBatch<Real>::prepare() {
  Defines defines = network_defines(topology_, lanes_, precision_of<Real>);
  defines.emplace_back("GROUP_ITEMS", std::to_string(items_));
  const std::uint32_t batch = static_cast<std::uint32_t>(options_.batch);
  const auto set_rule = [&](KernelArguments& kernel) {
    kernel.set("weights", weights_);
    kernel.set("sums", sums_);
    kernel.set("network", std::uint32_t{0});
    kernel.set("slices", std::uint32_t{1});
    kernel.set("rows", std::uint32_t{inputs_.rows()});
    kernel.set("begin", std::uint32_t{0});
    kernel.set("batch", batch);
    kernel.set("adam", std::int32_t{options_.rule == nn::BatchRule::adam});
    kernel.set("momentum", static_cast<Real>(options_.momentum));
    kernel.set("beta1", static_cast<Real>(options_.beta1));
    kernel.set("beta2", static_cast<Real>(options_.beta2));
    kernel.set("epsilon", static_cast<Real>(options_.epsilon));
    kernel.set("first", first_);
    kernel.set("second", second_);
    kernel.set("mean", mean_);
    kernel.set("factors", factors_);
  };
  const auto set_rows = [&](KernelArguments& kernel) {
    set_rule(kernel);
    kernel.set("errors", errors_);
    kernel.set("inputs", inputs_.rows_buffer());
    kernel.set("set_of", set_of_);
    kernel.set("targets", inputs_.targets_buffer());
    kernel.set("order", order_);
    kernel.set("slice", std::uint32_t{slice});
    kernel.set("batches", std::uint32_t{1});
    kernel.set("changes", std::int32_t{batch <= slice});
    kernel.set("absolute", std::int32_t{options_.loss == nn::Loss::absolute});
    kernel.set("level", static_cast<Real>(options_.level));
  };
  const Device& device = executor_->device();
  const std::string kernel = items_ == 1 ? "train_batch" : "train_group_batch";
  learn_ = executor_->prepare(Program(device, kernel + ".cl", defines), kernel, set_rows);
  if (batch > slice) update_ = executor_->prepare(Program(device, "train_batch.cl", defines), "batch_update", set_rule);
}

template <class Real>
void TrainBatch<Real>::upload_order() {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const auto order = nn::presentation_order(options_.order, members_[i].seed, epoch_, inputs_.rows());
    order_.write(order, i * inputs_.rows());
  }
}

// Of the updates after batches first_batch ... of this epoch, [batches][4], as the kernel takes them.
template <class Real>
std::vector<Real> TrainBatch<Real>::factors(std::uint32_t first_batch, std::uint32_t batches) const {
  const auto batch = static_cast<std::uint32_t>(options_.batch);
  std::vector<Real> factors;
  for (std::uint32_t i = first_batch; i < first_batch + batches; ++i) {
    const std::uint64_t update = updates_ + i + 1;
    const std::uint32_t begin = i * batch, count = std::min(batch, inputs_.rows() - begin);
    const auto t = static_cast<double>(update);
    for (const double factor : {1 / (1 - std::pow(options_.beta1, t)), 1 / (1 - std::pow(options_.beta2, t)),
                                options_.rate_of(shown_ + begin, count), options_.share_of_mean(update)})
      factors.push_back(static_cast<Real>(factor));
  }
  return factors;
}

template <class Real>
std::optional<std::vector<nn::CycleErrors>> TrainBatch<Real>::train_epoch(const Progress& progress) {
  std::vector<nn::BatchState<Real>> before;
  if (progress)
    for (std::size_t i = 0; i < size(); ++i) before.push_back(state(i));
  upload_order();
  std::vector<nn::CycleErrors> errors(size());
  const bool small = static_cast<std::uint32_t>(options_.batch) <= slice;
  if (!(small ? run_small_batches(progress, errors) : run_large_batches(progress, errors))) {
    for (std::size_t i = 0; i < size(); ++i) set_state(i, before[i]);
    return std::nullopt;
  }
  updates_ += parts_of(inputs_.rows(), static_cast<std::uint32_t>(options_.batch));
  shown_ += inputs_.rows();
  ++epoch_;
  return errors;
}

template <class Real>
bool TrainBatch<Real>::run_small_batches(const Progress& progress, std::vector<nn::CycleErrors>& errors) {
  const std::uint32_t rows = inputs_.rows(), batch = static_cast<std::uint32_t>(options_.batch);
  const std::uint32_t all = parts_of(rows, batch), most = static_cast<std::uint32_t>(factors_.size() / 4);
  std::vector<Real> found(2 * most * size());
  for (std::uint32_t done = 0; done < all;) {
    const std::uint32_t batches = std::min(most, all - done);
    factors_.write(factors(done, batches));
    learn_.set("begin", std::uint32_t{done * batch});
    learn_.set("batches", std::uint32_t{batches});
    executor_->run(learn_, size() * items_, {.progress = {}, .largest_chunk = 1});
    const std::span<Real> read(found.data(), 2 * batches * size());
    errors_.read(read);
    for (std::size_t i = 0; i < read.size(); i += 2)
      add(errors[i / 2 / batches], read[i], read[i + 1], executor_->device());
    done += batches;
    if (progress &&
        !progress(std::min<std::uint64_t>(std::uint64_t{done} * batch, rows) * size(), std::size_t{rows} * size()))
      return false;
  }
  return true;
}

template <class Real>
bool TrainBatch<Real>::run_large_batches(const Progress& progress, std::vector<nn::CycleErrors>& errors) {
  const std::uint32_t rows = inputs_.rows(), batch = static_cast<std::uint32_t>(options_.batch);
  const std::uint32_t updates = parts_of(static_cast<std::uint32_t>(numbers() / lanes_), UPDATE_VECTORS);
  for (std::uint32_t begin = 0, done = 0; begin < rows; begin += batch, ++done) {
    const std::uint32_t count = std::min(batch, rows - begin), slices = parts_of(count, slice);
    const auto together = static_cast<std::uint32_t>(slices_ / slices);
    factors_.write(factors(done, 1));
    for (std::uint32_t network = 0; network < size(); network += together) {
      for (Launch* launch : {&learn_, &update_})
        launch->bind([&](KernelArguments& kernel) {
          kernel.set("network", network);
          kernel.set("slices", slices);
          kernel.set("begin", begin);
        });
      const std::size_t networks = std::min<std::size_t>(together, size() - network);
      executor_->run(learn_, networks * slices * items_, {.progress = {}, .equal_groups = true});
      executor_->run(update_, networks * updates, {.progress = {}, .equal_groups = true});
      std::vector<Real> found(2 * networks * slices);
      errors_.read(found);
      for (std::size_t i = 0; i < found.size(); i += 2)
        add(errors[network + i / 2 / slices], found[i], found[i + 1], executor_->device());
    }
    if (progress && !progress((std::size_t{begin} + count) * size(), std::size_t{rows} * size())) return false;
  }
  return true;
}

template <class Real>
std::size_t TrainBatch<Real>::numbers() const {
  std::size_t numbers = 0;
  for (int l = 0; l < topology_.layers(); ++l)
    numbers += std::size_t(topology_.fan_out(l)) * padded(topology_.fan_in(l) + 1, lanes_);
  return numbers;
}

template <class Real>
void TrainBatch<Real>::unpack(const Buffer<Real>& from, std::size_t network, nn::Weights<Real>& to) const {
  std::vector<Real> packed(numbers());
  from.read(packed, network * numbers());
  const Real* row = packed.data();
  for (int l = 0; l < topology_.layers(); ++l)
    for (int n = 0; n < topology_.fan_out(l); ++n, row += padded(topology_.fan_in(l) + 1, lanes_))
      std::copy_n(row, topology_.fan_in(l) + 1, to.layer(l).row(n).data());
}

template <class Real>
void TrainBatch<Real>::pack(const nn::Weights<Real>& from, std::size_t network, Buffer<Real>& to) {
  std::vector<Real> packed(numbers(), Real(0));
  Real* row = packed.data();
  for (int l = 0; l < topology_.layers(); ++l)
    for (int n = 0; n < topology_.fan_out(l); ++n, row += padded(topology_.fan_in(l) + 1, lanes_))
      std::copy_n(from.layer(l).row(n).data(), topology_.fan_in(l) + 1, row);
  to.write(packed, network * numbers());
}

template <class Real>
nn::BatchState<Real> TrainBatch<Real>::state(std::size_t network) const {
  nn::BatchState<Real> state{nn::Weights<float>(topology_)};
  unpack(weights_, network, state.weights);
  unpack(first_, network, state.first);
  unpack(second_, network, state.second);
  if (options_.average > 0 && updates_ > 0) unpack(mean_, network, state.mean = nn::Weights<Real>(topology_));
  state.updates = updates_, state.rows = shown_;
  state.epoch = epoch_;
  return state;
}

template <class Real>
void TrainBatch<Real>::set_state(std::size_t network, const nn::BatchState<Real>& state) {
  pack(state.weights, network, weights_);
  pack(state.first, network, first_);
  pack(state.second, network, second_);
  if (options_.average > 0) pack(state.result(), network, mean_);
  updates_ = state.updates, shown_ = state.rows;
  epoch_ = state.epoch;
}

template class TrainBatch<float>;
template class TrainBatch<double>;

}  // namespace tactel::host
