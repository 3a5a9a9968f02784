// SPDX-License-Identifier: Apache-2.0
#include "host/answers/convergence.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "fem/layer/layer_model.h"
#include "fem/layer/patch_reference.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_reference.h"
#include "fem/pad/side_kernel.h"
#include "host/answers/answer_forms.h"
#include "host/answers/step_quantities.h"
#include "host/support/seconds.h"

namespace tactel::host {
namespace {

constexpr double safety = 1.25, least_order = 0.5, most_order = 2;  ///< of Eca and Hoekstra

const char* trend_of(std::span<const double> values) {
  bool one_way = true, to_and_fro = true;
  for (std::size_t k = 2; k < values.size(); ++k) {
    const double turn = (values[k] - values[k - 1]) * (values[k - 1] - values[k - 2]);
    one_way &= turn > 0, to_and_fro &= turn < 0;
  }
  return one_way ? "monotone" : to_and_fro ? "oscillating" : "noisy";
}

/// A number of a load step; NaN where it is not defined.
template <class Step>
struct Measure {
  const char *name, *unit;
  double (*of)(const Step&);
};

double index_of(const std::optional<double>& slip_index) {
  return slip_index ? without_rounding(*slip_index, 1) : std::numeric_limits<double>::quiet_NaN();
}

/// Without the tactels at the ends, where the exact stress is infinite.
double largest_inside(const Eigen::VectorXd& stress) {
  return stress.size() < 3 ? stress.cwiseAbs().maxCoeff() : stress.segment(1, stress.size() - 2).cwiseAbs().maxCoeff();
}

const std::vector<Measure<fem::ContactStep>>& measures_of(const fem::ContactSolution&) {
  using Step = fem::ContactStep;
  static const std::vector<Measure<Step>> all = {
      {"P", "N/mm", [](const Step& s) { return s.P; }},
      {"Q", "N/mm", [](const Step& s) { return without_rounding(s.Q, s.P); }},
      {"S", "", [](const Step& s) { return index_of(s.slip_index); }},
      {"sigma_y", "MPa", [](const Step& s) { return largest_inside(s.sigma_y); }}};
  return all;
}

const std::vector<Measure<fem::PadStep>>& measures_of(const fem::PadSolution&) {
  using Step = fem::PadStep;
  static const std::vector<Measure<Step>> all = {
      {"P", "N", [](const Step& s) { return s.P; }},
      {"Qx", "N", [](const Step& s) { return without_rounding(s.Q[0], s.P); }},
      {"Qy", "N", [](const Step& s) { return without_rounding(s.Q[1], s.P); }},
      {"M", "N mm", [](const Step& s) { return without_rounding(s.M, s.P); }},
      {"S", "", [](const Step& s) { return index_of(s.slip_index); }},
      {"sigma_z", "MPa", [](const Step& s) { return s.stress.col(0).cwiseAbs().maxCoeff(); }}};
  return all;
}

double cell_size(const fem::ContactSolution& solution) { return solution.surface_width.mean(); }
double cell_size(const fem::PadSolution& solution) { return std::sqrt(solution.cells.hx * solution.cells.hy); }

/// Solves rungs by `solve(cells)` and gathers their numbers beside the answer's. `rounding`: of numbers, over P, S = 1
/// or the largest stress.
template <class Solution>
Convergence judged(const Solution& answer, std::size_t step, std::initializer_list<int> rungs, const char* cells_name,
                   double rounding, const std::function<Solution(int)>& solve, const RungProgress& progress) {
  Convergence found{.step = step};
  std::vector<Solution> solutions;
  for (const int cells : rungs) {
    const std::string name = fmt::format(fmt::runtime(cells_name), cells);
    if (progress) progress(name);
    const auto start = Clock::now();
    Solution solution = solve(cells);
    if (solution.steps.empty()) {
      found.missed.push_back({name, std::numeric_limits<double>::quiet_NaN(), rounding});
      continue;
    }
    if (const auto& judged = solution.steps[std::min(step, solution.steps.size() - 1)];
        !judged.converged && !(largest_residual(judged) <= rounding)) {
      found.missed.push_back({name, largest_residual(judged), rounding});
      continue;
    }
    found.step = std::min(found.step, solution.steps.size() - 1);  // a drag until sliding ends at a rung's own step
    found.rungs.push_back({name, cell_size(solution), seconds_since(start)});
    solutions.push_back(std::move(solution));
  }
  if (solutions.size() < least_rungs) return found;
  std::vector<double> h;
  for (const Convergence::Rung& rung : found.rungs) h.push_back(rung.h);
  const double P = solutions.back().steps[found.step].P;
  for (const auto& [name, unit, of] : measures_of(answer)) {
    ConvergedQuantity quantity{name, unit, of(answer.steps[found.step])};
    bool defined = std::isfinite(quantity.answer);
    for (std::size_t r = 0; r < solutions.size(); ++r) {
      const auto& steps = solutions[r].steps;
      defined &= std::isfinite(quantity.values.emplace_back(of(steps[found.step])));
      if (r == 0) continue;
      double change = 0;
      for (std::size_t k = 0; k < std::min(steps.size(), solutions[r - 1].steps.size()); ++k)
        if (const double d = std::abs(of(steps[k]) - of(solutions[r - 1].steps[k])); d > change) change = d;
      quantity.changes.push_back(change);
    }
    if (!defined) continue;
    const double scale = quantity.unit.empty() ? 1 : quantity.unit == "MPa" ? quantity.values.back() : P;
    quantity.fit = extrapolate(h, quantity.values, rounding * scale);
    found.quantities.push_back(std::move(quantity));
  }
  return found;
}

/// Of a page: "σ_y", "σ_y (MPa)".
std::string name_on_page(const ConvergedQuantity& q) {
  return q.name.starts_with("sigma") ? "σ" + q.name.substr(5) : q.name;
}
std::string on_page(const ConvergedQuantity& q) {
  return name_on_page(q) + (q.unit.empty() ? "" : fmt::format(" ({})", q.unit));
}

std::string order_text(const Extrapolation& fit) {
  if (fit.order == 0) return "none";
  return fit.order == least_order ? "<= 0.5" : fit.order == most_order ? ">= 2" : fmt::format("{:.2f}", fit.order);
}

/// What the answer is off by: "P 0.16 %, S 0.0021".
std::string errors_text(const Convergence& found) {
  std::string out;
  for (const ConvergedQuantity& q : found.quantities) {
    const double whole = q.name == "S" || q.fit.limit == 0 ? 1 : std::abs(q.fit.limit) / 100;
    const char* unit = q.name == "S" ? "" : q.fit.limit == 0 ? q.unit.c_str() : "%";
    out += fmt::format("{}{} {:+.2g} ± {:.2g}{}{}", out.empty() ? "" : ", ", name_on_page(q), q.error() / whole,
                       q.fit.uncertainty / whole, *unit ? " " : "", unit);
  }
  return out;
}

/// On the smallest cells the value, on others the difference from it.
std::string on_rung(const ConvergedQuantity& q, std::size_t rung) {
  const double finest = q.values.back();
  return rung + 1 == q.values.size() ? short_number(finest) : fmt::format("{:+.2g}", q.values[rung] - finest);
}

bool scatters(const ConvergedQuantity& q) { return q.fit.order == 0 && q.fit.scatter > 0; }

std::string no_order_text(const ConvergedQuantity& q) {
  return fmt::format("{}: no order, for values scatter by {:.2g}; its limit is the finest value", q.name,
                     q.fit.scatter);
}

/// "60 elements missed the tolerance (residual 2e-08, 1e-09 is accepted)".
std::string missed_text(const Convergence& found) {
  std::string out;
  for (const auto& [name, residual, accepted] : found.missed)
    out += fmt::format(
        "{}{} missed the tolerance ({})", out.empty() ? "" : ", ", name,
        std::isnan(residual) ? "no load step" : fmt::format("residual {:.2g}, {:g} is accepted", residual, accepted));
  return out;
}

std::string not_judged_text(const Convergence& found) {
  return "convergence is not judged: " +
         (found.missed.empty() ? "the answer's numbers are not finite" : missed_text(found));
}

Panel panel_of(const Convergence& found, const ConvergedQuantity& q) {
  constexpr int pieces = 60;
  const Extrapolation& fit = q.fit;
  Series values{.label = "rungs", .mark = Mark::circles, .ink = Ink::blue};
  for (std::size_t r = 0; r < found.rungs.size(); ++r) {
    values.x.push_back(found.rungs[r].h), values.y.push_back(q.values[r]);
  }
  const double widest = std::max(found.rungs.front().h, found.h);
  Series curve{.label = "fit", .mark = Mark::thin, .ink = Ink::blue};
  for (int k = 0; fit.order > 0 && k <= pieces; ++k) {
    curve.x.push_back(found.rungs.front().h * k / pieces);
    curve.y.push_back(fit.limit + fit.slope * std::pow(curve.x.back(), fit.order));
  }
  const double low = fit.limit - fit.uncertainty, high = fit.limit + fit.uncertainty;
  Series band{.label = "limit and uncertainty",
              .x = {0, widest},
              .y = {fit.limit, fit.limit},
              .mark = Mark::band,
              .ink = Ink::green,
              .low = {low, low},
              .high = {high, high}};
  Series limit{.x = {0, widest}, .y = band.y, .mark = Mark::dashed, .ink = Ink::green};
  Series answer{.label = "this answer", .x = {found.h}, .y = {q.answer}, .mark = Mark::diamonds, .ink = Ink::orange};
  return {.title = on_page(q) + (fit.order > 0 ? ", order " + order_text(fit) : ", no order"),
          .x_label = "size of the cells (mm)",
          .y_label = on_page(q),
          .series = {band, limit, curve, values, answer}};
}

}  // namespace

Extrapolation extrapolate(std::span<const double> h, std::span<const double> values, double rounding) {
  const auto n = static_cast<Eigen::Index>(values.size());
  const Eigen::Map<const Eigen::ArrayXd> size(h.data(), n), value(values.data(), n);
  Extrapolation fit{.limit = values.back(), .uncertainty = rounding};
  const double range = value.maxCoeff() - value.minCoeff();
  if (range <= rounding) return fit;
  fit.trend = trend_of(values);
  fit.scatter = std::numeric_limits<double>::infinity();
  const Eigen::ArrayXd weight = size.square().inverse() / size.square().inverse().sum();
  double limit = 0, order = 0, misfit = 0;
  constexpr int trials = 48;
  for (int k = 0; k <= trials; ++k) {
    const double trial = least_order + k * (most_order - least_order) / trials;
    const Eigen::ArrayXd power = size.unaryExpr([trial](double at) { return std::pow(at, trial); });
    const Eigen::ArrayXd x = power - (weight * power).sum();
    const double slope = (weight * x * value).sum() / (weight * x.square()).sum();
    const double at_zero = (weight * (value - slope * power)).sum();
    const Eigen::ArrayXd off = value - at_zero - slope * power;
    const double scatter =
        std::sqrt(static_cast<double>(n) / static_cast<double>(n - 3) * (weight * off.square()).sum());
    if (!(scatter < fit.scatter)) continue;
    fit.scatter = scatter, fit.slope = slope;
    limit = at_zero, order = trial, misfit = std::abs(off[n - 1]);
  }
  const double mean_change = range / static_cast<double>(n - 1);  // from rung to rung
  if (fit.scatter < mean_change) {
    fit.limit = limit, fit.order = order;
    fit.uncertainty += safety * std::abs(values.back() - limit) + fit.scatter + misfit;
  } else {  // what each rung says of the finest, were the order 1
    fit.uncertainty += safety * ((value - values.back()).abs() * h.back() / (size - h.back())).head(n - 1).maxCoeff();
  }
  return fit;
}

Convergence converge(const SolveOutcome& outcome, std::size_t step, const RungProgress& progress) {
  const fem::LayerModel model = fem::layer_model(outcome.scene.sensor);
  const auto solve = [&](int elements) {
    const fem::PatchOptions options{.elements = elements, .pressing_increments = std::max(4, elements / 6)};
    return fem::PatchReference(model, options).solve(outcome.scene);
  };
  Convergence found =
      judged<fem::ContactSolution>(outcome.solution, step, {15, 30, 60, 120}, "{} elements", 1e-9, solve, progress);
  const fem::Sensor& sensor = outcome.scene.sensor;
  found.h = outcome.on_patch() ? cell_size(outcome.solution) : sensor.length / (sensor.columns - 1);
  return found;
}

Convergence converge(const PadOutcome& outcome, std::size_t step, const RungProgress& progress) {
  const fem::PadLayer layer = fem::pad_layer(outcome.scene);
  const auto solve = [&](int cells) {
    return fem::PadReference(layer, fem::pad_reference_options(cells)).solve(outcome.scene).solution;
  };
  const std::initializer_list<int> all = {16, 24, 32, 48, 64}, fewer = {12, 16, 20, 24, 32};
  const bool has_all = fem::side_rules(outcome.scene.sensor).most_cells >= 64;
  Convergence found =
      judged<fem::PadSolution>(outcome.solution, step, has_all ? all : fewer, "{0} x {0} cells", 1e-5, solve, progress);
  found.h = cell_size(outcome.solution);
  return found;
}

std::string convergence_table(const Convergence& found) {
  if (found.quantities.empty()) return not_judged_text(found) + "\n";
  std::string out = fmt::format(
      "\nconvergence of step {}, by exact contact on ever smaller cells in fp64;\n"
      "above the values of the smallest: differences from them\n",
      found.step + 1);
  const auto row = [&](const std::string& name, const std::string& h, const auto& cell) {
    out += fmt::format("{:<15} {:>8}", name, h);
    for (const ConvergedQuantity& q : found.quantities) out += fmt::format(" {:>8}", cell(q));
    out += "\n";
  };
  row("", "h", [](const ConvergedQuantity& q) { return q.name; });
  row("", "mm", [](const ConvergedQuantity& q) { return q.unit; });
  for (std::size_t r = 0; r < found.rungs.size(); ++r)
    row(found.rungs[r].name, short_number(found.rungs[r].h), [r](const ConvergedQuantity& q) { return on_rung(q, r); });
  row("last, all steps", "", [](const ConvergedQuantity& q) { return fmt::format("{:.2g}", q.changes.back()); });
  row("order", "", [](const ConvergedQuantity& q) { return order_text(q.fit); });
  row("limit", "0", [](const ConvergedQuantity& q) { return short_number(q.fit.limit); });
  row("its uncertainty", "", [](const ConvergedQuantity& q) { return fmt::format("{:.2g}", q.fit.uncertainty); });
  row("answer - limit", short_number(found.h),
      [](const ConvergedQuantity& q) { return fmt::format("{:+.2g}", q.error()); });
  for (const ConvergedQuantity& q : found.quantities)
    if (scatters(q)) out += no_order_text(q) + "\n";
  if (!found.missed.empty()) out += missed_text(found) + "\n";
  return out;
}

nlohmann::ordered_json to_json(const Convergence& found) {
  using Json = nlohmann::ordered_json;
  Json rungs = Json::array(), quantities = Json::array(), missed = Json::array(), residuals = Json::array();
  for (const Convergence::Missed& m : found.missed) missed.push_back(m.name), residuals.push_back(m.residual);
  for (const Convergence::Rung& r : found.rungs)
    rungs.push_back({{"rung", r.name}, {"h", r.h}, {"seconds", r.seconds}});
  for (const ConvergedQuantity& q : found.quantities)
    quantities.push_back({{"name", q.name},
                          {"unit", q.unit},
                          {"answer", q.answer},
                          {"error", q.error()},
                          {"limit", q.fit.limit},
                          {"uncertainty", q.fit.uncertainty},
                          {"order", q.fit.order > 0 ? Json(q.fit.order) : Json()},
                          {"scatter", q.fit.scatter},
                          {"trend", q.fit.trend},
                          {"values", q.values},
                          {"changes", q.changes}});
  return {{"step", found.step + 1},
          {"h", found.h},
          {"rungs", std::move(rungs)},
          {"missed", std::move(missed)},
          {"missed_residuals", std::move(residuals)},
          {"quantities", std::move(quantities)}};
}

void add_convergence(Page& page, const Convergence& found) {
  if (found.quantities.empty()) return page.finding(Tone::fair, "convergence", not_judged_text(found) + ".");
  page.finding(
      Tone::fact, "convergence",
      fmt::format("Load step {} less the limit of ever smaller cells: {}.", found.step + 1, errors_text(found)));
  page.section("Convergence");
  PageTable table{
      .caption = fmt::format("Load step {} beside exact contact on ever smaller cells, in fp64. Above the values "
                             "of the smallest: differences from them.",
                             found.step + 1),
      .head = {"rung", "h, mm"}};
  for (const ConvergedQuantity& q : found.quantities) table.head.push_back(on_page(q));
  const auto row = [&](std::vector<Cell> cells, const auto& cell) {
    for (const ConvergedQuantity& q : found.quantities) cells.push_back(cell(q));
    table.add(std::move(cells));
  };
  for (std::size_t r = 0; r < found.rungs.size(); ++r)
    row({found.rungs[r].name, short_number(found.rungs[r].h)},
        [r](const ConvergedQuantity& q) { return on_rung(q, r); });
  row({"values are", ""}, [](const ConvergedQuantity& q) { return q.fit.trend; });
  row({"order", ""}, [](const ConvergedQuantity& q) { return order_text(q.fit); });
  row({"limit", "0"}, [](const ConvergedQuantity& q) {
    return fmt::format("{} ± {:.1g}", short_number(q.fit.limit), q.fit.uncertainty);
  });
  row({"this answer", short_number(found.h)}, [](const ConvergedQuantity& q) { return short_number(q.answer); });
  page.table(table);
  for (const ConvergedQuantity& q : found.quantities)
    if (scatters(q)) page.note(no_order_text(q) + ".");
  if (!found.missed.empty()) page.note(missed_text(found) + ".");
  Figure figure{.columns = 2, .panel_height = 260};
  for (const ConvergedQuantity& q : found.quantities)
    if (q.fit.scatter > 0) figure.panels.push_back(panel_of(found, q));
  if (figure.panels.empty()) return;
  page.figure(figure, "Values against the size of the cells, the fit through them, and its limit at size 0.");
}

}  // namespace tactel::host
