// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "fem/gap/contact_solution.h"
#include "fem/scenes/scene.h"
#include "host/device/executor.h"
#include "host/figures/page.h"

namespace tactel::host {

/// Section IV of the paper: the error of the coarse mesh B (41 x 11) beside the fine mesh A (123 x 33).

/// A row of Table I: largest errors of mesh B in percent of the largest stress on mesh A, equations (6) and (7).
struct TableOneRow {
  double u_x = 0;  ///< mm, tangential displacement of the indenter
  double sigma_y = 0, tau_xy = 0;
};
using TableOne = std::array<TableOneRow, 5>;

/// Returns Table I as printed in the paper.
const TableOne& paper_table_one();

/// Both simulations, for one choice of the parameters that the paper leaves open.
struct DirectProblem {
  fem::Scene scene_A, scene_B;
  fem::ContactSolution A, B;
  std::array<std::size_t, 5> step;  ///< load steps of the five displacements

  /// Return the errors of B along the base nodes of A, percent, at displacement `row`. B is interpolated by a
  /// cubic spline.
  std::vector<double> sigma_y_error(std::size_t row) const, tau_xy_error(std::size_t row) const;
  TableOne table() const;
};

/// Returns a scene on mesh B or A with stress at every base node, pressed and dragged as in Table I.
fem::Scene on_mesh(fem::Scene choice, char mesh);

/// Solves choices in parallel, fp64. Throws std::runtime_error where a step does not converge.
std::vector<DirectProblem> solve_direct_problems(Executor& executor, const std::vector<fem::Scene>& choices);

/// Effect on Table I of one parameter of the choice.
struct SensitivityRow {
  std::string parameter, value;
  bool chosen = false;  ///< the value of the preset
  TableOne table{};
  double worst = 0;       ///< largest relative difference from the ten numbers of the paper
  double slip_index = 0;  ///< S on mesh A at the last displacement
};

/// Varies Poisson's ratio, grading, radius, friction, element and recovery, and indentation steps, one at a time.
std::vector<SensitivityRow> sensitivity_study(Executor& executor, const fem::Scene& choice);

/// Returns the largest relative difference of the ten numbers from those of the paper.
double worst_difference(const TableOne& table);

/// Solves the paper's direct problem and adds it to the report: Table I, Figures 3 to 5, and the effect on Table I
/// of the parameters that the paper leaves open. Returns table1.json: [{"u_x" mm, "sigma_y" %, "tau_xy" %}].
nlohmann::ordered_json report_direct_problem(Executor& executor, Page& page);

}  // namespace tactel::host
