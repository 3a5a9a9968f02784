// SPDX-License-Identifier: Apache-2.0
#include "nn/features.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tactel::nn {
namespace {

/// Tactels of a frame; of a line one row.
struct Grid {
  int columns, rows;
  int tactels() const { return columns * rows; }
};

/// Swaps left and right of each of so many planes of tactels.
template <class Real>
void mirror_x(const Grid& grid, int planes, Real* plane) noexcept {
  for (int row = 0; row < planes * grid.rows; ++row, plane += grid.columns) std::reverse(plane, plane + grid.columns);
}
template <class Real>
void mirror_y(const Grid& grid, int planes, Real* plane) noexcept {
  for (int k = 0; k < planes; ++k, plane += grid.tactels())
    for (int j = 0; j < grid.rows / 2; ++j)
      std::swap_ranges(plane + j * grid.columns, plane + (j + 1) * grid.columns,
                       plane + (grid.rows - 1 - j) * grid.columns);
}
template <class Real>
void exchange(const Grid& grid, int planes, Real* plane) noexcept {
  for (int k = 0; k < planes; ++k, plane += grid.tactels())
    for (int j = 0; j < grid.rows; ++j)
      for (int i = 0; i < j; ++i) std::swap(plane[j * grid.columns + i], plane[i * grid.columns + j]);
}
template <class Real>
void negate(Real* from, int count) noexcept {
  for (int k = 0; k < count; ++k) from[k] = -from[k];
}
template <class Real>
Real sum_of(const Real* from, int count) noexcept {
  Real sum = 0;
  for (int k = 0; k < count; ++k) sum = sum + from[k];
  return sum;
}

/// Brings all frames to the image that the newest frame's Q chooses.
template <class Real>
void make_canonical(const InputScaling& scaling, const Grid& grid, Real* x) noexcept {
  const int n = grid.tactels(), axes = scaling.axes;
  const Real qx = sum_of(x + n, n), qy = axes == 3 ? sum_of(x + 2 * n, n) : Real(0);
  const bool turn = scaling.square && std::abs(qy) > std::abs(qx);
  for (int frame = 0; frame < scaling.shown(); ++frame, x += axes * n) {
    if (qx < 0) mirror_x(grid, axes, x), negate(x + n, n);
    if (qy < 0) mirror_y(grid, axes, x), negate(x + 2 * n, n);
    if (turn) exchange(grid, axes, x), std::swap_ranges(x + n, x + 2 * n, x + 2 * n);
  }
}

template <class Real>
void put_sums(const InputScaling& scaling, const Grid& grid, const Real* x, Real* out) noexcept {
  const int n = grid.tactels();
  const bool pad = scaling.features == Features::pad;
  const Real least(least_divisor), zero(0);
  const Real middle_x = Real(grid.columns - 1) / 2, middle_y = Real(grid.rows - 1) / 2;
  const Real *tx = x + n, *ty = x + 2 * n;
  const auto shear = [&](int k) { return pad ? std::sqrt(tx[k] * tx[k] + ty[k] * ty[k]) : std::abs(tx[k]); };
  Real P = 0, Qx = 0, Qy = 0, w = 0, wx = 0, wy = 0, T = 0;
  for (int j = 0, k = 0; j < grid.rows; ++j)
    for (int i = 0; i < grid.columns; ++i, ++k) {
      const Real p = std::max(-x[k], zero);
      P = P - x[k];
      w = w + p;
      wx = wx + p * (Real(i) - middle_x);
      wy = wy + p * (Real(j) - middle_y);
      Qx = Qx + tx[k];
      if (pad) Qy = Qy + ty[k];
      T = T + shear(k);
    }
  const Real by_p = std::max(P, least), by_w = std::max(w, least), by_t = std::max(T, least);
  const Real cx = wx / by_w, cy = wy / by_w;
  const Real q = std::sqrt(Qx * Qx + Qy * Qy), by_q = std::max(q, least);
  const Real ux = Qx / by_q, uy = Qy / by_q;
  Real M = 0, pxx = 0, pyy = 0, pxy = 0, txx = 0, tyy = 0, ax = 0, ay = 0;
  for (int j = 0, k = 0; j < grid.rows; ++j)
    for (int i = 0; i < grid.columns; ++i, ++k) {
      const Real dx = (Real(i) - middle_x) - cx, dy = (Real(j) - middle_y) - cy;
      const Real p = std::max(-x[k], zero), t = shear(k);
      pxx = pxx + p * dx * dx;
      txx = txx + t * dx * dx;
      if (!pad) {
        ax = ax + tx[k] * dx;
        continue;
      }
      M = M + (dx * ty[k] - dy * tx[k]);
      pyy = pyy + p * dy * dy;
      pxy = pxy + p * dx * dy;
      tyy = tyy + t * dy * dy;
      const Real along = tx[k] * ux + ty[k] * uy;
      ax = ax + along * dx;
      ay = ay + along * dy;
    }
  if (pad) {
    const Real all[] = {P,          Qx,         Qy,         q / by_p, Qx / by_p,  Qy / by_p,  M / by_p, cx, cy,
                        pxx / by_w, pyy / by_w, pxy / by_w, T / by_p, txx / by_t, tyy / by_t, ax,       ay};
    std::copy(std::begin(all), std::end(all), out);
  } else {
    const Real all[] = {P, Qx, Qx / by_p, cx, pxx / by_w, T / by_p, txx / by_t, ax};
    std::copy(std::begin(all), std::end(all), out);
  }
}

}  // namespace

template <class Real>
void add_features(const InputScaling& scaling, int numbers, Real peak, Real* x) noexcept {
  const int n = scaling.normals(numbers);
  const Grid grid{scaling.columns, n / scaling.columns};
  make_canonical(scaling, grid, x);
  Real* out = x + scaling.shown() * scaling.axes * n;
  for (int frame = 0; frame < scaling.shown(); ++frame, out += scaling.sums())
    put_sums(scaling, grid, x + frame * scaling.axes * n, out);
  if (scaling.has_peak()) *out = peak / (peak + Real(scaling.usual_stress));
}

template <class Real>
bool take_differences_to_rest(const InputScaling& scaling, int numbers, const float* frames, Real* x) noexcept {
  const int width = scaling.width(numbers), shown = width * scaling.shown();
  const float* const rest = frames + shown;
  const auto small = [](float stress) { return Real(stress) * Real(InputScaling::rest_scale); };
  Real P(0);
  for (int k = 0; k < scaling.normals(numbers); ++k) P = P - small(rest[k]);
  if (!(P >= small(InputScaling::smallest_stress))) return false;
  const Real factor = Real(1) / P;
  for (int first = 0; first < shown; first += width)
    for (int k = 0; k < width; ++k) x[first + k] = (small(frames[first + k]) - small(rest[k])) * factor;
  if (scaling.features != Features::frame) add_features(scaling, numbers, Real(0), x);
  return true;
}

template void add_features(const InputScaling&, int, float, float*) noexcept;
template void add_features(const InputScaling&, int, double, double*) noexcept;
template bool take_differences_to_rest(const InputScaling&, int, const float*, float*) noexcept;
template bool take_differences_to_rest(const InputScaling&, int, const float*, double*) noexcept;

}  // namespace tactel::nn
