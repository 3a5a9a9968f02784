// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "host/figures/page.h"
#include "host/studies/paper/inverse_problem.h"
#include "nn/shear_ratio.h"

namespace tactel::host {

/// What Table II is to be read beside: an estimator without a network, and how many rows the two sets share.

/// S = c times the shear ratio of a frame (nn/shear_ratio.h), c fitted on the learning set.
struct ShearRatioStudy {
  nn::RatioFit fit = nn::RatioFit::median;
  double factor = 0;  ///< c
  nn::ErrorReport learning, recalling;
};
/// Returns a study for each way of fitting.
std::vector<ShearRatioStudy> study_shear_ratio(const InverseSets& sets);

/// Rows of which another row has the same frame, to 1e-6 of its largest stress.
struct SharedRows {
  std::size_t learning = 0, distinct = 0;      ///< rows of the learning set; different frames among them
  std::size_t recall = 0, recalled_again = 0;  ///< rows of the recall set; those whose frame is in the learning set
};
SharedRows shared_rows(const nn::FrameSet& learning, const nn::FrameSet& recall);

struct InverseBaselines {
  std::vector<ShearRatioStudy> one_friction;      ///< on the paper's sets
  std::vector<double> frictions;                  ///< mu of the sets below
  std::vector<ShearRatioStudy> unknown_friction;  ///< on the same contacts with each of these mu
  SharedRows shared;
};
/// Simulates the sets of unknown friction, and fits the estimators.
InverseBaselines inverse_baselines(Executor& executor, const InverseChoice& choice, const InverseSets& sets);

/// Returns estimators.json: c and errors of the estimators, and the shared rows.
nlohmann::ordered_json baselines_json(const InverseBaselines& baselines);

/// Adds the estimators beside the networks, and the shared rows, to the report.
void report_baselines(Page& page, const InverseBaselines& baselines, const InverseProblem& problem);

}  // namespace tactel::host
