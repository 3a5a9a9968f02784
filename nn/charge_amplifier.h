// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace tactel::nn {

/// A charge amplifier with a resistance in parallel to its capacity (the paper, section III). The reading of a
/// constant stress decays with the time constant RC: v' = x' - v / RC. The solution is exact for an input that is
/// linear between samples. Input and output in MPa.
class ChargeAmplifier {
 public:
  /// time_constant: s, above 0; infinite: no decay. sample_time: s, above 0.
  ChargeAmplifier(double time_constant, double sample_time);
  double operator()(double stress);

 private:
  double decay_;  ///< of the output over a sample
  double rise_;   ///< of the output for the input's change within the sample
  double input_ = 0, output_ = 0;
};

/// A bipolar analog-to-digital converter, offset binary as on the board of the paper.
struct Converter {
  int bits = 12;            ///< 2 to 24
  double full_scale = 1.0;  ///< MPa: one step above the reading of the largest code

  double step() const;                  ///< MPa by code
  int zero() const;                     ///< code of no stress
  int operator()(double stress) const;  ///< nearest code, clipped at full scale. NaN reads as no stress
};

}  // namespace tactel::nn
