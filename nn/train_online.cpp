// SPDX-License-Identifier: Apache-2.0
#include "nn/train_online.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "fem/numbers/value_error.h"

namespace tactel::nn {
namespace {

template <class Scalar>
void apply_rule(OnlineState<Scalar>& state, const Activations<Scalar>& o, const Deltas<Scalar>& delta,
                const OnlineOptions& options) {
  for (Scalar& step : state.step.values) step *= Scalar(options.momentum);
  add_outer(o, delta, Scalar(options.rate), state.step);
  for (std::size_t i = 0; i < state.step.values.size(); ++i) state.weights.values[i] += state.step.values[i];
}

TrainStatus status_after(const CycleErrors& errors, std::uint32_t cycle, const OnlineOptions& options,
                         const Topology& topology) {
  if (!std::isfinite(errors.sse)) return TrainStatus::not_finite;
  if (errors.largest < options.stop_error) return TrainStatus::learnt;
  return cycle >= static_cast<std::uint32_t>(options.cycles(topology)) ? TrainStatus::cycle_limit
                                                                       : TrainStatus::running;
}

}  // namespace

const char* name(TrainStatus status) {
  constexpr std::array names{"running", "learnt", "cycle limit", "not finite", "early stop"};
  const auto place = static_cast<std::size_t>(status);
  return place < names.size() ? names[place] : "unknown";
}

void OnlineOptions::validate() const {
  if (!(rate > 0) || !std::isfinite(rate))
    throw ValueError("training.rate", std::to_string(rate), "finite and above 0");
  if (!(momentum >= 0 && momentum < 1))
    throw ValueError("training.momentum", std::to_string(momentum), "at least 0 and below 1");
  if (!(stop_error >= 0)) throw ValueError("training.stop_error", std::to_string(stop_error), "at least 0");
  if (cycle_limit < 0)
    throw ValueError("training.cycles", std::to_string(cycle_limit), "at least 1, or 0 for the paper's");
}

template <class Scalar>
CycleErrors train_cycle(OnlineState<Scalar>& state, const TrainingSet<Scalar>& set, const OnlineOptions& options,
                        std::uint64_t seed) {
  CycleErrors errors;
  const auto rows = static_cast<std::uint32_t>(set.inputs.rows());
  for (const std::uint32_t row : presentation_order(options.order, seed, state.cycle, rows)) {
    const Activations<Scalar> o = forward<Scalar>(state.weights, set.inputs.row(row).transpose());
    const Scalar error = set.target(row) - o.back()(0);
    errors.sse += static_cast<double>(error) * error;
    errors.largest = std::max(errors.largest, static_cast<double>(std::abs(error)));
    apply_rule(state, o, backward(state.weights, o, error), options);
  }
  ++state.cycle;
  state.status = status_after(errors, state.cycle, options, state.weights.topology);
  return errors;
}

template <class Scalar>
CycleErrors train_online(OnlineState<Scalar>& state, const TrainingSet<Scalar>& set, const OnlineOptions& options,
                         std::uint64_t seed, int most_cycles) {
  options.validate();
  CycleErrors errors;
  for (int i = 0; i < most_cycles && state.status == TrainStatus::running; ++i)
    errors = train_cycle(state, set, options, seed);
  return errors;
}

template CycleErrors train_cycle(OnlineState<float>&, const TrainingSet<float>&, const OnlineOptions&, std::uint64_t);
template CycleErrors train_cycle(OnlineState<double>&, const TrainingSet<double>&, const OnlineOptions&, std::uint64_t);
template CycleErrors train_online(OnlineState<float>&, const TrainingSet<float>&, const OnlineOptions&, std::uint64_t,
                                  int);
template CycleErrors train_online(OnlineState<double>&, const TrainingSet<double>&, const OnlineOptions&, std::uint64_t,
                                  int);

}  // namespace tactel::nn
