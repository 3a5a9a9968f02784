// SPDX-License-Identifier: Apache-2.0
#include "host/training/bound_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "nn/metrics.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;

constexpr int groups[] = {1, 2, 3, 5, 9, 17};  // least touching nodes of each
constexpr float rounding = 1e-6f;              // of S and its bound, in fp32
constexpr double answered_shares[] = {1, 0.99, 0.95, 0.9, 0.8};

using Rows = std::vector<std::size_t>;

Coverage coverage_of(const Rows& rows, std::span<const nn::BoundAnswer> bounds, const nn::FrameSet& set) {
  Coverage coverage{.rows = rows.size()};
  if (rows.empty()) return coverage;
  std::vector<float> widths;
  for (const std::size_t row : rows) {
    const nn::BoundAnswer& bound = bounds[row];
    const float s = std::min(set.slip_index(static_cast<Eigen::Index>(row)), 1.0f);
    coverage.upper += s <= bound.upper + rounding;
    coverage.interval += s >= bound.interval[0] - rounding && s <= bound.interval[1] + rounding;
    coverage.unlike += bound.unlike;
    widths.push_back(bound.interval[1] - bound.interval[0]);
  }
  const auto count = static_cast<double>(rows.size());
  coverage.upper /= count, coverage.interval /= count, coverage.unlike /= count;
  const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  std::nth_element(widths.begin(), middle, widths.end());
  coverage.width = *middle;
  return coverage;
}

// rows: that have an answer, in any order.
std::vector<Answered> answered_of(Rows rows, std::span<const nn::BoundAnswer> bounds, std::span<const double> errors) {
  const auto width = [&](std::size_t row) { return bounds[row].interval[1] - bounds[row].interval[0]; };
  std::ranges::stable_sort(rows, {}, width);
  std::vector<Answered> answered;
  for (const double share : answered_shares) {
    const auto count = static_cast<std::size_t>(std::ceil(share * static_cast<double>(rows.size())));
    if (count == 0) break;
    std::vector<double> some;
    for (const std::size_t row : std::span(rows).first(count)) some.push_back(errors[row]);
    answered.push_back({share, width(rows[count - 1]), nn::summarize(some).mean, nn::quantile(some, 0.99)});
  }
  return answered;
}

Json to_json(const Answered& answered) {
  return {{"share", answered.share}, {"width", answered.width}, {"mean", answered.mean}, {"p99", answered.most}};
}

Json to_json(const Coverage& coverage) {
  const auto figure = [&](double value) { return coverage.rows > 0 ? Json(value) : Json(nullptr); };
  return {{"rows", coverage.rows},
          {"coverage", figure(coverage.upper)},
          {"interval_coverage", figure(coverage.interval)},
          {"width", figure(coverage.width)},
          {"unlike", figure(coverage.unlike)}};
}

/// Key of BoundReport::by_touching for a number of nodes.
int touching_key(int nodes) {
  int key = groups[0];
  for (const int least : groups)
    if (nodes >= least) key = least;
  return key;
}

/// Key of BoundReport::by_slip for S.
int slip_key(float slip_index) { return static_cast<int>(std::clamp(10 * slip_index, 0.0f, 9.0f)); }

std::string slip_name(int tenth) { return fmt::format("{:.1f} to {:.1f}", tenth / 10.0, (tenth + 1) / 10.0); }

}  // namespace

std::string touching_name(int key) {
  const auto* next = std::upper_bound(std::begin(groups), std::end(groups), key);
  if (next == std::end(groups)) return fmt::format("{} and more", key);
  return *next == key + 1 ? std::to_string(key) : fmt::format("{} to {}", key, *next - 1);
}

std::string indenter_name(const std::vector<std::string>& names, int kind) {
  const auto place = static_cast<std::size_t>(kind);
  return place < names.size() ? names[place] : fmt::format("kind {}", kind);
}

bool holds(const Coverage& coverage, double level) {
  const double allowed = 1 - level, rows = static_cast<double>(coverage.rows);
  const double missed = 1 - std::min(coverage.upper, coverage.interval);
  return coverage.rows == 0 || missed <= 2 * allowed + 4 * std::sqrt(allowed * level / rows);
}

BoundReport report_bound(std::span<const nn::BoundAnswer> bounds, std::span<const double> errors,
                         const nn::FrameSet& set) {
  Rows all, alike;
  std::map<int, Rows> classes, touching, torque, slip;
  for (std::size_t row = 0; row < bounds.size(); ++row) {
    if (std::isnan(bounds[row].upper)) continue;
    all.push_back(row);
    if (!bounds[row].unlike) alike.push_back(row);
    if (row < set.shape_class.size()) classes[set.shape_class[row]].push_back(row);
    if (row < set.contact_nodes.size()) touching[touching_key(set.contact_nodes[row])].push_back(row);
    if (row < set.torque.size()) torque[set.torque[row]].push_back(row);
    slip[slip_key(set.slip_index(static_cast<Eigen::Index>(row)))].push_back(row);
  }
  BoundReport report{.all = coverage_of(all, bounds, set), .alike = coverage_of(alike, bounds, set)};
  const auto judge = [&](const std::map<int, Rows>& from, std::map<int, Coverage>& to) {
    for (const auto& [key, rows] : from) to[key] = coverage_of(rows, bounds, set);
  };
  report.answered = answered_of(std::move(all), bounds, errors);
  judge(classes, report.by_class), judge(touching, report.by_touching);
  judge(torque, report.by_torque), judge(slip, report.by_slip);
  return report;
}

Json to_json(const nn::Bound& bound) {
  return {{"calibrated", bound.calibrated()},
          {"level", bound.level},
          {"set", bound.set},
          {"rows", bound.rows},
          {"seed", bound.seed}};
}

Json to_json(const BoundReport& report, const std::vector<std::string>& indenter_names) {
  Json json = to_json(report.all);
  if (report.holds) json["holds"] = *report.holds;
  json["alike"] = to_json(report.alike);
  const auto list = [&json](const char* name, const char* key, const std::map<int, Coverage>& classes,
                            const auto& name_of) {
    Json array = Json::array();
    for (const auto& [which, coverage] : classes) {
      array.push_back({{key, name_of(which)}});
      array.back().update(to_json(coverage));
    }
    json[name] = std::move(array);
  };
  list("by_indenter", "indenter", report.by_class, [&](int kind) { return indenter_name(indenter_names, kind); });
  const bool pad = !report.by_torque.empty();
  list("by_touching", pad ? "tactels" : "contact_nodes", report.by_touching, touching_name);
  if (pad) list("by_torque", "torque", report.by_torque, nn::torque_class_name);
  list("by_slip_index", "slip_index", report.by_slip, slip_name);
  json["answered"] = Json::array();
  for (const Answered& answered : report.answered) json["answered"].push_back(to_json(answered));
  return json;
}

std::string bound_line(const nn::Bound& bound) {
  if (!bound.calibrated()) return "bound not calibrated (tactel calibrate bound)";
  return fmt::format("bound of {:g} %, calibrated on {} rows of {} (seed {})", 100 * bound.level, bound.rows, bound.set,
                     bound.seed);
}

std::string doubt_text(const nn::Model& model, const BoundReport& report, const nn::FrameSet& set) {
  if (report.holds.value_or(true)) return "";
  std::string text =
      fmt::format("the bound does not hold here: S of {:.1f} % of the rows is below slip_upper, where {:g} % is stated",
                  100 * report.all.upper, 100 * model.bound->level);
  const nn::Learnt &learnt = model.learnt, here = nn::learnt_ranges(set);
  if (learnt.most_friction > 0 && here.most_friction > 0)
    text += fmt::format("; learnt at friction {:.3g} to {:.3g}, here it is {:.3g} to {:.3g}", learnt.least_friction,
                        learnt.most_friction, here.least_friction, here.most_friction);
  return text;
}

std::string coverage_table(const BoundReport& report, const std::vector<std::string>& indenter_names) {
  std::string text = fmt::format("{:<24}{:>9}{:>12}{:>12}{:>12}{:>9}\n", "coverage", "rows", "slip_upper", "interval",
                                 "width", "unlike");
  const auto line = [&text](const std::string& name, const Coverage& c) {
    text += fmt::format("{:<24}{:>9}{:>12.4f}{:>12.4f}{:>12.4f}{:>9.4f}\n", name, c.rows, c.upper, c.interval, c.width,
                        c.unlike);
  };
  line("all", report.all);
  line("not unlike", report.alike);
  for (const auto& [kind, coverage] : report.by_class) line(indenter_name(indenter_names, kind), coverage);
  for (const auto& [key, coverage] : report.by_touching) line(touching_name(key) + " touching", coverage);
  for (const auto& [key, coverage] : report.by_torque) line(nn::torque_class_name(key), coverage);
  for (const auto& [key, coverage] : report.by_slip) line("S " + slip_name(key), coverage);
  text += fmt::format("\n{:<24}{:>12}{:>12}{:>12}\n", "narrowest answered", "width up to", "mean error", "99 %");
  for (const Answered& some : report.answered)
    text += fmt::format("{:<24}{:>12.4f}{:>12.4f}{:>12.4f}\n", fmt::format("{:g} %", 100 * some.share), some.width,
                        some.mean, some.most);
  return text;
}

}  // namespace tactel::host
