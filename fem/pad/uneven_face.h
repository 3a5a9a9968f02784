// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <span>
#include <vector>

#include "fem/pad/pad_cells.h"

namespace tactel::fem {

/// A smooth random height field of a face, mm about its mean plane, as a sum of plane waves: with wave vectors from a
/// normal distribution of deviation 1 / length and equal amplitudes it has the correlation exp(-r^2 / (2 length^2)).
/// It is a function of the face's own coordinates, so that it goes where the face goes.
struct UnevenFace {
  struct Wave {
    double kx = 0, ky = 0, phase = 0;  ///< rad/mm, rad
  };
  double amplitude = 0;  ///< mm, of each wave
  std::vector<Wave> waves{};

  /// Waves of an rms height (mm): each number of `normal` [2 waves] over `length` (mm) is a component of a wave vector,
  /// each of `phase` [waves] a phase.
  static UnevenFace of(double rms, double length, std::span<const double> normal, std::span<const double> phase);

  double height(double x, double y) const;
  /// Adds the heights at all cells [cells] of a grid: the face's origin lies at `place` (mm), turned by `angle` (rad).
  void add(const PadCells& cells, std::array<double, 2> place, double angle, std::span<double> heights) const;
};

}  // namespace tactel::fem
