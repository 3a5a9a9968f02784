// SPDX-License-Identifier: Apache-2.0
#include "host/studies/extremes/extremes_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tactel::host {
namespace {

using AnswerOf = ExtremeAnswer Extreme::*;

bool met_by_every_solver(const Extreme& e) { return e.fp32.solved && e.fp64.solved && e.reference.solved; }

void report_extremes_verdict(Page& page, const std::vector<Extreme>& extremes,
                             const std::vector<ExtremeFinding>& findings) {
  const auto solved = std::ranges::count_if(extremes, met_by_every_solver);
  const auto good = std::ranges::count_if(findings, &ExtremeFinding::good);
  const auto fell_back =
      std::ranges::count_if(extremes, [](const Extreme& e) { return e.fp32.fell_back || e.fp64.fell_back; });
  const bool all = solved == std::ssize(extremes), required = good == std::ssize(findings);
  page.verdict(
      fmt::format("{} of {} scenes at the limits are solved by every solver; {} of {} other findings are as "
                  "required.",
                  solved, extremes.size(), good, findings.size()));
  page.finding(all ? Tone::good : Tone::poor, "solvers",
               fmt::format("{} of {} scenes meet their tolerance in fp32, in fp64 and by the reference.", solved,
                           extremes.size()));
  page.finding(fell_back ? Tone::fair : Tone::good, "fallback",
               fmt::format("{} of {} scenes needed the exact fallback in fp32 or fp64.", fell_back, extremes.size()));
  page.finding(required ? Tone::good : Tone::poor, "findings",
               fmt::format("{} of {} tests of long paths, several solutions and wrong input found what is required.",
                           good, findings.size()));
}

Series numbers_of(const std::vector<Extreme>& extremes, AnswerOf answer, double ExtremeAnswer::*number,
                  const std::string& label, Mark mark, Ink ink) {
  Series series{.label = label, .mark = mark, .ink = ink};
  for (const Extreme& e : extremes) {
    const double value = (e.*answer).*number;
    series.x.push_back(static_cast<double>(series.x.size() + 1));
    series.y.push_back(value > 0 ? value : NAN);  // a logarithmic axis has no place for 0
  }
  return series;
}

Figure residual_figure(const std::vector<Extreme>& extremes) {
  const auto panel = [&](const std::string& title, double ExtremeAnswer::*number, bool reference) {
    Panel out{.title = title, .x_label = "scene, in the order of the table", .y_label = "relative", .log_y = true};
    out.series = {numbers_of(extremes, &Extreme::fp32, number, "fp32", Mark::triangles, Ink::orange),
                  numbers_of(extremes, &Extreme::fp64, number, "fp64", Mark::circles, Ink::blue)};
    if (reference)
      out.series.push_back(numbers_of(extremes, &Extreme::reference, number, "reference", Mark::crosses, Ink::black));
    return out;
  };
  return {.panels = {panel("largest residual of the contact laws", &ExtremeAnswer::residual, true),
                     panel("base forces beside the reference's", &ExtremeAnswer::off, false)},
          .columns = 2};
}

std::vector<Cell> answer_cells(const ExtremeAnswer& answer) {
  const std::string sweeps = fmt::format("{}{}", answer.iterations, answer.fell_back ? " *" : "");
  return {{sweeps, answer.solved ? Tone::plain : Tone::poor},
          fmt::format("{:.0e}", answer.residual),
          fmt::format("{:.0e}", answer.off)};
}

PageTable table_of(const std::vector<Extreme>& extremes) {
  PageTable table{.caption =
                      "The scenes. Sweeps or trials: the most in one load step, coloured where the tolerance was "
                      "missed; residual: the worst of the contact laws; off: base forces beside the reference's. "
                      "*: the exact fallback answered",
                  .head = {"what", "how far", "fp32: sweeps", "residual", "off", "fp64: sweeps", "residual", "off",
                           "reference: trials", "residual", "message to the user"}};
  for (const Extreme& e : extremes) {
    std::vector<Cell> cells{e.group, e.name};
    for (const ExtremeAnswer* answer : {&e.fp32, &e.fp64})
      for (Cell& cell : answer_cells(*answer)) cells.push_back(std::move(cell));
    cells.push_back({std::to_string(e.reference.iterations), e.reference.solved ? Tone::plain : Tone::poor});
    cells.push_back(fmt::format("{:.0e}", e.reference.residual));
    cells.push_back(e.told);
    table.add(std::move(cells));
  }
  return table;
}

}  // namespace

Page extremes_page(const std::vector<Extreme>& extremes, const std::vector<ExtremeFinding>& findings,
                   const std::string& device) {
  Page page("tactel: the solvers at the limits of valid scenes", "tactel " TACTEL_VERSION " on " + device);
  report_extremes_verdict(page, extremes, findings);
  page.section("Scenes at the limits");
  page.paragraph(
      "One quantity at a time takes its extreme values. Every scene is solved by the batched solver in fp32 "
      "and fp64, and by the reference.");
  page.figure(residual_figure(extremes),
              "Residuals of the contact laws, and the largest difference of the base forces "
              "from the reference's, over the largest of them. A value of 0 is left out.");
  page.table(table_of(extremes));
  page.section("Long paths, several solutions, wrong input");
  PageTable table{.caption = "What was asked and found", .head = {"question", "found", "as required"}};
  for (const ExtremeFinding& f : findings)
    table.add({f.question, f.found, {f.good ? "yes" : "no", f.good ? Tone::good : Tone::poor}});
  page.table(table);
  return page;
}

}  // namespace tactel::host
