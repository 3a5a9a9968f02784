// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "nn/frame_set.h"

namespace tactel::nn {

ErrorSummary summarize(std::span<const double> absolute_errors);

/// Returns |S of the network - S of the set| of every row; NaN where the network gave none. slip_index: [rows].
template <class Scalar>
std::vector<double> absolute_errors(const Vector<Scalar>& slip_index, const FrameSet& set) {
  std::vector<double> errors(set.rows());
  for (Eigen::Index row = 0; row < set.rows(); ++row)
    errors[row] = std::abs(static_cast<double>(slip_index(row)) - static_cast<double>(set.slip_index(row)));
  return errors;
}

/// Returns the class of a pad's row by the share of torque in S, 1 - |Q| / (mu P) / S: 1, 2 or 3 by thirds; 0 where S
/// is too small to have shares.
std::uint8_t torque_class(float slip_index, float force_ratio);
/// Returns "S below 0.05", "torque below 1/3", "torque 1/3 to 2/3", "torque above 2/3".
const char* torque_class_name(int torque_class);

/// Errors of a network on a set: in all, by kind of indenter, by touching nodes and by torque. Rows without a slippage
/// index are counted, not judged.
struct ErrorReport {
  ErrorSummary all;
  std::map<int, ErrorSummary> by_class;          ///< key: FrameSet::shape_class
  std::map<int, ErrorSummary> by_contact_nodes;  ///< key: FrameSet::contact_nodes
  std::map<int, ErrorSummary> by_torque;         ///< key: FrameSet::torque
  std::size_t without_answer = 0;                ///< rows whose error is NaN
};

/// Returns the report of errors [rows], as absolute_errors returns them.
ErrorReport report_errors(std::span<const double> errors, const FrameSet& set);

/// Returns quantile q in 0..1 of the values, linear between order statistics (definition 7 of Hyndman and Fan
/// 1996). Throws ValueError for an empty list or q outside 0..1.
double quantile(std::vector<double> values, double q);

}  // namespace tactel::nn
