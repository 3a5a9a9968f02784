#pragma once
#include <array>
#include <string>
#include <vector>

#include "fem/contact_solution.h"
#include "fem/scene.h"
#include "host/executor.h"

namespace tactel::host {

/// The paper's section IV again: what the coarse mesh B (41 x 11) costs against the fine mesh A (123 x 33).

/// A row of Table I: largest errors of mesh B in percent of the largest stress on mesh A, equations (6) and (7).
struct TableOneRow {
  double u_x = 0;  ///< mm, tangential displacement of the indenter
  double sigma_y = 0, tau_xy = 0;
};
using TableOne = std::array<TableOneRow, 5>;

/// What the paper printed.
const TableOne& paper_table_one();

/// Both simulations of one choice of the parameters that the paper leaves open.
struct DirectProblem {
  fem::Scene scene_A, scene_B;
  fem::ContactSolution A, B;
  std::array<std::size_t, 5> step;  ///< which load steps of both are the five displacements

  /// Errors of B along A's base nodes, percent: B through a cubic spline, at displacement `row`.
  std::vector<double> sigma_y_error(std::size_t row) const, tau_xy_error(std::size_t row) const;
  TableOne table() const;
};

/// A scene on mesh B or A (stress wanted at every base node), pressed and dragged as Table I says.
fem::Scene on_mesh(fem::Scene choice, char mesh);

/// Solves choices side by side, fp64. Throws std::runtime_error where a step does not converge.
std::vector<DirectProblem> solve_direct_problems(Executor& executor, const std::vector<fem::Scene>& choices);

/// One parameter of the choice changed to other values: what it does to Table I.
struct SensitivityRow {
  std::string parameter, value;
  bool chosen = false;  ///< the value of the preset
  TableOne table{};
  double worst = 0;       ///< largest difference from the paper's ten figures, relative
  double slip_index = 0;  ///< S on mesh A at the last displacement
};

/// Poisson's ratio, grading, radius, friction, element and recovery, and indentation steps, one at a time.
std::vector<SensitivityRow> sensitivity_study(Executor& executor, const fem::Scene& choice);

/// Largest relative difference of the ten figures from the paper's.
double worst_difference(const TableOne& table);

}  // namespace tactel::host
