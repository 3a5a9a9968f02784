// SPDX-License-Identifier: Apache-2.0
#include "nn/train_batch.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "fem/numbers/value_error.h"
#include "nn/quantile_heads.h"

namespace tactel::nn {

const char* name(BatchRule rule) { return rule == BatchRule::delta ? "delta" : "adam"; }

BatchRule parse_rule(std::string_view text) {
  if (text == "delta") return BatchRule::delta;
  if (text == "adam") return BatchRule::adam;
  throw ValueError("rule", std::string(text), "delta (delta rule with momentum) or adam");
}

const char* name(Loss loss) { return loss == Loss::squared ? "squared" : "absolute"; }

Loss parse_loss(std::string_view text) {
  if (text == "squared") return Loss::squared;
  if (text == "absolute") return Loss::absolute;
  throw ValueError("loss", std::string(text), "squared or absolute");
}

double BatchOptions::rate_of(std::uint64_t shown, std::size_t count) const {
  if (!cosine) return rate;
  const double middle = static_cast<double>(shown) + static_cast<double>(count) / 2;
  const double done = std::min(1.0, middle / static_cast<double>(planned_rows));
  if (done < warm_up) return rate * done / warm_up;
  return rate * (1 + std::cos(std::numbers::pi * (done - warm_up) / (1 - warm_up))) / 2;
}

double BatchOptions::share_of_mean(std::uint64_t t) const {
  return average > 0 ? (1 - average) / (1 - std::pow(average, static_cast<double>(t))) : 0;
}

void BatchOptions::validate() const {
  const auto check = [](const char* key, double value, bool good, const char* allowed) {
    if (!good) throw ValueError(std::string("training.") + key, std::to_string(value), allowed);
  };
  check("batch", batch, batch >= 1, "at least 1");
  check("rate", rate, rate > 0 && std::isfinite(rate), "finite and above 0");
  check("warm_up", warm_up, warm_up >= 0 && warm_up < 1, "a share of the training, at least 0 and below 1");
  check("average", average, average >= 0 && average < 1, "at least 0 and below 1: 0.9995 for some 2000 updates");
  check("momentum", momentum, momentum >= 0 && momentum < 1, "at least 0 and below 1");
  check("level", level, level > 0.5 && level < 1, "above 0.5 and below 1: 0.95 for 95 %");
  check("beta1", beta1, beta1 >= 0 && beta1 < 1, "at least 0 and below 1");
  check("beta2", beta2, beta2 >= 0 && beta2 < 1, "at least 0 and below 1");
  check("epsilon", epsilon, epsilon > 0 && std::isfinite(epsilon), "finite and above 0");
}

template <class Scalar>
Weights<Scalar> mean_descent(const Weights<Scalar>& weights, const TrainingSet<Scalar>& set, const std::uint32_t* rows,
                             std::size_t count, CycleErrors& errors, const BatchOptions& options) {
  Weights<Scalar> descent(weights.topology);
  for (std::size_t i = 0; i < count; ++i) {
    const Activations<Scalar> o = forward<Scalar>(weights, set.inputs.row(rows[i]).transpose());
    Scalar error = set.target(rows[i]) - o.back()(0);
    errors.sse += static_cast<double>(error) * error;
    errors.largest = std::max(errors.largest, static_cast<double>(std::abs(error)));
    if (options.loss == Loss::absolute) error = Scalar((error > 0) - (error < 0));
    const Deltas<Scalar> delta =
        weights.topology.has_bound()
            ? backward(weights, o, quantile_errors(o.back(), set.target(rows[i]) + Scalar(0.5), Scalar(options.level)))
            : backward(weights, o, error);
    add_outer(o, delta, Scalar(1), descent);
  }
  for (Scalar& value : descent.values) value /= Scalar(count);
  return descent;
}

template <class Scalar>
void apply_update(BatchState<Scalar>& state, const Weights<Scalar>& descent, const BatchOptions& options,
                  std::size_t count) {
  const auto rate = Scalar(options.rate_of(state.rows, count));
  ++state.updates, state.rows += count;
  const double t = static_cast<double>(state.updates);
  const Scalar unbias1 = Scalar(1 / (1 - std::pow(options.beta1, t)));
  const Scalar unbias2 = Scalar(1 / (1 - std::pow(options.beta2, t)));
  for (std::size_t i = 0; i < descent.values.size(); ++i) {
    const Scalar g = descent.values[i];
    Scalar &first = state.first.values[i], &second = state.second.values[i];
    if (options.rule == BatchRule::delta) {
      first = rate * g + Scalar(options.momentum) * first;
      state.weights.values[i] += first;
    } else {
      first = Scalar(options.beta1) * first + Scalar(1 - options.beta1) * g;
      second = Scalar(options.beta2) * second + Scalar(1 - options.beta2) * g * g;
      const Scalar scale = std::sqrt(second * unbias2) + Scalar(options.epsilon);
      state.weights.values[i] += rate * (first * unbias1) / scale;
    }
  }
  if (options.average == 0) return;
  if (state.mean.values.empty()) state.mean = state.weights;
  const auto share = Scalar(options.share_of_mean(state.updates));
  for (std::size_t i = 0; i < state.mean.values.size(); ++i)
    state.mean.values[i] += share * (state.weights.values[i] - state.mean.values[i]);
}

template <class Scalar>
CycleErrors train_epoch(BatchState<Scalar>& state, const TrainingSet<Scalar>& set, const BatchOptions& options,
                        std::uint64_t seed) {
  options.validate();
  CycleErrors errors;
  const auto rows = static_cast<std::uint32_t>(set.inputs.rows());
  const std::vector<std::uint32_t> order = presentation_order(options.order, seed, state.epoch, rows);
  for (std::size_t i = 0; i < order.size(); i += options.batch) {
    const std::size_t count = std::min<std::size_t>(options.batch, order.size() - i);
    apply_update(state, mean_descent(state.weights, set, order.data() + i, count, errors, options), options, count);
  }
  ++state.epoch;
  return errors;
}

template Weights<float> mean_descent(const Weights<float>&, const TrainingSet<float>&, const std::uint32_t*,
                                     std::size_t, CycleErrors&, const BatchOptions&);
template Weights<double> mean_descent(const Weights<double>&, const TrainingSet<double>&, const std::uint32_t*,
                                      std::size_t, CycleErrors&, const BatchOptions&);
template void apply_update(BatchState<float>&, const Weights<float>&, const BatchOptions&, std::size_t);
template void apply_update(BatchState<double>&, const Weights<double>&, const BatchOptions&, std::size_t);
template CycleErrors train_epoch(BatchState<float>&, const TrainingSet<float>&, const BatchOptions&, std::uint64_t);
template CycleErrors train_epoch(BatchState<double>&, const TrainingSet<double>&, const BatchOptions&, std::uint64_t);

}  // namespace tactel::nn
