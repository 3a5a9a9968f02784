// SPDX-License-Identifier: Apache-2.0
#include "host/training/answered_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host/support/errors.h"
#include "nn/bound.h"
#include "nn/metrics.h"

namespace tactel::host {
namespace {

const std::vector<float>& column_of(const ContactSet& set, nn::Target target) {
  return target == nn::Target::slip_index    ? set.slip_index
         : target == nn::Target::force_ratio ? set.force_ratio
         : target == nn::Target::slid        ? set.slid
         : target == nn::Target::slip_path   ? set.slip_path
         : target == nn::Target::slid_ahead  ? set.slid_ahead
                                             : set.stick_fraction;
}

/// The answer to row `row`, NaN where there is none; of a slide its distance, x, y.
std::array<float, 2> answer_of(const ContactSet& set, nn::Target target, std::size_t row) {
  if (target == nn::Target::net_slip) return {set.net_slip[2 * row], set.net_slip[2 * row + 1]};
  return {column_of(set, target)[row], 0};
}

/// Tactels of a pad along x; 0 where the set does not have their places.
int columns_of(const ContactSet& set) {
  if (set.tactel_x.size() != set.tactel_y.size() || set.tactel_x.empty()) return 0;
  return static_cast<int>(std::ranges::count(set.tactel_y, set.tactel_y.front()));
}

/// Copies the numbers of a row's frame. Returns where the next one stands.
float* copy_frame(const ContactSet& set, std::size_t row, bool markers, float* to) {
  if (!markers) return std::copy_n(set.frames.data() + row * set.inputs, set.inputs, to);
  for (int k = 0; k < set.marker_numbers; k += 3)
    to = std::copy_n(set.markers.data() + row * set.marker_numbers + k, 2, to);
  return to;
}

}  // namespace

std::vector<float> frames_of(const ContactSet& set, bool markers) {
  std::vector<float> frames(set.rows() * static_cast<std::size_t>(frame_inputs(set, markers)));
  float* to = frames.data();
  for (std::size_t row = 0; row < set.rows(); ++row) to = copy_frame(set, row, markers, to);
  return frames;
}

AnsweredRows find_answered_rows(const ContactSet& set, nn::Target target, bool markers) {
  AnsweredRows answered;
  answered.target = target;
  for (std::size_t row = 0; row < set.rows(); ++row)
    if (set.status[row] != over_tolerance && std::isfinite(answer_of(set, target, row)[0])) answered.row.push_back(row);
  answered.left_out = set.rows() - answered.row.size();
  if (answered.row.empty()) return answered;
  nn::FrameSet& frames = answered.frames;
  frames.frames.resize(static_cast<Eigen::Index>(answered.row.size()), frame_inputs(set, markers));
  frames.slip_index.resize(frames.frames.rows());
  frames.shape_class.reserve(answered.row.size()), frames.contact_nodes.reserve(answered.row.size());
  frames.contact.reserve(answered.row.size()), frames.step.reserve(answered.row.size());
  float* to = frames.frames.data();
  for (const std::size_t row : answered.row) {
    to = copy_frame(set, row, markers, to);
    const std::array<float, 2> answer = answer_of(set, target, row);
    frames.slip_index(static_cast<Eigen::Index>(frames.step.size())) =
        nn::is_slide(target) ? nn::slid_target(std::hypot(answer[0], answer[1])) : answer[0];
    if (nn::is_slide(target) && target != nn::Target::slid_ahead) frames.slid.push_back(answer);
    frames.slip.push_back(set.slip_index[row]);
    frames.shape_class.push_back(set.indenter[row]);
    if (!markers)
      frames.contact_nodes.push_back(
          set.pad ? nn::touching_tactels(set.frames.data() + row * set.inputs, set.inputs / set.axes)
                  : set.contact_nodes[row]);
    if (set.pad) frames.torque.push_back(nn::torque_class(set.slip_index[row], set.force_ratio[row]));
    if (!set.friction.empty()) frames.friction.push_back(set.friction[row]);
    frames.contact.push_back(set.contact[row]);
    frames.step.push_back(set.step[row]);
  }
  frames.press_rows = set.press_rows;
  frames.markers = markers;
  if (markers) return answered;
  frames.axes = set.axes;
  const auto tactels = static_cast<std::size_t>(set.inputs / set.axes);
  frames.columns = set.pad ? columns_of(set) : static_cast<int>(tactels);
  const auto columns = static_cast<std::size_t>(frames.columns);
  if (set.pad && columns > 1 && columns * columns == tactels)  // places of both axes have the same roundings
    frames.square = set.tactel_x[1] - set.tactel_x[0] == set.tactel_y[columns] - set.tactel_y[0];
  return answered;
}

void require_answers(const SetColumns& columns, const std::string& file, nn::Target target, bool markers) {
  if (markers && columns.marker_numbers == 0)
    throw ConfigError(file, "markers", "missing", "a set of pads with [markers] in their sweep");
  if (target == nn::Target::force_ratio && !columns.pad)
    throw ConfigError(file, nn::name(target), "missing", "a set of pads; of lines slip_index is this ratio");
  if (nn::is_slide(target) && !columns.pad)
    throw ConfigError(file, nn::name(target), "missing", "a set of pads: lines do not count how far they slide");
  if ((target == nn::Target::net_slip || target == nn::Target::slid_ahead) && !columns.has(nn::name(target)))
    throw ConfigError(file, nn::name(target), "missing", "a set of grips with [load.hold] rate, with this column");
  if (target == nn::Target::slid && columns.slid_of_cells)
    throw ConfigError(file, "slid", "of grips without /slip_path, which older sets have under this name",
                      "a set that is generated anew, with both");
  require_datasets(
      columns, file,
      {unread(!markers), "slip_index", "contact_nodes", "contact", "step", "indenter", "status", nn::name(target)});
  if (columns.pad) require_datasets(columns, file, {"force_ratio"});
}

AnsweredRows answered_rows(const ContactSet& set, const std::string& file, nn::Target target, bool markers) {
  require_answers(set, file, target, markers);
  AnsweredRows answered = find_answered_rows(set, target, markers);
  if (answered.row.empty())
    throw ConfigError(file, nn::name(target),
                      fmt::format("{} rows, none of them solved with a slippage index", set.rows()),
                      "at least one row to learn from or to judge by");
  return answered;
}

nn::FrameSet shown_rows(const nn::FrameSet& rows, const nn::InputHistory& history, bool magnitude,
                        const std::string& file, std::optional<double> spread) try {
  nn::FrameSet shown = nn::with_history(rows, history, spread);
  shown.slip.clear(), shown.slid.clear();
  if (magnitude) shown.slip_index = shown.slip_index.cwiseAbs();
  return shown;
} catch (const ValueError& error) {
  throw ConfigError(file, error);
}

void check_learnable(const AnsweredRows& rows, const std::string& file, std::uint64_t first_row) {
  const bool all_finite = (rows.frames.frames.array() * 0.0f).sum() == 0.0f;  // in vectors; NaN else
  for (Eigen::Index i = 0; i < rows.frames.rows(); ++i) {
    const std::uint64_t row = first_row + rows.row[static_cast<std::size_t>(i)];
    if (!all_finite && !rows.frames.frames.row(i).allFinite())
      throw ConfigError(file, fmt::format("{}[{}]", unread(!rows.frames.markers), row), "NaN or infinity", "finite");
    if (std::abs(rows.frames.slip_index(i)) > nn::FrameSet::largest_slip_index)
      throw ConfigError(file, fmt::format("{}[{}]", nn::name(rows.target), row),
                        fmt::format("{}", rows.frames.slip_index(i)), "finite, usually 0 to 1");
  }
}

}  // namespace tactel::host
