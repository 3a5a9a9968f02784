// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <random>

#include "fem/pad/pad_scene.h"

namespace tactel::fem {

/// Random scenes of nine kinds of indenters: H 1 to 4 mm, nu 0.3 to 0.5, mu 0.1 to 1.5, depths 2 to 20 % of H, and
/// eight drags, straight, curved or back, half of them with twists. With `sensor` all have this one.
class PadMix {
 public:
  explicit PadMix(unsigned seed, const PadSensor* sensor = nullptr) : random_(seed), sensor_(sensor) {}

  PadScene operator()();  ///< the next one

 private:
  double in(double from, double to);
  double log_in(double from, double to);

  std::mt19937 random_;
  const PadSensor* sensor_;
  int kind_ = -1;
};

}  // namespace tactel::fem
