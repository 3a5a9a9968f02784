// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>

namespace tactel::nn {

/// Returns f(z) = 1/2 (1 - e^-z) / (1 + e^-z) (paper, section V.A), computed as 1/2 tanh(z/2). The printed form
/// is inf/inf for z < -88.7 in fp32. Values lie in (-0.5, 0.5); the slippage index is the output + 0.5.
template <class Scalar>
Scalar activation(Scalar z) {
  return Scalar(0.5) * std::tanh(Scalar(0.5) * z);
}

/// Returns f'(z), given f = f(z).
template <class Scalar>
Scalar activation_slope(Scalar f) {
  return Scalar(0.25) - f * f;
}

}  // namespace tactel::nn
