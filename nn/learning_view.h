// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "nn/input_scaling.h"

namespace tactel::nn {

/// The inputs of a network with features, by the rest or with friction, as it learns them: stresses and sums of frames
/// behind the newest are differences to the newest's, and every input is less its mean and over its deviation. The
/// network's file has the weights for the inputs themselves.
class LearningView {
 public:
  LearningView() = default;  ///< of other networks: changes nothing
  /// Means and deviations are those of the first rows of a learning set, frames [rows, numbers].
  LearningView(const InputScaling& scaling, const RowMatrix<float>& frames);

  bool empty() const { return mean_.empty(); }
  /// Changes the inputs of a frame in place, [inputs].
  template <class Scalar>
  void apply(Scalar* inputs) const noexcept;
  /// Returns the weights that give for inputs what `weights` give for what apply() makes of them.
  template <class Scalar>
  Weights<Scalar> weights_of_inputs(const Weights<Scalar>& weights) const;

 private:
  /// Calls use(place of an input behind the newest frame, place of the newest frame's).
  template <class Use>
  void each_difference(const Use& use) const;

  InputScaling scaling_;
  int numbers_ = 0;
  std::vector<float> mean_, deviation_;  ///< [inputs]
};

}  // namespace tactel::nn
