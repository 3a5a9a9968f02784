// SPDX-License-Identifier: Apache-2.0
#include "host/networks/validation.h"

#include <algorithm>
#include <cmath>

#include "nn/metrics.h"

namespace tactel::host {

template <class Real>
Validation<Real>::Validation(Executor& executor, const TrainingPlan& plan, const nn::InputScaling& scaling,
                             std::size_t networks)
    : executor_(executor),
      set_(*plan.validation),
      patience_(plan.patience),
      scaling_(scaling),
      frames_(executor.device(), set_.frames),
      best_(networks) {}

template <class Real>
double Validation<Real>::judge(std::size_t network, TrainedNetwork& its, const nn::Weights<Real>& weights) {
  auto found = std::ranges::find(forward_, its.topology, [](const auto& known) { return known.first; });
  if (found == forward_.end())
    found = forward_.emplace(found, its.topology, Forward<Real>(executor_, std::span(&weights, 1), scaling_));
  Forward<Real>& forward = found->second;
  forward.set_network(0, weights);
  forward.run(frames_);
  const bool good = its.status != nn::TrainStatus::not_finite && nn::all_finite(weights);
  const nn::ErrorSummary errors = nn::report_errors(nn::absolute_errors(forward.result(0).slip_index, set_), set_).all;
  const double error = good && errors.count > 0 ? errors.mean : NAN;
  if (!(error < its.best_error)) return error;
  its.best_error = error;
  its.best_cycle = its.cycles;
  best_[network] = weights.values;
  return error;
}

template <class Real>
bool Validation<Real>::in_vain(const TrainedNetwork& network) const {
  return patience_ > 0 && network.running() &&
         network.cycles - network.best_cycle >= static_cast<std::uint32_t>(patience_);
}

template class Validation<float>;
template class Validation<double>;

}  // namespace tactel::host
