#pragma once
#include <cstdint>

#include "nn/forward.h"
#include "nn/frame_set.h"
#include "nn/presentation_order.h"

namespace tactel::nn {

/// Why a training ended.
enum class TrainStatus : std::uint8_t {
  running = 0,      ///< it has not
  learnt = 1,       ///< the largest error of a cycle fell below the stop error
  cycle_limit = 2,  ///< the limit of cycles was reached
  not_finite = 3,   ///< an error became NaN or infinite: the learning rate does not suit the set
};
const char* name(TrainStatus status);

/// The generalized delta rule in its original form, with the paper's numbers (sections V.B and V.E).
struct OnlineOptions {
  double rate = 0.1;
  double momentum = 0.9;
  double stop_error = 0.01;  ///< stop after a cycle in which no pattern's |error| reached this; 0 never stops
  int cycle_limit = 0;       ///< 0: the topology's own, 10 000 or 15 000
  PresentationOrder order = PresentationOrder::permuted;

  int cycles(const Topology& topology) const { return cycle_limit > 0 ? cycle_limit : topology.cycle_limit(); }
  void validate() const;  ///< throws ValueError, keys "training.rate", ...
};

/// What changes while a network learns: all that is needed to go on later to the same bits.
template <class Scalar>
struct OnlineState {
  explicit OnlineState(const Weights<float>& initial) : weights(initial), step(initial.topology) {}
  Weights<Scalar> weights;
  Weights<Scalar> step;  ///< the last change of each weight, which the momentum continues
  std::uint32_t cycle = 0;
  TrainStatus status = TrainStatus::running;
};

/// Errors of a cycle, each pattern's as it was shown, before its own change of the weights.
struct CycleErrors {
  double sse = 0;      ///< sum of (target - output)^2
  double largest = 0;  ///< largest |target - output|
};

/// One cycle: every pattern once; after each, step = rate delta o + momentum step, weights += step (Rumelhart, Hinton
/// and Williams 1986, eq. 16). Sets state.status when it is time to stop.
template <class Scalar>
CycleErrors train_cycle(OnlineState<Scalar>& state, const TrainingSet<Scalar>& set, const OnlineOptions& options,
                        std::uint64_t seed);

/// Cycles until state.status says stop, at most `most_cycles` of them. Returns the last cycle's errors.
template <class Scalar>
CycleErrors train_online(OnlineState<Scalar>& state, const TrainingSet<Scalar>& set, const OnlineOptions& options,
                         std::uint64_t seed, int most_cycles);

}  // namespace tactel::nn
