// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <vector>

#include "bench/stepped_bowls.h"
#include "kernels/shared/pad_step_layout.h"
#include "tests/host/device/test_device.h"

namespace tactel::host {

using bench::Bowls;

inline const fem::PadSensor rubber{
    .tactels = {4, 4}, .pitch = {0.6, 0.6}, .thickness = 2, .young = 1.5, .poisson = 0.45};

template <class Real>
double number(const PadStepper<Real>& steps, std::size_t contact, int row) {
  return static_cast<double>(steps.results()[contact * STEP_RESULT_ROWS + static_cast<std::size_t>(row)]);
}

inline int flags_of(const PadStepper<float>& steps, std::size_t c) {
  return static_cast<int>(number(steps, c, STEP_RESULT_FLAGS));
}

inline std::vector<float> rows_of(const PadStepper<float>& steps, std::size_t contact) {
  const auto all = steps.results().subspan(contact * STEP_RESULT_ROWS, STEP_RESULT_ROWS);
  return {all.begin(), all.end()};
}

/// Bowls of which three of four lie over most of the grid.
inline Bowls covering(std::size_t count, unsigned seed) {
  Bowls bowls(count, seed);
  const auto cells = static_cast<std::size_t>(bowls.cells.count());
  for (std::size_t k = 0; k < bowls.heights.size(); ++k)
    if (k / cells % 4 != 0) bowls.heights[k] *= 0.25;
  return bowls;
}

/// Presses by motion, and returns the forces P.
inline std::vector<double> pressed(PadStepper<float>& steps, const Bowls& bowls) {
  for (int k = 0; k < 4; ++k) steps.move(bowls.pose(k));
  std::vector<double> P;
  for (std::size_t c = 0; c < bowls.count; ++c) P.push_back(number(steps, c, STEP_RESULT_P));
  return P;
}

}  // namespace tactel::host
