// SPDX-License-Identifier: Apache-2.0
#include "host/studies/paper/direct_problem.h"

#include <fmt/format.h>

#include <functional>
#include <unsupported/Eigen/Splines>

#include "host/contact/lines/solve_on_rung.h"

namespace tactel::host {
namespace {

/// `y` over `x` (equally spaced), read at `at` through the interpolating cubic spline; knots as Eigen averages them,
/// which for equal spacing are the points but the second and the last but one ("not a knot").
Eigen::VectorXd through_spline(const Eigen::VectorXd& x, const Eigen::VectorXd& y, const Eigen::VectorXd& at) {
  const double from = x[0], length = x[x.size() - 1] - from;
  const Eigen::RowVectorXd parameter = ((x.array() - from) / length).matrix().transpose();
  const auto spline = Eigen::SplineFitting<Eigen::Spline<double, 1>>::Interpolate(y.transpose(), 3, parameter);
  return at.unaryExpr([&](double value) { return spline((value - from) / length)[0]; });
}

/// Equations (6) and (7), percent.
std::vector<double> error(const Eigen::VectorXd& x_B, const Eigen::VectorXd& B, const Eigen::VectorXd& x_A,
                          const Eigen::VectorXd& A) {
  const Eigen::VectorXd difference = 100 * (through_spline(x_B, B, x_A) - A).cwiseAbs() / A.cwiseAbs().maxCoeff();
  return {difference.begin(), difference.end()};
}

double largest(const std::vector<double>& values) { return *std::max_element(values.begin(), values.end()); }

fem::Scene scene_with(fem::Scene scene, const std::function<void(fem::Scene&)>& change) {
  change(scene);
  return scene;
}

struct SceneVariant {
  std::string parameter, value;
  fem::Scene scene;
};

/// The choice with one parameter at a time at other values; the chosen value is among them.
std::vector<SceneVariant> scene_variants(const fem::Scene& choice) {
  std::vector<SceneVariant> all;
  const auto add = [&](const std::string& parameter, const std::string& value,
                       const std::function<void(fem::Scene&)>& change) {
    all.push_back({parameter, value, scene_with(choice, change)});
  };
  for (double nu : {0.3, 0.45, 0.48, 0.49, 0.495, 0.4999})
    add("Poisson's ratio", fmt::format("{}", nu), [=](fem::Scene& s) { s.sensor.poisson = nu; });
  for (double grading : {1.0, 2.0, 2.75, 4.0, 8.0})
    add("grading, bottom row over top row", fmt::format("{}", grading),
        [=](fem::Scene& s) { s.sensor.grading = grading; });
  for (double radius : {10.0, 30.0, 60.0, 97.0, 150.0})
    add("radius of the parabola, mm", fmt::format("{}", radius),
        [=](fem::Scene& s) { s.indenter.shape = fem::Parabola{radius}; });
  for (double mu : {0.2, 0.3, 0.4, 0.5, 1.0})
    add("friction", fmt::format("{}", mu), [=](fem::Scene& s) { s.friction = mu; });
  for (auto stress : {fem::StressRecovery::element, fem::StressRecovery::reaction})
    for (auto element : {fem::Element::q4i, fem::Element::q4, fem::Element::bbar, fem::Element::q8})
      add("element, base stress", fmt::format("{}, {}", fem::name(element), fem::name(stress)), [=](fem::Scene& s) {
        s.sensor.element = element;
        s.sensor.stress = stress;
      });
  for (int steps : {1, 2, 5, 10, 20})
    add("indentation steps", fmt::format("{}", steps), [=](fem::Scene& s) { s.load.indentation_steps = steps; });
  return all;
}

bool same_choice(const fem::Scene& a, const fem::Scene& b) {
  return a.sensor == b.sensor && a.friction == b.friction && a.load.indentation_steps == b.load.indentation_steps &&
         std::get<fem::Parabola>(a.indenter.shape).radius == std::get<fem::Parabola>(b.indenter.shape).radius;
}

}  // namespace

const TableOne& paper_table_one() {
  static const TableOne table{
      {{0, 3.46, 11.05}, {0.075, 4.73, 10.10}, {0.15, 6.19, 9.74}, {0.225, 7.81, 9.36}, {0.3, 9.34, 8.55}}};
  return table;
}

std::vector<double> DirectProblem::sigma_y_error(std::size_t row) const {
  return error(B.tactel_x, B.steps[step[row]].sigma_y, A.tactel_x, A.steps[step[row]].sigma_y);
}

std::vector<double> DirectProblem::tau_xy_error(std::size_t row) const {
  return error(B.tactel_x, B.steps[step[row]].tau_xy, A.tactel_x, A.steps[step[row]].tau_xy);
}

TableOne DirectProblem::table() const {
  TableOne table;
  for (std::size_t row = 0; row < table.size(); ++row)
    table[row] = {A.steps[step[row]].tangential, largest(sigma_y_error(row)), largest(tau_xy_error(row))};
  return table;
}

fem::Scene on_mesh(fem::Scene choice, char mesh) {
  choice.sensor.columns = mesh == 'A' ? 123 : 41;
  choice.sensor.rows = mesh == 'A' ? 33 : 11;
  choice.sensor.tactels = choice.sensor.columns;
  choice.load.tangential_step = 0;
  choice.load.tangential_steps.reset();
  choice.load.tangential.clear();
  for (std::size_t row = 1; row < paper_table_one().size(); ++row)
    choice.load.tangential.push_back(paper_table_one()[row].u_x);
  return choice;
}

std::vector<DirectProblem> solve_direct_problems(Executor& executor, const std::vector<fem::Scene>& choices) {
  std::vector<fem::Scene> scenes;
  for (const fem::Scene& choice : choices)
    for (char mesh : {'A', 'B'}) scenes.push_back(on_mesh(choice, mesh));
  const auto solutions = solve_on_meshes(executor, scenes, Precision::fp64);
  std::vector<DirectProblem> problems;
  for (std::size_t i = 0; i < scenes.size(); i += 2) {
    DirectProblem p{scenes[i], scenes[i + 1], solutions[i], solutions[i + 1], {}};
    for (const auto* solution : {&p.A, &p.B})
      for (const fem::ContactStep& step : solution->steps)
        if (!step.converged)
          throw std::runtime_error("the paper's direct problem: a load step did not meet its tolerance");
    for (std::size_t row = 0; row < p.step.size(); ++row) p.step[row] = p.scene_A.load.indentation_steps - 1 + row;
    problems.push_back(std::move(p));
  }
  return problems;
}

double worst_difference(const TableOne& table) {
  double worst = 0;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const TableOneRow &ours = table[row], &paper = paper_table_one()[row];
    worst = std::max({worst, std::abs(ours.sigma_y / paper.sigma_y - 1), std::abs(ours.tau_xy / paper.tau_xy - 1)});
  }
  return worst;
}

std::vector<SensitivityRow> sensitivity_study(Executor& executor, const fem::Scene& choice) {
  const auto all = scene_variants(choice);
  std::vector<fem::Scene> scenes;
  scenes.reserve(all.size());
  for (const SceneVariant& variant : all) scenes.push_back(variant.scene);
  const auto problems = solve_direct_problems(executor, scenes);
  std::vector<SensitivityRow> rows;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const TableOne table = problems[i].table();
    rows.push_back({all[i].parameter, all[i].value, same_choice(all[i].scene, choice), table, worst_difference(table),
                    problems[i].A.steps.back().slip_index.value_or(0)});
  }
  return rows;
}

}  // namespace tactel::host
