// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/infer.h>

#include <cmath>
#include <limits>
#include <span>

#include "nn/network.h"

namespace tactel::infer {

/// mu as a network that takes friction reads it from frames of one sensor in which the object slides.
class FrictionReading {
 public:
  static constexpr float spread = 0.15f;  ///< relative standard deviation of mu as read

  /// input: [network.inputs()] of such a frame, whose last two numbers are changed. Returns mu: the largest for which
  /// the network, told it within 5 %, reads an S of 0.97 or more; of several calls the geometric mean. NaN where the
  /// network takes no friction or has no answer. Allocates nothing.
  float next(const SlipEstimator& network, const nn::Learnt& learnt, std::span<float> input) noexcept {
    constexpr float sure = 0.05f, sliding = 0.97f, wider = 2;
    if (!network.takes_friction() || !(learnt.least_friction > 0)) return std::numeric_limits<float>::quiet_NaN();
    float* const told = input.data() + input.size() - 2;
    const auto answer = [&](double logarithm) {
      told[0] = static_cast<float>(std::exp(logarithm)), told[1] = sure;
      return network.estimate(input);
    };
    double low = std::log(learnt.least_friction / wider), high = std::log(learnt.most_friction * wider);
    if (answer(low).status != AnswerStatus::ok) return std::numeric_limits<float>::quiet_NaN();
    for (int halving = 0; halving < 12; ++halving) {  // S falls with mu
      const double middle = (low + high) / 2;
      (answer(middle).slip_index >= sliding ? low : high) = middle;
    }
    logarithms_ += low, ++readings_;
    return static_cast<float>(std::exp(logarithms_ / readings_));
  }
  void forget() noexcept { logarithms_ = 0, readings_ = 0; }

 private:
  double logarithms_ = 0;  ///< of mu, their sum over so many readings
  int readings_ = 0;
};

}  // namespace tactel::infer
