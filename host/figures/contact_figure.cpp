// SPDX-License-Identifier: Apache-2.0
#include "host/figures/contact_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/figures/contact_view.h"

namespace tactel::host {
namespace {

using fem::ContactSolution;
using fem::ContactStep;
using fem::GapStatus;

double column_width(const ContactSolution& solution) { return solution.surface_x[1] - solution.surface_x[0]; }

/// Where the surface is touched at this step and a little beyond, mm.
std::pair<double, double> contact_window(const ContactSolution& solution, const ContactStep& step) {
  const auto [left, right] = touched_part(solution, step);
  const double from = solution.surface_x[0], to = solution.surface_x[solution.surface_x.size() - 1];
  if (!(left <= right)) return {from, to};
  const double room = std::max(2 * column_width(solution), 0.25 * (right - left));
  return {std::max(from, left - room), std::min(to, right + room)};
}

Series curve(const std::string& label, const Eigen::VectorXd& x, std::vector<double> y, Mark mark, Ink ink) {
  return {.label = label, .x = list(x), .y = std::move(y), .mark = mark, .ink = ink};
}

Panel surface_panel(const fem::Scene& scene, const ContactSolution& solution, const ContactStep& step) {
  const Eigen::VectorXd &x = solution.surface_x, pressure = traction_of(step.normal_force, solution),
                        shear = traction_of(step.tangential_force, solution);
  Panel panel{.title = "On the surface, where it touches", .x_label = "x (mm)", .y_label = "traction (MPa)"};
  panel.series = {curve("pressure p", x, list(pressure), Mark::line, Ink::blue),
                  curve("shear q", x, list(shear), Mark::long_dashes, Ink::orange),
                  marked(step.status, x, shear, GapStatus::stick), marked(step.status, x, shear, GapStatus::slip)};
  const bool back = step.Q < 0;
  if (std::isfinite(scene.friction))
    panel.series.push_back(curve(back ? "-µp" : "µp", x, list((back ? -scene.friction : scene.friction) * pressure),
                                 Mark::dashed, Ink::grey));
  panel.x_range = contact_window(solution, step);
  panel.zero_line = true;
  return panel;
}

/// The last step before the drag began, if the shown one comes after it.
const ContactStep* before_drag(const ContactSolution& solution, std::size_t shown) {
  const ContactStep* before = nullptr;
  for (std::size_t k = 0; k <= shown; ++k) {
    if (solution.steps[k].tangential != 0.0) return before;
    before = &solution.steps[k];
  }
  return nullptr;
}

Panel base_panel(const ContactSolution& solution, std::size_t shown) {
  const ContactStep& step = solution.steps[shown];
  Panel panel{.title = "At the tactels, under the rubber", .x_label = "x (mm)", .y_label = "stress (MPa)"};
  panel.series = {curve("σ_y", solution.tactel_x, list(step.sigma_y), Mark::line_dots, Ink::blue),
                  curve("τ_{xy}", solution.tactel_x, list(step.tau_xy), Mark::dash_triangles, Ink::orange)};
  if (const ContactStep* before = before_drag(solution, shown)) {
    panel.series.push_back(curve("before the drag", solution.tactel_x, list(before->sigma_y), Mark::dashed, Ink::grey));
    panel.series.push_back(curve("", solution.tactel_x, list(before->tau_xy), Mark::dashed, Ink::grey));
  }
  panel.zero_line = true;
  return panel;
}

/// The share of the touching nodes that have a status; NaN where none touches.
double share_of(const ContactStep& step, GapStatus status) {
  const auto touching = std::ssize(step.status) - std::ranges::count(step.status, GapStatus::open);
  return touching > 0 ? static_cast<double>(std::ranges::count(step.status, status)) / static_cast<double>(touching)
                      : NAN;
}

}  // namespace

Eigen::VectorXd traction_of(const Eigen::VectorXd& force, const ContactSolution& solution) {
  if (solution.surface_width.size() > 0) return force.cwiseQuotient(solution.surface_width);
  const Eigen::VectorXd& x = solution.surface_x;
  const Eigen::Index last = x.size() - 1;
  Eigen::VectorXd out(x.size());
  for (Eigen::Index i = 0; i <= last; ++i)
    out[i] = force[i] / (0.5 * (x[std::min(i + 1, last)] - x[std::max<Eigen::Index>(i - 1, 0)]));
  return out;
}

fem::Interval touched_part(const ContactSolution& solution, const ContactStep& step) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  fem::Interval part{infinity, -infinity};
  for (std::size_t i = 0; i < step.status.size(); ++i) {
    if (step.status[i] == GapStatus::open) continue;
    part.left = std::min(part.left, solution.surface_x[static_cast<Eigen::Index>(i)]);
    part.right = std::max(part.right, solution.surface_x[static_cast<Eigen::Index>(i)]);
  }
  return part;
}

Figure contact_figure(const fem::Scene& scene, const ContactSolution& solution, std::size_t shown) {
  const ContactStep& step = solution.steps[shown];
  const std::string what = scene.title.empty() ? fem::shape_name(scene.indenter.shape) : scene.title;
  Figure figure{.title =
                    fmt::format("{}: depth {:.4g} mm, drag {:.4g} mm", plain(what), step.indentation, step.tangential)};
  figure.panels = {surface_panel(scene, solution, step), base_panel(solution, shown)};
  if (solution.steps.size() > 1) {
    const auto index = [](const ContactStep& s) { return s.slip_index.value_or(NAN); };
    const auto slipping = [](const ContactStep& s) { return share_of(s, GapStatus::slip); };
    figure.panels.push_back(path_panel(
        {along_path(solution.steps, "slipping share of the contact", Ink::red, Mark::dash_triangles, slipping),
         along_path(solution.steps, "S = Q / µP", Ink::black, Mark::line_dots, index)},
        shown));
  }
  return figure;
}

double sticking_share(const ContactStep& step) { return share_of(step, GapStatus::stick); }

Series marked(const std::vector<GapStatus>& statuses, const Eigen::VectorXd& x, const Eigen::VectorXd& y,
              GapStatus status) {
  const bool stick = status == GapStatus::stick;
  Series out{.label = stick ? "stick" : "slip",
             .mark = stick ? Mark::circles : Mark::triangles,
             .ink = stick ? Ink::green : Ink::red};
  for (std::size_t i = 0; i < statuses.size(); ++i) {
    if (statuses[i] != status) continue;
    out.x.push_back(x[static_cast<Eigen::Index>(i)]), out.y.push_back(y[static_cast<Eigen::Index>(i)]);
  }
  return out;
}

Panel path_panel(std::vector<Series> shares, std::size_t shown) {
  const double at = static_cast<double>(shown + 1), steps = static_cast<double>(shares.back().x.size());
  double lowest = 0.0;
  for (const double value : shares.back().y) lowest = std::fmin(lowest, value);  // fmin passes over NaN
  shares.push_back({.x = {at, at}, .y = {-10, 10}, .mark = Mark::dashed, .ink = Ink::grey});
  return {.title = "Along the path",
          .x_label = "load step",
          .y_label = "share",
          .series = std::move(shares),
          .x_range = std::pair(0.5, steps + 0.5),
          .y_range = std::pair(lowest - 0.05, 1.08)};
}

}  // namespace tactel::host
