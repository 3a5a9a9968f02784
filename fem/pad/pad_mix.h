// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <random>
#include <vector>

#include "fem/pad/pad_scene.h"

namespace tactel::fem {

/// Uniform numbers, or uniform in their logarithm.
class RandomNumbers {
 public:
  explicit RandomNumbers(unsigned seed) : random_(seed) {}
  double in(double from, double to);
  double log_in(double from, double to);

 private:
  std::mt19937 random_;
};

/// Draws shape and tilt of an indenter of one kind on a layer H thick, mm.
using PadDraw = void (*)(PadIndenter& indenter, double H, RandomNumbers& random);
/// Returns the kinds, in the order of PadShape.
std::vector<PadDraw> pad_draws();

/// Random scenes of nine kinds of indenters: H 1 to 4 mm, nu 0.3 to 0.5, mu 0.1 to 1.5, depths 2 to 20 % of H, and
/// eight drags, straight, curved or back, half of them with twists. With `sensor` all have this one.
class PadMix {
 public:
  explicit PadMix(unsigned seed, const PadSensor* sensor = nullptr) : random_(seed), sensor_(sensor) {}

  PadScene operator()();  ///< the next one

 private:
  RandomNumbers random_;
  const PadSensor* sensor_;
  int kind_ = -1;
};

}  // namespace tactel::fem
