// SPDX-License-Identifier: Apache-2.0

// Writes a page with every kind of block for check_page.py, and a pad's cells for check_vtu.py: sample_page FILE.html
// FILE.vtu
#include <cmath>
#include <fstream>

#include "fem/gap/gap_reference.h"
#include "fem/pad/pad_solver.h"
#include "host/figures/contact_figure.h"
#include "host/figures/contact_view.h"
#include "host/figures/grid_field.h"
#include "host/figures/page.h"
#include "host/figures/vtu.h"

namespace {

using namespace tactel;
using namespace tactel::host;

Figure known_numbers() {
  return {.panels = {
              {.title = "panel, \"one\"",
               .x_label = "time (s)",
               .y_label = "σ_y (MPa)",
               .series = {
                   {.label = "a", .x = {0, 0.5, 1}, .y = {1.5, NAN, -2}},
                   {.label = "b", .x = {0, 1}, .y = {3, 4}, .mark = Mark::whiskers, .low = {2, 3}, .high = {5, 6}}}}}};
}

Figure every_mark() {
  Panel panel{.title = "marks", .x_ticks = {{1, "a long name of a tick"}, {2, "another long name"}}, .log_y = true};
  for (int mark = 0; mark <= static_cast<int>(Mark::whiskers); ++mark) {
    const double y = 1.0 + mark;
    panel.series.push_back({.label = "mark",
                            .x = {1, 2},
                            .y = {y, y},
                            .mark = static_cast<Mark>(mark),
                            .ink = static_cast<Ink>(mark % 8),
                            .low = {y - 0.5, y - 0.5},
                            .high = {y + 0.5, y + 0.5},
                            .names = {"n", ""}});
  }
  return {.panels = {panel,
                     {.title = "empty"},
                     {.title = "one point", .series = {{.x = {1}, .y = {1}, .mark = Mark::bars}}}},
          .columns = 3};
}

/// As wide as Table II of the report.
PageTable ranges_beside_the_paper() {
  PageTable table{.caption = "Ranges", .head = {"network"}};
  std::vector<Cell> cells = {"4 (42-42-42-1)"};
  for (const char* error : {"largest error", "mean error", "standard deviation"}) {
    table.head.insert(table.head.end(), {error, "paper", "difference"});
    cells.insert(cells.end(), {"0.0222 [0.0192, 0.0271]", "0.0026", {"+740.7 %", Tone::poor}});
  }
  for (int row = 0; row < 6; ++row) table.add(cells);
  return table;
}

fem::Scene contact() { return {.title = "parabola", .load = {.indentation = {0.15}, .tangential_step = 0.1}}; }

/// A turned box that comes down, is dragged and twisted, on a pad with sides.
fem::PadScene pad_contact() {
  return {.title = "box",
          .sensor = {.tactels = {6, 4}, .pitch = {2, 2}, .length = 15, .width = 11},
          .indenter = {.shape = fem::Box{{1.2, 0.7}, 2.5}, .position = {1.5, 0.8}, .yaw = 30},
          .load = {.indentation = {0, 0.25}, .drags = {{0.05, 0.02, 0}, {0.12, 0.05, 0}, {0.12, 0.05, 0.1}}}};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  Page page("A page of every block", "for check_page.py");
  page.verdict("All blocks stand here.");
  page.finding(Tone::good, "good", "A finding.");
  page.finding(Tone::poor, "poor",
               "Another one, with a long text that must wrap on a telephone: " + std::string(200, 'x'));
  page.section("Numbers");
  page.paragraph("σ_y is in MPa.");
  page.figure(known_numbers(), "Known numbers.");
  page.figure(every_mark(), "Every mark.");
  PageTable table{.caption = "A wide table", .head = std::vector<std::string>(14, "a column")};
  for (int row = 0; row < 20; ++row) table.add(std::vector<Cell>(14, Cell("12.345")));
  page.table(table);
  page.table(ranges_beside_the_paper());
  page.section("A contact");
  const fem::Scene scene = contact();
  const fem::ContactSolution solution = fem::solve_gap_reference(scene);
  page.contact(scene, solution, telling_step(solution));
  const fem::StressField field = fem::stress_field(scene.sensor, solution.steps.back());
  page.figure({.panels = {field_panel(field, field.stress.row(1), "σ_y", "MPa", {-10, 10})}}, "A map.");
  page.section("A contact on a pad");
  const fem::PadScene pad = pad_contact();
  const fem::PadLayer layer(pad.sensor.poisson);
  const fem::PadSolution answer = fem::PadSolver(layer).solve(pad);
  page.contact(pad, answer, telling_step(answer));
  fem::PadScene one = pad;  // a single step, normal stress alone, no sides of the pad
  one.load = {};
  one.sensor.axes = 1, one.sensor.length = {}, one.sensor.width = {};
  page.contact(one, fem::PadSolver(layer).solve(one), 0);
  std::ofstream(argv[1], std::ios::binary) << page.html();
  std::ofstream(argv[2], std::ios::binary) << to_vtu(pad, answer, telling_step(answer));
}
