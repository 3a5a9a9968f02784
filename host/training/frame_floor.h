// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace tactel::host {

/// Rows of contacts of SourceOf::changed, by contact, then step.
struct ChangedRows {
  int inputs = 0;                             ///< numbers of a frame
  std::uint64_t changes = 1;                  ///< contacts to one of the source
  double shift = 0;                           ///< of a number's range
  std::span<const float> frames, slip_index;  ///< [rows, inputs] MPa; [rows]
  std::span<const std::uint64_t> contact;     ///< [rows]
  std::span<const std::uint32_t> step;        ///< [rows]
  std::span<const std::uint8_t> status;       ///< [rows]
};

/// Readings of unchanged rows.
struct Readings {
  std::vector<std::int64_t> rows;  ///< [readings, frames of a reading], the newest first; -1: zeros
  std::vector<double> sigma;       ///< [readings] MPa, standard deviation of the noise
  double gain = 0;                 ///< standard deviation of the transducers' gains about 1
};

/// Returns the mean of |error of S| of the best reader of each reading, where frames and S are linear in the drawn
/// numbers, each uniform over its range (variance 1/12): sqrt(2 / pi) sd with sd^2 = g' (J' C^-1 J + 12 I)^-1 g, J and
/// g the derivatives of frames and S, C the covariance of noise and gains.
std::vector<double> linear_errors(const ChangedRows& rows, const Readings& readings);

}  // namespace tactel::host
