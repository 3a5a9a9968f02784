// SPDX-License-Identifier: Apache-2.0
#include "host/training/calibration.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "fem/value_error.h"
#include "host/networks/forward.h"
#include "host/support/errors.h"
#include "host/training/bound_report.h"

namespace tactel::host {
namespace {

/// Rows with an answer of the network.
std::vector<nn::CalibrationRow> calibration_rows(const nn::Recall<float>& answer, const nn::FrameSet& frames,
                                                 const nn::RowMatrix<float>& scaled) {
  std::vector<nn::CalibrationRow> rows;
  for (Eigen::Index row = 0; row < frames.rows(); ++row)
    if (answer.status[static_cast<std::size_t>(row)] == nn::FrameStatus::ok)
      rows.push_back({{answer.slip_index(row), answer.upper(row), answer.lower(row)},
                      std::min(frames.slip_index(row), 1.0f),
                      scaled.row(row).data()});
  return rows;
}

using Kinds = std::vector<std::vector<std::uint32_t>>;

/// Places among calibration_rows of each kind that a report judges by: indenter, touching elements, tenth of S.
Kinds kinds_of(const nn::Recall<float>& answer, const nn::FrameSet& frames) {
  std::map<std::pair<int, int>, std::vector<std::uint32_t>> kinds;
  std::uint32_t place = 0;
  for (std::size_t row = 0; row < answer.status.size(); ++row) {
    if (answer.status[row] != nn::FrameStatus::ok) continue;
    if (row < frames.shape_class.size()) kinds[{0, frames.shape_class[row]}].push_back(place);
    if (row < frames.contact_nodes.size()) kinds[{1, touching_key(frames.contact_nodes[row])}].push_back(place);
    kinds[{2, slip_key(frames.slip_index(static_cast<Eigen::Index>(row)))}].push_back(place);
    ++place;
  }
  Kinds all;
  for (auto& [key, rows] : kinds) all.push_back(std::move(rows));
  return all;
}

/// Calls judge(rows, kinds), the rows of a set with the answers of a network with a bound.
template <class Judge>
auto with_rows(Executor& executor, const NamedNetwork& network, const ContactSet& set, const std::string& file,
               const Judge& judge) {
  const nn::Model& model = network.model;
  if (!model.bound)
    throw ConfigError(network.file, "topology", model.weights.topology.text(),
                      "a network with a bound, see tactel train --bound");
  AnsweredRows rows = answered_rows(set, file);
  check_learnable(rows, file);
  rows.frames = shown_rows(rows.frames, model.history, model.magnitude, file);
  if (rows.frames.frames.cols() != model.weights.topology.inputs())
    throw ConfigError(network.file, "topology", model.weights.topology.text(),
                      fmt::format("a network with {} inputs, as many as the set has", rows.frames.frames.cols()));
  Forward<float> forward(executor, std::span(&model.weights, 1), model.scaling);
  const nn::Recall<float> answer = forward.recall(rows.frames.frames);
  const nn::RowMatrix<float> scaled = nn::scale_frames<float>(model.scaling, rows.frames.frames);
  return judge(calibration_rows(answer, rows.frames, scaled), kinds_of(answer, rows.frames));
}

}  // namespace

nn::Calibration calibrate_bound(Executor& executor, NamedNetwork& network, const ContactSet& set,
                                const std::string& file, double level, double least) try {
  return with_rows(executor, network, set, file, [&](const std::vector<nn::CalibrationRow>& rows, const Kinds& kinds) {
    nn::Bound& bound = *network.model.bound;
    nn::Bound renewed = bound;
    nn::renew_classes(renewed, rows);
    nn::Calibration report = nn::calibrate(renewed, rows, level);
    if (least > 0) report.least = nn::raise(renewed, rows, kinds, least);
    renewed.set = file;
    renewed.seed = set.seed;
    renewed.left_out.clear();
    bound = std::move(renewed);
    return report;
  });
} catch (const ValueError& error) {
  throw ConfigError(file, error);
}

void widen_bound(Executor& executor, NamedNetwork& network, NamedNetwork witness, const ContactSet& set,
                 const std::string& file, double level) try {
  if (!network.model.bound || witness.model.weights.topology.inputs() != network.model.weights.topology.inputs())
    throw ConfigError(witness.file, "topology", witness.model.weights.topology.text(),
                      "a network with the inputs of " + network.model.weights.topology.text());
  nn::Bound& bound = *network.model.bound;
  with_rows(executor, witness, set, file, [&](const std::vector<nn::CalibrationRow>& rows, const Kinds&) {
    nn::Bound other = *witness.model.bound;
    other.touching = bound.touching;
    other.slip_index = bound.slip_index;
    other.width = bound.width;
    other.distance = bound.distance;
    other.upper_correction.assign(bound.classes(), 0.0f);
    other.interval_correction = other.upper_correction;
    nn::calibrate(other, rows, level);
    nn::widen(bound, other);
  });
  bound.left_out += (bound.left_out.empty() ? "" : ",") + file;
} catch (const ValueError& error) {
  throw ConfigError(file, error);
}

}  // namespace tactel::host
