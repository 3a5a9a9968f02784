// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string_view>

#include "nn/train_online.h"

namespace tactel::nn {

/// Rule that turns the mean gradient of a mini-batch into a change of the weights. `delta`: the delta rule with
/// momentum; `adam`: Kingma and Ba, "Adam: a method for stochastic optimization", ICLR 2015, algorithm 1.
enum class BatchRule { delta, adam };

const char* name(BatchRule rule);
/// Returns the rule named "delta" or "adam". Throws ValueError, key "rule".
BatchRule parse_rule(std::string_view text);

struct BatchOptions {
  BatchRule rule = BatchRule::adam;
  int batch = 64;         ///< patterns to a change of the weights; the last batch of an epoch holds the remainder
  double rate = 1e-3;     ///< of the mean gradient; Adam's published default
  double momentum = 0.9;  ///< `delta`
  double level = 0.95;    ///< of the upper quantile of networks with a bound; the lower one's is 1 - level
  double beta1 = 0.9, beta2 = 0.999, epsilon = 1e-8;  ///< `adam`: the published defaults
  PresentationOrder order = PresentationOrder::permuted;
  void validate() const;  ///< throws ValueError, keys "training.batch", ...
};

template <class Scalar>
struct BatchState {
  explicit BatchState(const Weights<float>& initial)
      : weights(initial), first(initial.topology), second(initial.topology) {}
  Weights<Scalar> weights;
  Weights<Scalar> first;   ///< `delta`: the last change of each weight; `adam`: first moment of the gradient
  Weights<Scalar> second;  ///< `adam`: second moment
  std::uint64_t updates = 0;
  std::uint32_t epoch = 0;
};

/// Returns the mean over `rows` of delta o: minus the gradient of the mean of 1/2 (target - output)^2, or of
/// quantile_loss at `level` for a network with the heads of a bound. Adds the errors of the rows' S to `errors`.
template <class Scalar>
Weights<Scalar> mean_descent(const Weights<Scalar>& weights, const TrainingSet<Scalar>& set, const std::uint32_t* rows,
                             std::size_t count, CycleErrors& errors, double level = BatchOptions{}.level);

/// Changes the weights once.
template <class Scalar>
void apply_update(BatchState<Scalar>& state, const Weights<Scalar>& descent, const BatchOptions& options);

/// Trains one epoch: every pattern once, in the order of (seed, epoch). Returns its errors.
template <class Scalar>
CycleErrors train_epoch(BatchState<Scalar>& state, const TrainingSet<Scalar>& set, const BatchOptions& options,
                        std::uint64_t seed);

}  // namespace tactel::nn
