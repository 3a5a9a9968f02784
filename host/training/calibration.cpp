// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "fem/numbers/value_error.h"
#include "host/networks/forward.h"
#include "host/support/errors.h"
#include "host/training/named_network.h"

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

}  // namespace

nn::Calibration calibrate_bound(Executor& executor, NamedNetwork& network, const ContactSet& set,
                                const std::string& file, double level) try {
  nn::Model& model = network.model;
  if (!model.bound)
    throw ConfigError(network.file, "topology", model.weights.topology.text(),
                      "a network with a bound, see tactel train --bound");
  AnsweredRows rows = answered_rows(set, file);
  check_learnable(rows, file);
  rows.frames = shown_rows(rows.frames, model.history, model.magnitude, file);
  if (rows.frames.frames.cols() != model.numbers())
    throw ConfigError(network.file, "topology", model.weights.topology.text(),
                      fmt::format("a network with {} inputs, as many as the set has", rows.frames.frames.cols()));
  Forward<float> forward(executor, std::span(&model.weights, 1), model.scaling);
  const nn::Recall<float> answer = forward.recall(rows.frames.frames);
  const nn::RowMatrix<float> scaled = nn::scale_frames<float>(model.scaling, rows.frames.frames);
  const std::vector<nn::CalibrationRow> judged = calibration_rows(answer, rows.frames, scaled);
  nn::Bound renewed = *model.bound;
  nn::renew_classes(renewed, judged);
  const nn::Calibration report = nn::calibrate(renewed, judged, level);
  renewed.set = file;
  renewed.seed = set.seed;
  model.bound = std::move(renewed);
  return report;
} catch (const ValueError& error) {
  throw ConfigError(file, error);
}

}  // namespace tactel::host
