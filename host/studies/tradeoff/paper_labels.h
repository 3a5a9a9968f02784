// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/device/executor.h"
#include "host/figures/plot.h"
#include "host/scenes/ladder.h"

namespace tactel::host {

/// Errors of one number over many labels.
struct LabelError {
  double median = 0, most95 = 0, largest = 0;
};

/// Labels of some contacts of the paper's sets beside the judge. A label is S at a load step from full indentation
/// on, as the rows of a set are.
struct LabelGroup {
  std::string what;  ///< "learning set", or "learning set, 1 to 3 nodes touch"
  std::size_t contacts = 0, labels = 0;
  double bias = 0;                        ///< mean of S of the set less S of the judge
  LabelError mesh{}, patch{};             ///< of S: on the paper's mesh, as the sets have it, and on `usual_patch`
  double inner_sigma = 0, inner_tau = 0;  ///< of the mesh's stresses, 95 % of the labels, over the contact's largest;
                                          ///< at any tactel but the two at the very ends
  double end_sigma = 0, end_tau = 0;      ///< the same at these two
};

struct PaperLabels {
  std::size_t unjudged = 0;                     ///< contacts that the judge did not solve; left out
  std::vector<LabelGroup> groups{};             ///< both sets, by nodes that touch and by class of shape
  std::vector<double> learning{}, recalling{};  ///< |error of S| of each label
};

/// Solves the paper's learning and recall sets (host/scenes/paper_sets.h) on the paper's mesh, on patches and by the
/// judge. `progress`: false stops; throws Stopped then.
PaperLabels measure_paper_labels(Executor& executor, const std::function<bool(std::size_t, std::size_t)>& progress = {},
                                 const Rung& judge = ladder().back());

nlohmann::ordered_json to_json(const PaperLabels& labels);
/// Returns the table for a terminal.
std::string labels_table(const PaperLabels& labels);
/// Returns a figure of the share of labels over their error in S.
Figure labels_figure(const PaperLabels& labels);

}  // namespace tactel::host
