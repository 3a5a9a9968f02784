// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "nn/forward.h"
#include "nn/frame_set.h"
#include "nn/model.h"

namespace tactel::host {

/// How well a bound holds on some rows.
struct Coverage {
  std::size_t rows = 0;
  double upper = 0, interval = 0;  ///< share of the rows with S below slip_upper, within slip_interval
  double width = 0;                ///< median of the interval's
  double unlike = 0;               ///< share of the rows whose frame is unlike those of the learning set
};

/// Errors of S where a network answers only the rows of the narrowest intervals.
struct Answered {
  double share = 0;           ///< of the rows
  double width = 0;           ///< largest of their intervals'
  double mean = 0, most = 0;  ///< of their errors, and 99 % of these
};

/// Coverage in all, and by what a set knows of its rows: kind of indenter, what touches (FrameSet::contact_nodes),
/// torque and S. Rows of which the network gave no answer are left out.
struct BoundReport {
  Coverage all{}, alike{};  ///< alike: of the rows that are not `unlike`
  std::map<int, Coverage> by_class{};
  std::map<int, Coverage> by_touching{};  ///< key: the least of the group, 1, 2, 3, 5, 9 or 17
  std::map<int, Coverage> by_torque{};    ///< of pads; key: nn::torque_class
  std::map<int, Coverage> by_slip{};      ///< key: tenths of S, 0 to 9
  std::vector<Answered> answered{};       ///< all rows, then fewer
  std::optional<bool> holds{};            ///< of a calibrated bound: whether its level holds on these rows
};

/// Returns the name of a kind of indenter, or "kind 3" where a set has none.
std::string indenter_name(const std::vector<std::string>& names, int kind);

/// Returns "1", "2", "3 to 4", ..., "17 and more" for a key of BoundReport::by_touching.
std::string touching_name(int key);

/// Returns false where more than twice as many rows are beyond a bound as its level allows, and 4 standard deviations
/// of their number more: rows of a contact are alike.
bool holds(const Coverage& coverage, double level);

/// Judges bounds [rows] by the S of the set. S counts as at most 1: what a solver has beyond is its tolerance. errors:
/// [rows], as nn::absolute_errors returns them.
BoundReport report_bound(std::span<const nn::BoundAnswer> bounds, std::span<const double> errors,
                         const nn::FrameSet& set);

/// Returns {"calibrated", "level", "set", "rows", "seed"} of a bound.
nlohmann::ordered_json to_json(const nn::Bound& bound);
/// Returns {"coverage", "interval_coverage", "width", "unlike", "alike", "by_indenter", "by_touching",
/// "by_slip_index", "answered"}, and of pads "by_torque".
nlohmann::ordered_json to_json(const BoundReport& report, const std::vector<std::string>& indenter_names);

/// Returns what a bound was calibrated on, in a line.
std::string bound_line(const nn::Bound& bound);
/// Returns that a bound does not hold on a set, and which friction both have; empty where it does.
std::string doubt_text(const nn::Model& model, const BoundReport& report, const nn::FrameSet& set);
/// Returns the report as two tables, a line a class, and a line a share of answered rows.
std::string coverage_table(const BoundReport& report, const std::vector<std::string>& indenter_names);

}  // namespace tactel::host
