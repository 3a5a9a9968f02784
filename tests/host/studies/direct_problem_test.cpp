// SPDX-License-Identifier: Apache-2.0

// The paper's Table I from the program, against the figures that the paper printed.
#include "host/studies/paper/direct_problem.h"

#include <gtest/gtest.h>

#include "host/scenes/scene_file.h"
#include "tests/host/device/test_device.h"

namespace direct_problem_test {

using namespace tactel;
using namespace tactel::host;

/// 6 % is what is asked of the preset; it was chosen so, and reaches 4 %.
TEST(DirectProblem, TableOneIsThePapersWithinSixPercent) {
  const TableOne table = solve_direct_problems(executor(), {paper_preset()}).front().table();
  for (std::size_t row = 0; row < table.size(); ++row) {
    const TableOneRow& paper = paper_table_one()[row];
    EXPECT_NEAR(table[row].u_x, paper.u_x, 1e-12);
    EXPECT_NEAR(table[row].sigma_y, paper.sigma_y, 0.06 * paper.sigma_y) << "row " << row;
    EXPECT_NEAR(table[row].tau_xy, paper.tau_xy, 0.06 * paper.tau_xy) << "row " << row;
  }
}

/// A mesh compared with itself has no error: the spline goes through its points.
TEST(DirectProblem, AMeshHasNoErrorAgainstItself) {
  DirectProblem p = solve_direct_problems(executor(), {paper_preset()}).front();
  p.B = p.A;
  for (const TableOneRow& row : p.table()) {
    EXPECT_LT(row.sigma_y, 1e-9);
    EXPECT_LT(row.tau_xy, 1e-9);
  }
}

/// The ten figures feel the open parameters: a study in which they did not would say nothing.
TEST(DirectProblemNightly, EveryOpenParameterMovesTableOne) {
  const auto rows = sensitivity_study(executor(), paper_preset());
  int chosen = 0;
  for (const SensitivityRow& row : rows) {
    chosen += row.chosen;
    if (row.chosen) {
      EXPECT_LT(row.worst, 0.06) << row.parameter;
    }
  }
  EXPECT_EQ(chosen, 6);  // once for each parameter
  for (const char* parameter : {"Poisson's ratio", "grading, bottom row over top row", "radius of the parabola, mm",
                                "friction", "element, base stress", "indentation steps"}) {
    double worst = 0;
    for (const SensitivityRow& row : rows)
      if (row.parameter == parameter) worst = std::max(worst, row.worst);
    EXPECT_GT(worst, 0.10) << parameter;
  }
}

}  // namespace direct_problem_test
