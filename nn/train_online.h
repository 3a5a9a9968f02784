// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

#include "nn/forward.h"
#include "nn/frame_set.h"
#include "nn/presentation_order.h"

namespace tactel::nn {

/// Reason for the end of a training.
enum class TrainStatus : std::uint8_t {
  running = 0,      ///< not ended
  learnt = 1,       ///< the largest error of a cycle fell below the stop error
  cycle_limit = 2,  ///< the limit of cycles was reached
  not_finite = 3,   ///< an error became NaN or infinite: the learning rate does not suit the set
  early_stop = 4,   ///< the error on a validation set had not fallen for some cycles
};
const char* name(TrainStatus status);

/// The generalized delta rule in its original form, with the paper's numbers (sections V.B and V.E).
struct OnlineOptions {
  double rate = 0.1;
  double momentum = 0.9;
  double stop_error = 0.01;  ///< stop after a cycle in which every pattern's |error| is below this; 0 never stops
  int cycle_limit = 0;       ///< 0: the topology's own, 10 000 or 15 000
  PresentationOrder order = PresentationOrder::permuted;

  int cycles(const Topology& topology) const { return cycle_limit > 0 ? cycle_limit : topology.cycle_limit(); }
  void validate() const;  ///< throws ValueError, keys "training.rate", ...
};

/// State of a training: all that a bit-identical resumption needs.
template <class Scalar>
struct OnlineState {
  explicit OnlineState(const Weights<float>& initial) : weights(initial), step(initial.topology) {}
  Weights<Scalar> weights;
  Weights<Scalar> step;  ///< the last change of each weight, which the momentum continues
  std::uint32_t cycle = 0;
  TrainStatus status = TrainStatus::running;
};

/// Errors of a cycle. The error of a pattern is taken as it is shown, before its change of the weights.
struct CycleErrors {
  double sse = 0;      ///< sum of (target - output)^2
  double largest = 0;  ///< largest |target - output|
};

/// Trains one cycle: every pattern once. After each pattern, step = rate delta o + momentum step and weights +=
/// step (Rumelhart, Hinton and Williams 1986, eq. 16). Sets state.status at the end of a training. Returns the
/// errors of the cycle.
template <class Scalar>
CycleErrors train_cycle(OnlineState<Scalar>& state, const TrainingSet<Scalar>& set, const OnlineOptions& options,
                        std::uint64_t seed);

/// Trains until state.status is set, at most `most_cycles` cycles. Returns the errors of the last cycle.
template <class Scalar>
CycleErrors train_online(OnlineState<Scalar>& state, const TrainingSet<Scalar>& set, const OnlineOptions& options,
                         std::uint64_t seed, int most_cycles);

}  // namespace tactel::nn
