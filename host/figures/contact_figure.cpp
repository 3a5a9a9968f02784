// SPDX-License-Identifier: Apache-2.0
#include "host/figures/contact_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/figures/contact_view.h"

namespace tactel::host {
namespace {

using fem::ContactSolution;
using fem::ContactStep;
using fem::GapStatus;

double column_width(const ContactSolution& solution) { return solution.surface_x[1] - solution.surface_x[0]; }

/// Where the surface is touched at this step and a little beyond, mm.
std::pair<double, double> contact_window(const ContactSolution& solution, const ContactStep& step) {
  double left = INFINITY, right = -INFINITY;
  for (std::size_t i = 0; i < step.status.size(); ++i) {
    if (step.status[i] == GapStatus::open) continue;
    left = std::min(left, solution.surface_x[static_cast<Eigen::Index>(i)]);
    right = std::max(right, solution.surface_x[static_cast<Eigen::Index>(i)]);
  }
  const double from = solution.surface_x[0], to = solution.surface_x[solution.surface_x.size() - 1];
  if (!(left <= right)) return {from, to};
  const double room = std::max(2 * column_width(solution), 0.25 * (right - left));
  return {std::max(from, left - room), std::min(to, right + room)};
}

/// The points of one status out of a curve over the surface.
Series marked(const ContactSolution& solution, const ContactStep& step, const std::vector<double>& curve,
              GapStatus status) {
  const bool stick = status == GapStatus::stick;
  Series out{.label = stick ? "stick" : "slip",
             .mark = stick ? Mark::circles : Mark::triangles,
             .ink = stick ? Ink::green : Ink::red};
  for (std::size_t i = 0; i < step.status.size(); ++i) {
    if (step.status[i] != status) continue;
    out.x.push_back(solution.surface_x[static_cast<Eigen::Index>(i)]);
    out.y.push_back(curve[i]);
  }
  return out;
}

Series curve(const std::string& label, const Eigen::VectorXd& x, std::vector<double> y, Mark mark, Ink ink) {
  return {.label = label, .x = list(x), .y = std::move(y), .mark = mark, .ink = ink};
}

/// Of a patch, force over the element's width; of a mesh, over the spacing of the nodes.
std::vector<double> traction_of(const Eigen::VectorXd& force, const ContactSolution& solution) {
  if (solution.surface_width.size() == 0) return traction(force, solution.surface_x);
  return list(force.cwiseQuotient(solution.surface_width));
}

Panel surface_panel(const fem::Scene& scene, const ContactSolution& solution, const ContactStep& step) {
  const std::vector<double> pressure = traction_of(step.normal_force, solution);
  const std::vector<double> shear = traction_of(step.tangential_force, solution);
  std::vector<double> limit = pressure;
  for (double& value : limit) value *= step.Q < 0 ? -scene.friction : scene.friction;
  Panel panel{.title = "On the surface, where it touches", .x_label = "x (mm)", .y_label = "traction (MPa)"};
  panel.series = {curve("pressure p", solution.surface_x, pressure, Mark::line, Ink::blue),
                  curve("shear q", solution.surface_x, shear, Mark::long_dashes, Ink::orange),
                  marked(solution, step, shear, GapStatus::stick), marked(solution, step, shear, GapStatus::slip)};
  if (std::isfinite(scene.friction))
    panel.series.push_back(curve(step.Q < 0 ? "-µp" : "µp", solution.surface_x, limit, Mark::dashed, Ink::grey));
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

Panel path_panel(const ContactSolution& solution, std::size_t shown) {
  Series index{.label = "S = Q / µP", .mark = Mark::line_dots, .ink = Ink::black};
  Series slipping{.label = "slipping share of the contact", .mark = Mark::dash_triangles, .ink = Ink::red};
  for (std::size_t k = 0; k < solution.steps.size(); ++k) {
    const ContactStep& step = solution.steps[k];
    const auto slips = std::ranges::count(step.status, GapStatus::slip),
               sticks = std::ranges::count(step.status, GapStatus::stick);
    index.x.push_back(static_cast<double>(k + 1));
    index.y.push_back(step.slip_index.value_or(NAN));
    slipping.x.push_back(static_cast<double>(k + 1));
    slipping.y.push_back(slips + sticks > 0 ? static_cast<double>(slips) / static_cast<double>(slips + sticks) : NAN);
  }
  const double at = static_cast<double>(shown + 1);
  Panel panel{.title = "Along the path", .x_label = "load step", .y_label = "share"};
  panel.series = {slipping, index, {.x = {at, at}, .y = {-10, 10}, .mark = Mark::dashed, .ink = Ink::grey}};
  double lowest = 0.0;
  for (const double value : index.y) lowest = std::fmin(lowest, value);  // fmin passes over NaN
  panel.y_range = {lowest - 0.05, 1.08};
  panel.x_range = {0.5, static_cast<double>(solution.steps.size()) + 0.5};
  return panel;
}

}  // namespace

std::vector<double> traction(const Eigen::VectorXd& force, const Eigen::VectorXd& x) {
  std::vector<double> out;
  const Eigen::Index last = x.size() - 1;
  for (Eigen::Index i = 0; i <= last; ++i) {
    const double width = 0.5 * (x[std::min(i + 1, last)] - x[std::max<Eigen::Index>(i - 1, 0)]);
    out.push_back(force[i] / width);
  }
  return out;
}

Figure contact_figure(const fem::Scene& scene, const ContactSolution& solution, std::size_t shown) {
  const ContactStep& step = solution.steps[shown];
  const std::string what = scene.title.empty() ? fem::shape_name(scene.indenter.shape) : scene.title;
  Figure figure{.title =
                    fmt::format("{}: depth {:.4g} mm, drag {:.4g} mm", plain(what), step.indentation, step.tangential)};
  figure.panels = {surface_panel(scene, solution, step), base_panel(solution, shown)};
  if (solution.steps.size() > 1) figure.panels.push_back(path_panel(solution, shown));
  return figure;
}

double sticking_share(const ContactStep& step) {
  const auto stick = std::ranges::count(step.status, GapStatus::stick),
             slip = std::ranges::count(step.status, GapStatus::slip);
  return stick + slip > 0 ? static_cast<double>(stick) / static_cast<double>(stick + slip) : NAN;
}

std::size_t telling_step(const ContactSolution& solution) {
  for (std::size_t k = solution.steps.size(); k-- > 0;) {
    const double share = sticking_share(solution.steps[k]);
    if (share > 0 && share < 1) return k;
  }
  return solution.steps.size() - 1;
}

}  // namespace tactel::host
