// SPDX-License-Identifier: Apache-2.0
#include "nn/train_batch.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "fem/value_error.h"
#include "nn/quantile_heads.h"

namespace tactel::nn {

const char* name(BatchRule rule) { return rule == BatchRule::delta ? "delta" : "adam"; }

BatchRule parse_rule(std::string_view text) {
  if (text == "delta") return BatchRule::delta;
  if (text == "adam") return BatchRule::adam;
  throw ValueError("rule", std::string(text), "delta (delta rule with momentum) or adam");
}

void BatchOptions::validate() const {
  const auto check = [](const char* key, double value, bool good, const char* allowed) {
    if (!good) throw ValueError(std::string("training.") + key, std::to_string(value), allowed);
  };
  check("batch", batch, batch >= 1, "at least 1");
  check("rate", rate, rate > 0 && std::isfinite(rate), "finite and above 0");
  check("momentum", momentum, momentum >= 0 && momentum < 1, "at least 0 and below 1");
  check("level", level, level > 0.5 && level < 1, "above 0.5 and below 1: 0.95 for 95 %");
  check("beta1", beta1, beta1 >= 0 && beta1 < 1, "at least 0 and below 1");
  check("beta2", beta2, beta2 >= 0 && beta2 < 1, "at least 0 and below 1");
  check("epsilon", epsilon, epsilon > 0 && std::isfinite(epsilon), "finite and above 0");
}

template <class Scalar>
Weights<Scalar> mean_descent(const Weights<Scalar>& weights, const TrainingSet<Scalar>& set, const std::uint32_t* rows,
                             std::size_t count, CycleErrors& errors, double level) {
  Weights<Scalar> descent(weights.topology);
  for (std::size_t i = 0; i < count; ++i) {
    const Activations<Scalar> o = forward<Scalar>(weights, set.inputs.row(rows[i]).transpose());
    const Scalar error = set.target(rows[i]) - o.back()(0);
    errors.sse += static_cast<double>(error) * error;
    errors.largest = std::max(errors.largest, static_cast<double>(std::abs(error)));
    const Deltas<Scalar> delta =
        weights.topology.has_bound()
            ? backward(weights, o, quantile_errors(o.back(), set.target(rows[i]) + Scalar(0.5), Scalar(level)))
            : backward(weights, o, error);
    add_outer(o, delta, Scalar(1), descent);
  }
  for (Scalar& value : descent.values) value /= Scalar(count);
  return descent;
}

template <class Scalar>
void apply_update(BatchState<Scalar>& state, const Weights<Scalar>& descent, const BatchOptions& options) {
  ++state.updates;
  const double t = static_cast<double>(state.updates);
  const Scalar unbias1 = Scalar(1 / (1 - std::pow(options.beta1, t)));
  const Scalar unbias2 = Scalar(1 / (1 - std::pow(options.beta2, t)));
  for (std::size_t i = 0; i < descent.values.size(); ++i) {
    const Scalar g = descent.values[i];
    Scalar &first = state.first.values[i], &second = state.second.values[i];
    if (options.rule == BatchRule::delta) {
      first = Scalar(options.rate) * g + Scalar(options.momentum) * first;
      state.weights.values[i] += first;
    } else {
      first = Scalar(options.beta1) * first + Scalar(1 - options.beta1) * g;
      second = Scalar(options.beta2) * second + Scalar(1 - options.beta2) * g * g;
      const Scalar scale = std::sqrt(second * unbias2) + Scalar(options.epsilon);
      state.weights.values[i] += Scalar(options.rate) * (first * unbias1) / scale;
    }
  }
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
    apply_update(state, mean_descent(state.weights, set, order.data() + i, count, errors, options.level), options);
  }
  ++state.epoch;
  return errors;
}

template Weights<float> mean_descent(const Weights<float>&, const TrainingSet<float>&, const std::uint32_t*,
                                     std::size_t, CycleErrors&, double);
template Weights<double> mean_descent(const Weights<double>&, const TrainingSet<double>&, const std::uint32_t*,
                                      std::size_t, CycleErrors&, double);
template void apply_update(BatchState<float>&, const Weights<float>&, const BatchOptions&);
template void apply_update(BatchState<double>&, const Weights<double>&, const BatchOptions&);
template CycleErrors train_epoch(BatchState<float>&, const TrainingSet<float>&, const BatchOptions&, std::uint64_t);
template CycleErrors train_epoch(BatchState<double>&, const TrainingSet<double>&, const BatchOptions&, std::uint64_t);

}  // namespace tactel::nn
