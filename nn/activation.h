// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <string_view>

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

/// Activation of a network's hidden neurons; its output neurons are logistic. `logistic`: f above. `leaky_relu`: z
/// above 0, else leak z (Maas, Hannun and Ng 2013).
enum class Activation { logistic, leaky_relu };

inline constexpr float leak = 0.01f;  ///< of the paper above, and the default of ONNX

const char* name(Activation activation);
/// Returns the activation named "logistic" or "leaky-relu". Throws ValueError, key "activation".
Activation parse_activation(std::string_view text);

template <class Scalar>
Scalar activation(Activation kind, Scalar z) {
  if (kind == Activation::logistic) return activation(z);
  return z > 0 ? z : Scalar(leak) * z;
}

/// Returns the slope at z, given f = activation(kind, z).
template <class Scalar>
Scalar activation_slope(Activation kind, Scalar f) {
  if (kind == Activation::logistic) return activation_slope(f);
  return f > 0 ? Scalar(1) : Scalar(leak);
}

}  // namespace tactel::nn
