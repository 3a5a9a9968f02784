// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "host/networks/forward.h"
#include "host/networks/training_plan.h"

namespace tactel::host {

/// The rows of a plan's validation set on a device, and each network's weights of the smallest error there.
template <class Real>
class Validation {
 public:
  /// networks: of the plan, in its order.
  Validation(Executor& executor, const TrainingPlan& plan, const nn::InputScaling& scaling, std::size_t networks);

  /// Returns the mean error of a network after a cycle, NaN where it has none, and notes it with the weights where none
  /// was smaller. weights: of whole frames (nn::weights_of_frames).
  double judge(std::size_t network, TrainedNetwork& its, const nn::Weights<Real>& weights);
  /// Returns whether a network has learnt for the plan's patience without a smaller error.
  bool in_vain(const TrainedNetwork& network) const;

  std::vector<Real>& best(std::size_t network) { return best_[network]; }  ///< empty before the first judgement
  const std::vector<Real>& best(std::size_t network) const { return best_[network]; }

 private:
  Executor& executor_;
  const nn::FrameSet& set_;
  int patience_;
  nn::InputScaling scaling_;
  DeviceFrames frames_;
  std::vector<std::pair<nn::Topology, Forward<Real>>> forward_;  ///< of the topologies judged so far
  std::vector<std::vector<Real>> best_;                          ///< [networks] weights
};

extern template class Validation<float>;
extern template class Validation<double>;

}  // namespace tactel::host
