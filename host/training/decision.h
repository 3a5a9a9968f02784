// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "host/figures/plot.h"
#include "host/training/named_network.h"

namespace tactel::host {

/// A load step of a drag.
struct DragRow {
  double way = 0;    ///< mm that the indenter was dragged until here, to and fro added up
  double truth = 0;  ///< S
  double value = 0;  ///< that the alarm judges; NaN fires nothing
  double width = 0;  ///< of the interval of S; 0 without a bound
};

/// A contact until it slides.
struct Drag {
  int kind = 0;                 ///< of indenter
  int touching = 0;             ///< nodes or elements that touch in its last row
  std::vector<DragRow> rows{};  ///< before sliding, in order
  bool slides = false;          ///< the row after the last one slides; else the path ends there
  double slide_way = 0;         ///< mm, of that row
};

/// Alarms at one threshold.
struct AlarmCount {
  double threshold = 0;
  std::size_t drags = 0;         ///< that slide
  std::size_t detected = 0;      ///< of those, alarms before sliding
  std::size_t all = 0;           ///< drags, sliding or not
  std::size_t false_drags = 0;   ///< of `all`, first alarm at |S| < false_below
  std::size_t false_alarms = 0;  ///< times that an alarm begins at |S| < false_below
  std::size_t rows = 0;          ///< before sliding
  std::size_t cannot_tell = 0;   ///< of `rows`: without alarm only because the interval is too wide
  std::size_t told = 0;          ///< of `drags`: with an alarm or a frame that cannot tell before sliding
  /// Of drags detected by no false alarm: the way from alarm to sliding, mm and as a share of the way to sliding.
  std::vector<double> lead{}, lead_share{};

  double detection() const { return drags > 0 ? double(detected) / double(drags) : 0; }
  /// Returns the share of frames before sliding that cannot tell.
  double cannot_tell_share() const { return rows > 0 ? double(cannot_tell) / double(rows) : 0; }
  double told_share() const { return drags > 0 ? double(told) / double(drags) : 0; }
  double false_share() const { return all > 0 ? double(false_drags) / double(all) : 0; }
  /// Returns the false alarms a minute of frames before sliding, at `rate` frames a second.
  double false_a_minute(double rate) const { return rows > 0 ? 60 * rate * double(false_alarms) / double(rows) : 0; }
};

/// How alarms are judged.
struct DecisionOptions {
  double false_below = 0.5;  ///< an alarm that begins at a smaller |S| is false
  double release = 0.05;     ///< an alarm ends where the value is this far below the threshold
  double rate = 100;         ///< frames a second
  double touch = 0;          ///< MPa: a frame whose normal stresses all stay below is no contact and ends an alarm
  /// No alarm begins at a frame with a wider interval of S: it cannot tell.
  double widest = std::numeric_limits<double>::infinity();
  void validate() const;  ///< throws ValueError
};

/// Counts the alarms of some drags at one threshold. An alarm begins at a value of at least the threshold, where the
/// interval is at most `widest`, and ends at one below threshold - release.
AlarmCount count_alarms(std::span<const Drag> drags, double threshold, const DecisionOptions& options);

/// Returns the thresholds of curves: 0.30, 0.32, ... 0.98.
std::vector<double> alarm_thresholds();

/// Returns where each row of a set lies on the path of its contact, mm from first touch: of lines from the sweep that
/// the set keeps, NaN where a force drags; of pads the way up to there, in which a turn of a radian counts as 1 mm.
/// Throws ConfigError naming `file` for a set whose rows are not those of its sweep.
std::vector<double> tangential_positions(const ContactSet& set, const std::string& file);

/// Returns the drags of a set. values: [answered rows] that an alarm judges; widths: [answered rows] of the interval of
/// S, or empty. positions: [rows of the set]. The value of a frame whose normal stresses all stay below `touch` MPa is
/// 0.
std::vector<Drag> drags_of(const ContactSet& set, const AnsweredRows& rows, std::span<const float> values,
                           std::span<const double> positions, double touch = 0, std::span<const float> widths = {});

/// Alarms of a network, by its bound or by S, of all drags or of one kind of indenter.
struct DecisionCurve {
  std::string signal;              ///< "slip_upper" or the network's target
  std::string indenter;            ///< "all", or a kind
  std::vector<AlarmCount> counts;  ///< [thresholds]
};

/// Returns the curves of a network on the drags of a set: of its bound where it has one, then of S; of all drags, then
/// of each kind. `result` has its rows. Throws ConfigError naming `file` where no drag reaches sliding.
std::vector<DecisionCurve> decide(const NetworkResult& result, const ContactSet& set, const AnsweredRows& rows,
                                  std::span<const double> positions, const std::string& file,
                                  const DecisionOptions& options);

/// Returns all curves as CSV, a line a threshold; `network`: its first column.
std::string decision_csv(std::span<const DecisionCurve> curves, const std::string& network,
                         const DecisionOptions& options, bool head);
nlohmann::ordered_json to_json(std::span<const DecisionCurve> curves, const DecisionOptions& options);
/// Returns a table of some thresholds, all indenters together.
std::string decision_table(std::span<const DecisionCurve> curves, const DecisionOptions& options);

/// Returns two panels: detection over false alarms (ROC), and lead over thresholds; a curve an indenter.
Figure decision_figure(std::span<const DecisionCurve> curves);

}  // namespace tactel::host
