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

/// Loss of a pattern, of networks with one output: half the square of target - output, or its magnitude.
enum class Loss { squared, absolute };

const char* name(Loss loss);
/// Returns the loss named "squared" or "absolute". Throws ValueError, key "loss".
Loss parse_loss(std::string_view text);

struct BatchOptions {
  BatchRule rule = BatchRule::adam;
  int batch = 64;         ///< patterns to a change of the weights; the last batch of an epoch holds the remainder
  double rate = 1e-3;     ///< of the mean gradient; Adam's published default
  bool cosine = false;    ///< the rate rises over `warm_up` of planned_rows, then falls to 0 as half a cosine
                          ///< (Loshchilov and Hutter, "SGDR", ICLR 2017); else it is constant
  double warm_up = 0.02;  ///< `cosine`
  std::uint64_t planned_rows = 0;  ///< `cosine`: shown until the end of the training
  double momentum = 0.9;           ///< `delta`
  double level = 0.95;             ///< of the upper quantile of networks with a bound; the lower one's is 1 - level
  double beta1 = 0.9, beta2 = 0.999, epsilon = 1e-8;  ///< `adam`: the published defaults
  Loss loss = Loss::squared;
  double average = 0;  ///< decay, in an update, of the exponential mean of the weights (Polyak averaging); 0: none
  PresentationOrder order = PresentationOrder::permuted;
  /// Returns the learning rate of a batch of `count` rows after `shown` ones: that at its middle.
  double rate_of(std::uint64_t shown, std::size_t count) const;
  /// Returns the share of the weights after update t = 1, 2, ... in their mean, (1 - d) / (1 - d^t): the mean is free
  /// of bias from the first update on, as Adam's moments are. 0 without a mean.
  double share_of_mean(std::uint64_t t) const;
  void validate() const;  ///< throws ValueError, keys "training.batch", ...
};

template <class Scalar>
struct BatchState {
  explicit BatchState(const Weights<float>& initial)
      : weights(initial), first(initial.topology), second(initial.topology), mean(initial.topology) {
    mean.values.clear();
  }
  Weights<Scalar> weights;
  Weights<Scalar> first;   ///< `delta`: the last change of each weight; `adam`: first moment of the gradient
  Weights<Scalar> second;  ///< `adam`: second moment
  Weights<Scalar> mean;    ///< of the weights since the start; empty before the first update, and without a mean
  std::uint64_t updates = 0, rows = 0;  ///< so far; rows shown
  std::uint32_t epoch = 0;
  /// What was learnt: the mean of the weights where there is one.
  const Weights<Scalar>& result() const { return mean.values.empty() ? weights : mean; }
};

/// Returns the mean over `rows` of delta o: minus the gradient of the mean loss, or of quantile_loss at options.level
/// for a network with the heads of a bound. Adds the errors of the rows' S to `errors`.
template <class Scalar>
Weights<Scalar> mean_descent(const Weights<Scalar>& weights, const TrainingSet<Scalar>& set, const std::uint32_t* rows,
                             std::size_t count, CycleErrors& errors, const BatchOptions& options = {});

/// Changes the weights once, after a batch of `count` rows.
template <class Scalar>
void apply_update(BatchState<Scalar>& state, const Weights<Scalar>& descent, const BatchOptions& options,
                  std::size_t count = 1);

/// Trains one epoch: every pattern once, in the order of (seed, epoch). Returns its errors.
template <class Scalar>
CycleErrors train_epoch(BatchState<Scalar>& state, const TrainingSet<Scalar>& set, const BatchOptions& options,
                        std::uint64_t seed);

}  // namespace tactel::nn
