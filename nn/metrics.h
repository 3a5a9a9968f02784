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

/// Errors of a network on a set: in all, by kind of indenter and by touching nodes. Rows without a slippage index
/// are counted, not judged.
struct ErrorReport {
  ErrorSummary all;
  std::map<int, ErrorSummary> by_class;          ///< key: FrameSet::shape_class
  std::map<int, ErrorSummary> by_contact_nodes;  ///< key: FrameSet::contact_nodes
  std::size_t without_answer = 0;                ///< rows whose error is NaN
};

/// Returns the report of errors [rows], as absolute_errors returns them.
ErrorReport report_errors(std::span<const double> errors, const FrameSet& set);

/// Returns quantile q in 0..1 of the values, linear between order statistics (definition 7 of Hyndman and Fan
/// 1996). Throws ValueError for an empty list or q outside 0..1.
double quantile(std::vector<double> values, double q);

}  // namespace tactel::nn
