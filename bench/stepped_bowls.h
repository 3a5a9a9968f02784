// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <span>
#include <vector>

#include "fem/pad/pad_surface.h"
#include "host/contact/pads/pad_step.h"

namespace tactel::bench {

/// Bowls of two radii, turned, over 8 x 8 cells, and motions and wrenches for them: H = 1 mm, E = 1 MPa.
struct Bowls {
  Bowls(std::size_t count, unsigned seed) : count(count), random(seed) {
    for (std::size_t c = 0; c < count; ++c) {
      const double rx = std::exp(within(0.4, 2.1)), ry = std::exp(within(0.4, 2.1)), turn = within(0, 3.14);
      for (int i = 0; i < cells.count(); ++i) {
        const double x = cells.x(i / cells.n), y = cells.y(i % cells.n),
                     own_x = std::cos(turn) * x + std::sin(turn) * y, own_y = std::cos(turn) * y - std::sin(turn) * x;
        heights.push_back(own_x * own_x / (2 * rx) + own_y * own_y / (2 * ry));
      }
      friction.push_back(std::exp(within(-1.6, 0.2)));
      depth.push_back(std::min(0.2, 0.75 * 0.56 * 0.56 / (2 * std::max(rx, ry))));
    }
  }
  double within(double low, double high) { return std::uniform_real_distribution(low, high)(random); }

  /// Pose k of a way that presses in four steps, then wanders.
  std::vector<double> pose(int k) const {
    std::vector<double> all;
    for (std::size_t c = 0; c < count; ++c) {
      const double d = depth[c], phase = static_cast<double>(c), t = k - 3, size = k < 4 ? 0 : 0.5 * d;
      all.insert(all.end(),
                 {k < 4 ? 0.7 * d * (k + 1) / 4 : d * (0.7 + 0.2 * std::sin(0.3 * t)), size * std::sin(0.4 * t + phase),
                  size * std::sin(0.23 * t), 0.5 * size * std::sin(0.31 * t)});
    }
    return all;
  }
  /// Wrench k of a way on which Q goes to `top` of the cone, around the forces P.
  std::vector<double> wrench(int k, std::span<const double> P, double top) const {
    std::vector<double> all;
    for (std::size_t c = 0; c < count; ++c) {
      const double phase = 1.7 * static_cast<double>(c), p = P[c] * (1 + 0.25 * std::sin(0.13 * k + phase) * (k > 0)),
                   q = friction[c] * p * top * std::sin(0.11 * k + 0.3 * phase) * (k > 0),
                   turn = phase + 0.6 * std::sin(0.07 * k);
      all.insert(all.end(), {p, q * std::cos(turn), q * std::sin(turn), 0.075 * q * std::sin(0.09 * k)});
    }
    return all;
  }
  host::PadStepper<float> steps(host::Executor& on, StepOptions options = {}) const {
    options.cells = cells.n, options.cell = cells.hx;
    host::PadStepper<float> made(on, pad, count, friction, options);
    made.set_heights(std::span<const double>(heights));
    return made;
  }
  /// Takes these contacts alone.
  Bowls of(std::span<const std::size_t> which) const {
    Bowls some = *this;
    some.count = which.size(), some.heights.clear(), some.friction.clear(), some.depth.clear();
    const auto cell_count = static_cast<std::size_t>(cells.count());
    for (const std::size_t c : which) {
      some.heights.insert(some.heights.end(), &heights[c * cell_count], &heights[c * cell_count] + cell_count);
      some.friction.push_back(friction[c]), some.depth.push_back(depth[c]);
    }
    return some;
  }

  fem::PadSensor pad{.tactels = {4, 4}, .pitch = {0.3, 0.3}, .thickness = 1, .young = 1, .poisson = 0.45};
  fem::PadCells cells = fem::fixed_cells(8, 0.14);
  std::size_t count;
  std::mt19937 random;
  std::vector<double> heights, friction, depth;
};

}  // namespace tactel::bench
