// SPDX-License-Identifier: Apache-2.0
#include "nn/charge_amplifier.h"

#include <algorithm>
#include <cmath>

namespace tactel::nn {

ChargeAmplifier::ChargeAmplifier(double time_constant, double sample_time) {
  const double x = sample_time / time_constant;
  decay_ = std::exp(-x);
  rise_ = x > 0 ? -std::expm1(-x) / x : 1.0;
}

double ChargeAmplifier::operator()(double stress) {
  output_ = decay_ * output_ + rise_ * (stress - input_);
  input_ = stress;
  return output_;
}

double Converter::step() const { return full_scale / zero(); }

int Converter::zero() const { return 1 << (bits - 1); }

int Converter::operator()(double stress) const {
  if (std::isnan(stress)) return zero();
  const double code = std::round(std::clamp(stress / step(), -2.0 * zero(), 2.0 * zero())) + zero();
  return static_cast<int>(std::clamp(code, 0.0, 2.0 * zero() - 1));
}

}  // namespace tactel::nn
