// SPDX-License-Identifier: Apache-2.0
#include "fem/numbers/banded_lu.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactel::fem {
namespace {

// The diagonal is kept unless another candidate is this much larger: nearly all rows belong to a symmetric positive
// definite stiffness, which needs no exchange, and each exchange widens the band.
constexpr double diagonal_preference = 10.0;

void subtract_multiple(double* target, const double* source, double factor, int count) {
  for (int j = 0; j < count; ++j) target[j] -= factor * source[j];
}

}  // namespace

BandedLu::BandedLu(int size, int band)
    : size_(size),
      band_(band),
      stride_(std::size_t(3 * band + 1)),
      row_(std::size_t(size) * stride_, 0.0),
      end_(std::size_t(size)),
      pivot_(std::size_t(size)) {
  for (int i = 0; i < size; ++i) end_[i] = std::min(size, i + band + 1);
}

int BandedLu::choose_pivot(int column, int last) const {
  int best = column;
  double largest = diagonal_preference * std::abs(row_[place(column, column)]);
  for (int i = column + 1; i < last; ++i) {
    const double candidate = std::abs(row_[place(i, column)]);
    if (candidate > largest) best = i, largest = candidate;
  }
  return best;
}

void BandedLu::exchange(int row, int other) {
  // Multipliers stay where they are: solve() exchanges right sides in the same order.
  const int end = std::max(end_[row], end_[other]);
  std::swap_ranges(&row_[place(row, row)], &row_[place(row, row)] + (end - row), &row_[place(other, row)]);
  std::swap(end_[row], end_[other]);
}

bool BandedLu::factor() {
  double largest = 0;
  for (int k = 0; k < size_; ++k) {
    const int last = std::min(size_, k + band_ + 1);
    pivot_[k] = choose_pivot(k, last);
    if (pivot_[k] != k) exchange(k, pivot_[k]);
    const double pivot = row_[place(k, k)];
    largest = std::max(largest, std::abs(pivot));
    if (!(std::abs(pivot) > 16 * std::numeric_limits<double>::epsilon() * largest)) return false;
    const double* source = &row_[place(k, k)] + 1;
    for (int i = k + 1; i < last; ++i) {
      double* target = &row_[place(i, k)];
      if (*target == 0) continue;
      *target /= pivot;
      subtract_multiple(target + 1, source, *target, end_[k] - k - 1);
      end_[i] = std::max(end_[i], end_[k]);
    }
  }
  return true;
}

void BandedLu::solve(Eigen::Ref<RowMatrix> right_side) const {
  for (int k = 0; k < size_; ++k) {
    if (pivot_[k] != k) right_side.row(k).swap(right_side.row(pivot_[k]));
    for (int i = k + 1; i < std::min(size_, k + band_ + 1); ++i) {
      const double factor = row_[place(i, k)];
      if (factor != 0) right_side.row(i) -= factor * right_side.row(k);
    }
  }
  for (int k = size_ - 1; k >= 0; --k) {
    for (int j = k + 1; j < end_[k]; ++j) right_side.row(k) -= row_[place(k, j)] * right_side.row(j);
    right_side.row(k) /= row_[place(k, k)];
  }
}

}  // namespace tactel::fem
