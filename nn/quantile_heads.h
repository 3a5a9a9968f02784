// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "nn/weights.h"

namespace tactel::nn {

/// Returns the quantiles of S from the outputs o of the last layer, [3], each in (-1/2, 1/2). They cannot cross:
///   median = o_0 + 1/2,  upper = median + (o_1 + 1/2),  lower = median - (o_2 + 1/2).
/// The widths are logistic functions of the last layer's sums, as S is; they grow as softplus does where they are
/// small, and stay below 1, the range of S.
template <class Scalar>
Quantiles<Scalar> quantiles(const Vector<Scalar>& output) {
  const Scalar median = output(0) + Scalar(0.5);
  return {median, median + (output(1) + Scalar(0.5)), median - (output(2) + Scalar(0.5))};
}

/// Returns the pinball loss of a quantile (Koenker and Bassett 1978): its mean is least at the quantile `level`.
template <class Scalar>
Scalar pinball_loss(Scalar target, Scalar quantile, Scalar level) {
  return target < quantile ? (level - 1) * (target - quantile) : level * (target - quantile);
}

/// Returns the loss of a pattern: the pinball losses of the median, of the upper quantile at `level`, and of the
/// lower one at 1 - level. target: S.
template <class Scalar>
Scalar quantile_loss(const Vector<Scalar>& output, Scalar target, Scalar level) {
  const Quantiles<Scalar> q = quantiles(output);
  return pinball_loss(target, q.median, Scalar(0.5)) + pinball_loss(target, q.upper, level) +
         pinball_loss(target, q.lower, 1 - level);
}

/// Returns minus the derivatives of quantile_loss by the outputs, [3]. A quantile at `level` has
/// -dL/dq = level - [target < q].
template <class Scalar>
Vector<Scalar> quantile_errors(const Vector<Scalar>& output, Scalar target, Scalar level) {
  const Quantiles<Scalar> q = quantiles(output);
  const auto error = [target](Scalar quantile, Scalar its_level) {
    return its_level - (target < quantile ? Scalar(1) : Scalar(0));
  };
  const Scalar upper = error(q.upper, level), lower = error(q.lower, 1 - level);
  return Vector<Scalar>{{(error(q.median, Scalar(0.5)) + upper) + lower, upper, -lower}};
}

}  // namespace tactel::nn
