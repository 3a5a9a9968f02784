#pragma once
#include <array>
#include <vector>

#include "fem/contact_solution.h"
#include "fem/scene.h"
#include "host/ladder.h"

namespace tactel::host {

/// What is wrong with an answer: the largest difference from another one over the increments that the load asks for.
struct AnswerError {
  double S = 0;      ///< of Q / (mu P) itself, which lies between -1 and 1; 1 where only one of the two touches at all
  double P = 0;      ///< over the path's largest P
  double Q = 0;      ///< over the path's largest |Q|
  double sigma = 0;  ///< at any tactel, over the largest |sigma_y| at any of them along the path
  double tau = 0;    ///< the same of tau_xy
};
inline constexpr std::array<double AnswerError::*, 5> error_members = {
    &AnswerError::S, &AnswerError::P, &AnswerError::Q, &AnswerError::sigma, &AnswerError::tau};
inline constexpr std::array<const char*, 5> error_names = {"S", "P", "Q", "sigma", "tau"};

/// `answer` was made on `rung`, `judge` on `judge_rung`. The tactels at the very ends are left out: they stand where
/// the glued base meets the free side, where the exact stress is infinite.
AnswerError answer_error(const fem::Scene& scene, const fem::ContactSolution& answer, const Rung& rung,
                         const fem::ContactSolution& judge, const Rung& judge_rung);

/// Of many scenes: median, 95 % quantile, largest.
struct ErrorQuantiles {
  AnswerError median, most95, largest;
};
ErrorQuantiles quantiles(const std::vector<AnswerError>& errors);

/// The smallest of the values that a share of them does not exceed; 0 of none.
double quantile(std::vector<double> values, double share);

}  // namespace tactel::host
