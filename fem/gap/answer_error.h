// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>

namespace tactel::fem {

/// Error of an answer: the largest over the increments that the load requests.
struct AnswerError {
  double S = 0;  ///< of the slip index itself, which lies between -1 and 1
  double P = 0;  ///< over the path's largest P
  double Q =
      0;  ///< over the path's largest |Q|; of a pad over the larger of |Q| and |M| over the half size of the cells
  double M = 0;        ///< of a pad, over the half size of the cells, over the same
  double sigma = 0;    ///< at any tactel, over the largest |sigma_y| at any of them along the path; of a pad sigma_z
  double tau = 0;      ///< the same of tau_xy; of a pad of tau_x and tau_y
  double markers = 0;  ///< of a pad's markers, along x, y or z, over the largest displacement of any of them; 0: none
};
inline constexpr std::array<double AnswerError::*, 7> pad_error_members = {
    &AnswerError::S,     &AnswerError::P,   &AnswerError::Q,      &AnswerError::M,
    &AnswerError::sigma, &AnswerError::tau, &AnswerError::markers};

}  // namespace tactel::fem
