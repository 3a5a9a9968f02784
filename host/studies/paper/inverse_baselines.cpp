// SPDX-License-Identifier: Apache-2.0
#include "host/studies/paper/inverse_baselines.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace tactel::host {
namespace {

/// Where mu is unknown: the paper's 0.4 and its neighbours from ice to rubber.
const std::vector<double> unknown_frictions = {0.1, 0.2, 0.4, 0.7, 1.0};

/// True where the frames differ by rounding alone.
bool same(const nn::FrameSet& a, Eigen::Index row_a, const nn::FrameSet& b, Eigen::Index row_b) {
  const auto x = a.frames.row(row_a), y = b.frames.row(row_b);
  return (x - y).cwiseAbs().maxCoeff() <= 1e-6f * y.cwiseAbs().maxCoeff();
}

nn::FrameSet joined(const std::vector<nn::FrameSet>& sets) {
  Eigen::Index rows = 0;
  for (const nn::FrameSet& set : sets) rows += set.rows();
  nn::FrameSet all{.frames = nn::RowMatrix<float>(rows, sets.front().frames.cols()),
                   .slip_index = nn::Vector<float>(rows),
                   .shape_class = {},
                   .contact_nodes = {}};
  Eigen::Index first = 0;
  for (const nn::FrameSet& set : sets) {
    all.frames.middleRows(first, set.rows()) = set.frames;
    all.slip_index.segment(first, set.rows()) = set.slip_index;
    first += set.rows();
  }
  return all;
}

std::vector<ShearRatioStudy> study_shear_ratio(const nn::FrameSet& learning, const nn::FrameSet& recall) {
  std::vector<ShearRatioStudy> studies;
  for (const nn::RatioFit fit : {nn::RatioFit::median, nn::RatioFit::least_squares}) {
    const double c = nn::fit_shear_ratio(learning, fit);
    const auto report = [&](const nn::FrameSet& set) { return nn::report_errors(nn::shear_ratio_errors(set, c), set); };
    studies.push_back({.fit = fit, .factor = c, .learning = report(learning), .recalling = report(recall)});
  }
  return studies;
}

const char* name(nn::RatioFit fit) { return fit == nn::RatioFit::median ? "median ratio" : "least squares"; }

void add_row(PageTable& table, const ShearRatioStudy& study, const std::string& sets) {
  table.add({fmt::format("S = {:.3f} r, c by {}", study.factor, name(study.fit)), sets,
             fmt::format("{:.4f}", study.learning.all.mean), fmt::format("{:.3f}", study.learning.all.max),
             fmt::format("{:.4f}", study.recalling.all.mean), fmt::format("{:.3f}", study.recalling.all.max)});
}

nlohmann::ordered_json studies_json(const std::vector<ShearRatioStudy>& studies) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  const auto errors = [](const nn::ErrorReport& report) {
    return nlohmann::ordered_json{{"mean", report.all.mean}, {"max", report.all.max}, {"std", report.all.std}};
  };
  for (const ShearRatioStudy& study : studies)
    json.push_back({{"fit", name(study.fit)},
                    {"c", study.factor},
                    {"learning", errors(study.learning)},
                    {"recalling", errors(study.recalling)}});
  return json;
}

}  // namespace

std::vector<ShearRatioStudy> study_shear_ratio(const InverseSets& sets) {
  return study_shear_ratio(sets.learning, sets.recall);
}

SharedRows shared_rows(const nn::FrameSet& learning, const nn::FrameSet& recall) {
  SharedRows shared{.learning = static_cast<std::size_t>(learning.rows()),
                    .distinct = 0,
                    .recall = static_cast<std::size_t>(recall.rows()),
                    .recalled_again = 0};
  const auto is_among = [&](const nn::FrameSet& set, Eigen::Index row, Eigen::Index count) {
    for (Eigen::Index k = 0; k < count; ++k)
      if (same(learning, k, set, row)) return true;
    return false;
  };
  for (Eigen::Index row = 0; row < learning.rows(); ++row) shared.distinct += !is_among(learning, row, row);
  for (Eigen::Index row = 0; row < recall.rows(); ++row)
    shared.recalled_again += is_among(recall, row, learning.rows());
  return shared;
}

InverseBaselines inverse_baselines(Executor& executor, const InverseChoice& choice, const InverseSets& sets) {
  InverseBaselines baselines{.one_friction = study_shear_ratio(sets),
                             .frictions = unknown_frictions,
                             .unknown_friction = {},
                             .shared = shared_rows(sets.learning, sets.recall)};
  std::vector<nn::FrameSet> learning, recall;
  for (const double mu : baselines.frictions) {
    InverseChoice other = choice;
    other.base.friction = mu;
    InverseSets simulated = simulate_sets(executor, other);
    learning.push_back(std::move(simulated.learning));
    recall.push_back(std::move(simulated.recall));
  }
  baselines.unknown_friction = study_shear_ratio(joined(learning), joined(recall));
  return baselines;
}

nlohmann::ordered_json baselines_json(const InverseBaselines& baselines) {
  return {{"one_friction", studies_json(baselines.one_friction)},          {"frictions", baselines.frictions},
          {"unknown_friction", studies_json(baselines.unknown_friction)},  {"learning_rows", baselines.shared.learning},
          {"distinct_learning_frames", baselines.shared.distinct},         {"recall_rows", baselines.shared.recall},
          {"recall_rows_in_learning_set", baselines.shared.recalled_again}};
}

void report_baselines(Page& page, const InverseBaselines& baselines, const InverseProblem& problem) {
  page.paragraph(fmt::format(
      "An estimator without a network: S = c r, where r is a frame's sum of shear stresses over its sum of |normal "
      "stresses|, and c is one number fitted on the learning set. Its sums are nearly the forces, and S = Q / (mu P): "
      "with the single friction {:g} of the paper's sets c is about 1 / mu. With friction that nobody knows one c "
      "cannot "
      "do it. A network is worth its work there.",
      problem.sets.learning_contacts.friction.empty() ? 0.0 : problem.sets.learning_contacts.friction.front()));
  PageTable table{
      .caption = "Networks without noise beside the estimator without a network (networks: median over seeds)",
      .head = {"estimator", "friction", "learning: mean error", "largest", "recalling: mean error", "largest"}};
  for (const NetworkStudy& study : problem.studies) {
    if (study.noise != 0) continue;
    table.add({fmt::format("network {} ({})", study.number, study.topology.text()), "the paper's",
               fmt::format("{:.4f}", spread(study.learning, mean_error).median),
               fmt::format("{:.3f}", spread(study.learning, max_error).median),
               fmt::format("{:.4f}", spread(study.recalling, mean_error).median),
               fmt::format("{:.3f}", spread(study.recalling, max_error).median)});
  }
  for (const ShearRatioStudy& study : baselines.one_friction) add_row(table, study, "the paper's");
  for (const ShearRatioStudy& study : baselines.unknown_friction)
    add_row(table, study, fmt::format("one of {}", fmt::join(baselines.frictions, ", ")));
  page.table(table);
  const SharedRows& shared = baselines.shared;
  page.note(
      fmt::format("The sets repeat: {} of the {} recalled rows have the frame of a row of the learning set (to 1e-6 of "
                  "its largest stress), and "
                  "the {} rows of the learning set have {} different frames.",
                  shared.recalled_again, shared.recall, shared.learning, shared.distinct));
}

}  // namespace tactel::host
