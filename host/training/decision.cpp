// SPDX-License-Identifier: Apache-2.0
#include "host/training/decision.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "fem/numbers/angles.h"
#include "fem/numbers/value_error.h"
#include "host/scenes/sweep_file.h"
#include "host/support/errors.h"
#include "host/training/network_report.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint8_t sliding = 1;  ///< LaneStatus, as in the set's file
constexpr double lower = 0.05;       ///< quantile of leads beside their median

double lead_quantile(const std::vector<double>& leads, double q) {
  return leads.empty() ? std::nan("") : nn::quantile(leads, q);
}

std::string csv_number(double value) { return std::isnan(value) ? "" : fmt::format("{:.6g}", value); }
Json json_of(double value) { return std::isnan(value) ? Json(nullptr) : Json(value); }

/// Rows of each contact, in the order of its steps.
std::vector<std::vector<std::size_t>> rows_by_contact(const ContactSet& set) {
  std::vector<std::size_t> order(set.rows());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t row) { return std::pair(set.contact[row], set.step[row]); });
  std::vector<std::vector<std::size_t>> contacts;
  for (const std::size_t row : order) {
    if (contacts.empty() || set.contact[contacts.back().front()] != set.contact[row]) contacts.emplace_back();
    contacts.back().push_back(row);
  }
  return contacts;
}

/// The way up to each row, which adds up to itself; a contact begins at first touch. A turn counts by what it moves at
/// turning_radius.
std::vector<double> ways_on_pad(const ContactSet& set, const std::string& file) {
  constexpr double turning_radius = 1;  // mm
  require_datasets(set, file, {"tangential", "twist"});
  std::vector<double> ways(set.rows());
  for (const std::vector<std::size_t>& contact : rows_by_contact(set)) {
    double way = 0, x = 0, y = 0, twist = 0;
    for (const std::size_t row : contact) {
      const double to_x = set.tangential[2 * row], to_y = set.tangential[2 * row + 1], to_twist = set.twist[row];
      way += std::hypot(to_x - x, to_y - y) + turning_radius * std::abs(fem::radians(to_twist - twist));
      ways[row] = way, x = to_x, y = to_y, twist = to_twist;
    }
  }
  return ways;
}

/// The first alarm of a drag; none where it stays off. Counts those that begin falsely, and frames that cannot tell.
std::optional<std::size_t> first_alarm(const Drag& drag, double threshold, const DecisionOptions& options,
                                       AlarmCount& count) {
  std::optional<std::size_t> first;
  bool on = false;
  for (std::size_t i = 0; i < drag.rows.size(); ++i) {
    const DragRow& row = drag.rows[i];
    if (on && row.value < threshold - options.release) on = false;
    if (on || !(row.value >= threshold)) continue;
    if (!(row.width <= options.widest)) {
      ++count.cannot_tell;
      continue;
    }
    on = true;
    if (!first) first = i;
    count.false_alarms += std::abs(row.truth) < options.false_below;
  }
  return first;
}

}  // namespace

void DecisionOptions::validate() const {
  if (!(rate > 0 && std::isfinite(rate))) throw ValueError("rate", fmt::format("{}", rate), "finite and above 0");
  if (!(touch >= 0 && std::isfinite(touch))) throw ValueError("touch", fmt::format("{}", touch), "0 or above, MPa");
  if (!(release >= 0 && release < 1)) throw ValueError("release", fmt::format("{}", release), "0 to 1");
  if (!(false_below >= 0 && false_below <= 1))
    throw ValueError("false_below", fmt::format("{}", false_below), "0 to 1");
  if (!(widest >= 0)) throw ValueError("widest", fmt::format("{}", widest), "a width of 0 or more");
}

AlarmCount count_alarms(std::span<const Drag> drags, double threshold, const DecisionOptions& options) {
  AlarmCount count{.threshold = threshold};
  for (const Drag& drag : drags) {
    const std::size_t before = count.cannot_tell;
    const auto first = first_alarm(drag, threshold, options, count);
    count.told += drag.slides && (first || count.cannot_tell > before);
    ++count.all;
    count.drags += drag.slides;
    count.rows += drag.rows.size();
    if (!first) continue;
    const DragRow& row = drag.rows[*first];
    const bool is_false = std::abs(row.truth) < options.false_below;
    count.false_drags += is_false;
    if (!drag.slides) continue;
    ++count.detected;
    const double whole = drag.slide_way - drag.rows.front().way;
    if (is_false || !(whole > 0)) continue;
    count.lead.push_back(drag.slide_way - row.way);
    count.lead_share.push_back((drag.slide_way - row.way) / whole);
  }
  return count;
}

std::vector<double> alarm_thresholds() {
  std::vector<double> thresholds;
  for (int k = 30; k < 100; k += 2) thresholds.push_back(0.01 * k);
  return thresholds;
}

std::vector<double> tangential_positions(const ContactSet& set, const std::string& file) {
  if (set.pad) return ways_on_pad(set, file);
  const auto refuse = [&](const std::string& what) {
    return ConfigError(file, "sweep", what, "the sweep that the set's rows were drawn from");
  };
  const Sweep sweep = read_sweep_text(file, set.sweep, set.seed);
  const SceneSource& source = sweep.lines(file);
  std::vector<double> positions(set.rows());
  std::optional<std::uint64_t> drawn;
  fem::LoadPath path;
  for (std::size_t row = 0; row < set.rows(); ++row) {
    if (drawn != set.contact[row]) {
      if (set.contact[row] >= source.contacts() && !source.endless())
        throw refuse(fmt::format("without contact {}", set.contact[row]));
      path = fem::load_path(source.contact(set.contact[row]).scene.load);
      drawn = set.contact[row];
    }
    if (set.step[row] >= path.steps.size())
      throw refuse(fmt::format("whose contact {} has no step {}", set.contact[row], set.step[row]));
    const fem::LoadStep& step = path.steps[set.step[row]];
    positions[row] = step.tangential_is_force ? std::nan("") : step.tangential;
  }
  return positions;
}

std::vector<Drag> drags_of(const ContactSet& set, const AnsweredRows& rows, std::span<const float> values,
                           std::span<const double> positions, double touch, std::span<const float> widths) {
  std::vector<float> value(set.rows(), std::nanf("")), width(set.rows(), 0);
  std::vector<bool> answered(set.rows(), false);
  const auto inputs = static_cast<std::size_t>(set.inputs);
  for (std::size_t i = 0; i < rows.row.size(); ++i) {
    const std::size_t row = rows.row[i];
    const auto normal = std::span(set.frames).subspan(row * inputs, inputs / static_cast<std::size_t>(set.axes));
    value[row] = std::ranges::all_of(normal, [&](float s) { return std::abs(s) < touch; }) ? 0 : values[i];
    if (!widths.empty()) width[row] = widths[i];
    answered[row] = true;
  }
  std::vector<Drag> drags;
  for (const std::vector<std::size_t>& contact : rows_by_contact(set)) {
    Drag drag{.kind = set.indenter[contact.front()]};
    double way = 0, before = positions[contact.front()];
    for (const std::size_t row : contact) {
      way += std::abs(positions[row] - before);
      before = positions[row];
      if (set.status[row] == sliding) {
        drag.slides = true, drag.slide_way = way;
        break;
      }
      drag.touching = set.contact_nodes[row];
      if (answered[row]) drag.rows.push_back({way, set.slip_index[row], value[row], width[row]});
    }
    if (!drag.rows.empty() && std::isfinite(way)) drags.push_back(std::move(drag));
  }
  return drags;
}

std::vector<DecisionCurve> decide(const NetworkResult& result, const ContactSet& set, const AnsweredRows& rows,
                                  std::span<const double> positions, const std::string& file,
                                  const DecisionOptions& options) {
  options.validate();
  std::vector<float> widths;
  for (const nn::BoundAnswer& bound : result.bounds) widths.push_back(bound.interval[1] - bound.interval[0]);
  if (std::isfinite(options.widest) && widths.empty())
    throw ConfigError("command line", "--widest", fmt::format("{}", options.widest),
                      "left out for networks without a bound: they have no interval");
  std::vector<DecisionCurve> curves;
  const auto add = [&](const std::string& signal, std::span<const float> values) {
    const std::vector<Drag> drags = drags_of(set, rows, values, positions, options.touch, widths);
    if (std::ranges::none_of(drags, &Drag::slides))
      throw ConfigError(
          file, "status", "no drag that begins without sliding and ends with it",
          "a set whose drags reach sliding: a tangential_step without tangential_steps, of pads with enough");
    std::map<int, std::vector<Drag>> kinds;
    for (const Drag& drag : drags) kinds[drag.kind].push_back(drag);
    const auto curve = [&](const std::string& name, std::span<const Drag> some) {
      curves.push_back({signal, name, {}});
      for (const double threshold : alarm_thresholds())
        curves.back().counts.push_back(count_alarms(some, threshold, options));
    };
    curve("all", drags);
    for (const auto& [kind, some] : kinds) curve(indenter_name(set.indenter_names, kind), some);
  };
  if (!result.bounds.empty()) {
    std::vector<float> upper;
    for (const nn::BoundAnswer& bound : result.bounds) upper.push_back(bound.upper);
    add("slip_upper", upper);
  }
  add(nn::name(rows.target), result.slip_index);
  return curves;
}

std::string decision_csv(std::span<const DecisionCurve> curves, const std::string& network,
                         const DecisionOptions& options, bool head) {
  std::string text;
  if (head)
    text =
        "network,signal,indenter,threshold,drags,detected,detection,all_drags,false_drags,false_share,"
        "false_alarms_a_minute,lead_median_mm,lead_5_mm,lead_median_share,lead_5_share,"
        "cannot_tell_share,told\n";
  for (const DecisionCurve& curve : curves)
    for (const AlarmCount& c : curve.counts)
      text +=
          fmt::format("{},{},{},{:.2f},{},{},{:.6g},{},{},{:.6g},{:.6g},{},{},{},{},{:.6g},{}\n", network, curve.signal,
                      curve.indenter, c.threshold, c.drags, c.detected, c.detection(), c.all, c.false_drags,
                      c.false_share(), c.false_a_minute(options.rate), csv_number(lead_quantile(c.lead, 0.5)),
                      csv_number(lead_quantile(c.lead, lower)), csv_number(lead_quantile(c.lead_share, 0.5)),
                      csv_number(lead_quantile(c.lead_share, lower)), c.cannot_tell_share(), c.told);
  return text;
}

Json to_json(std::span<const DecisionCurve> curves, const DecisionOptions& options) {
  Json list = Json::array();
  for (const DecisionCurve& curve : curves) {
    Json points = Json::array();
    for (const AlarmCount& c : curve.counts)
      points.push_back(
          {{"threshold", c.threshold},
           {"drags", c.drags},
           {"detected", c.detected},
           {"all_drags", c.all},
           {"false_drags", c.false_drags},
           {"false_alarms_a_minute", c.false_a_minute(options.rate)},
           {"lead_mm",
            {{"median", json_of(lead_quantile(c.lead, 0.5))}, {"q05", json_of(lead_quantile(c.lead, lower))}}},
           {"lead_share",
            {{"median", json_of(lead_quantile(c.lead_share, 0.5))},
             {"q05", json_of(lead_quantile(c.lead_share, lower))}}},
           {"cannot_tell_share", c.cannot_tell_share()},
           {"told", c.told}});
    list.push_back({{"signal", curve.signal}, {"indenter", curve.indenter}, {"thresholds", points}});
  }
  return {{"false_below", options.false_below},
          {"release", options.release},
          {"rate", options.rate},
          {"touch", options.touch},
          {"widest", json_of(std::isfinite(options.widest) ? options.widest : std::nan(""))},
          {"curves", list}};
}

std::string decision_table(std::span<const DecisionCurve> curves, const DecisionOptions& options) {
  const bool limited = std::isfinite(options.widest);
  std::string text = fmt::format("{:<12}{:>11}{:>9}{:>11}{:>9}{:>14}{:>12}{:>14}{:>12}{}\n", "alarm on", "threshold",
                                 "drags", "detected", "false", "false a min", "lead mm", "lead share", "its 5 %",
                                 limited ? fmt::format("{:>13}{:>8}", "cannot tell", "told") : "");
  const auto figure = [](double value) { return std::isnan(value) ? std::string("-") : fmt::format("{:.3f}", value); };
  for (const DecisionCurve& curve : curves) {
    if (curve.indenter != "all") continue;
    for (const AlarmCount& c : curve.counts) {
      const int percent = static_cast<int>(std::lround(100 * c.threshold));
      if (percent < 50 || percent % 10 != 0) continue;
      text += fmt::format("{:<12}{:>11.2f}{:>9}{:>11.4f}{:>9.4f}{:>14.3f}{:>12}{:>14}{:>12}{}\n", curve.signal,
                          c.threshold, c.drags, c.detection(), c.false_share(), c.false_a_minute(options.rate),
                          figure(lead_quantile(c.lead, 0.5)), figure(lead_quantile(c.lead_share, 0.5)),
                          figure(lead_quantile(c.lead_share, lower)),
                          limited ? fmt::format("{:>13.4f}{:>8.4f}", c.cannot_tell_share(), c.told_share()) : "");
    }
  }
  return text;
}

Figure decision_figure(std::span<const DecisionCurve> curves) {
  constexpr Ink inks[] = {Ink::blue, Ink::orange, Ink::green, Ink::purple, Ink::red, Ink::brown, Ink::grey};
  Panel roc{.title = "detection over false alarms",
            .x_label = "drags with a false alarm",
            .y_label = "drags detected before sliding"};
  Panel lead{.title = "lead over the threshold", .x_label = "threshold", .y_label = "lead, share of the way"};
  const std::string signal = curves.empty() ? "" : curves.front().signal;
  std::size_t drawn = 0;
  for (const DecisionCurve& curve : curves) {
    const bool all = curve.indenter == "all";
    if (!all && curve.signal != signal) continue;
    Series points{.label = all ? "all, by " + curve.signal : curve.indenter,
                  .mark = all ? Mark::line_dots : Mark::thin,
                  .ink = all && curve.signal == signal ? Ink::black : inks[drawn++ % std::size(inks)]};
    Series leads = points;
    for (const AlarmCount& c : curve.counts) {
      points.x.push_back(c.false_share()), points.y.push_back(c.detection());
      points.names.push_back(fmt::format("threshold {:.2f}", c.threshold));
      leads.x.push_back(c.threshold), leads.y.push_back(lead_quantile(c.lead_share, 0.5));
    }
    roc.series.push_back(std::move(points)), lead.series.push_back(std::move(leads));
  }
  return {.panels = {std::move(roc), std::move(lead)}, .columns = 2, .panel_height = 320};
}

}  // namespace tactel::host
