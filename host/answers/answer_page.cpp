// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <algorithm>

#include "fem/numbers/angles.h"
#include "host/answers/answer_forms.h"
#include "host/answers/convergence.h"
#include "host/answers/step_quantities.h"
#include "host/answers/warnings.h"

namespace tactel::host {
namespace {

using fem::ContactStep;
using fem::GapStatus;
using fem::PadStep;

auto number_of(const auto& step, GapStatus status) { return std::ranges::count(step.status, status); }

bool slides(const ContactStep& step) {
  return number_of(step, GapStatus::stick) == 0 && number_of(step, GapStatus::slip) > 0;
}
bool slides(const PadStep& step) { return step.P > 0 && step.stick_fraction == 0; }

std::string forces_of(const ContactStep& step) {
  return fmt::format("P = {:.3f} N/mm and Q = {:.3f} N/mm", step.P, step.Q);
}
std::string forces_of(const PadStep& step) {
  return fmt::format("P = {:.3f} N, |Q| = {:.3f} N and M = {:.3f} N mm", step.P, step.Q.norm(), step.M);
}

/// Of a line, how far it is dragged where it begins to slide.
std::string drag_of(const ContactStep& step) { return fmt::format(", at a drag of {:.3g} mm", step.tangential); }
std::string drag_of(const PadStep&) { return ""; }

/// "nodes stick, ": of `touching` nodes, elements or cells.
std::string words_of(const SolveOutcome& outcome) { return outcome.on_patch() ? "elements stick, " : "nodes stick, "; }
std::string words_of(const PadOutcome&) { return "cells stick, with "; }

std::string headline(const auto& outcome) {
  const auto& steps = outcome.solution.steps;
  const auto& last = steps.back();
  const auto stick = number_of(last, GapStatus::stick), touching = stick + number_of(last, GapStatus::slip);
  if (touching == 0) return "The indenter does not touch the rubber at the end of the path.";
  if (!last.slip_index) return fmt::format("The contact ends with {}; S is not defined.", forces_of(last));
  if (!slides(last))
    return fmt::format("The contact holds with S = {:.3f}: {} of {} touching {}{}.", *last.slip_index, stick, touching,
                       words_of(outcome), forces_of(last));
  std::size_t first = steps.size() - 1;  // of the steps at the end in which the whole contact slides
  while (first > 0 && slides(steps[first - 1])) --first;
  const std::string there = fmt::format("{:.3f}", steps[first].slip_index.value_or(*last.slip_index)),
                    end = fmt::format("{:.3f}", *last.slip_index);
  return fmt::format("The whole contact slides from load step {} on{}: S = {}{}, with {}.", first + 1,
                     drag_of(steps[first]), there, there == end ? "" : " there and " + end + " at the end",
                     forces_of(last));
}

std::string error_text(const ExpectedError& error, const char* sigma, const char* tau, const std::string& judge) {
  const AnswerError& e = error.expected;
  return fmt::format(
      "To expect from the model: {:.2g} in S, {} of the largest P, {} of the largest {} and {} of the largest {} at "
      "the "
      "tactels ({}).",
      e.S, percent(e.P), percent(e.sigma), sigma, percent(e.tau), tau, judge);
}
std::string error_of(const SolveOutcome& outcome) {
  return error_text(*outcome.error, "σ_y", "τ_xy", "beside " + outcome.error->from);
}
std::string error_of(const PadOutcome& outcome) {
  return error_text(*outcome.error, "σ_z", "τ", judged_by(*outcome.error));
}

std::string model_text(const SolveOutcome& outcome) {
  return model_name(outcome) + (outcome.model_reason.empty() ? "" : ": " + outcome.model_reason);
}
std::string model_text(const PadOutcome& outcome) {
  return fmt::format("{} ({})", model_name(outcome), outcome.rung.name);
}

void add_findings(Page& page, const auto& outcome) {
  const auto& steps = outcome.solution.steps;
  double worst = 0;
  std::size_t met = 0;
  for (const auto& step : steps) worst = std::max(worst, largest_residual(step)), met += step.converged;
  const bool all = met == steps.size();
  page.finding(
      all ? Tone::good : Tone::poor, all ? "certified" : "not met",
      fmt::format("{} of {} load steps meet the tolerance of the contact laws; the largest residual is {:.1e}.", met,
                  steps.size(), worst));
  if (outcome.error) page.finding(Tone::fact, "error", error_of(outcome));
  page.finding(Tone::fact, "model", model_text(outcome) + ".");
  for (const std::string& warning : warnings(outcome)) page.finding(Tone::fair, "warning", warning);
}

/// What all tables end with.
Cell met_cell(bool converged) { return {converged ? "yes" : "no", converged ? Tone::plain : Tone::poor}; }

PageTable steps_table(const SolveOutcome& outcome) {
  PageTable table{.caption =
                      "The load steps. P and Q are the forces of the indenter on the rubber for each millimetre "
                      "of depth along z; S = Q / µP.",
                  .head = {"step", "depth, mm", "drag, mm", "P, N/mm", "Q, N/mm", "S", "stick", "slip", "iterations",
                           "residual", "met"}};
  for (const ContactStep& step : outcome.solution.steps)
    table.add({std::to_string(table.rows.size() + 1), short_number(step.indentation), short_number(step.tangential),
               short_number(step.P), short_number(without_rounding(step.Q, step.P)),
               step.slip_index ? fixed(without_rounding(*step.slip_index, 1), 4) : "-",
               std::to_string(number_of(step, GapStatus::stick)), std::to_string(number_of(step, GapStatus::slip)),
               std::to_string(step.iterations), fmt::format("{:.1e}", largest_residual(step)),
               met_cell(step.converged)});
  return table;
}

PageTable steps_table(const PadOutcome& outcome) {
  PageTable table{.caption =
                      "The load steps. P, Q and M are the forces and the torque of the indenter on the rubber, M about "
                      "its axis. S is 1 where no larger Q and M could be borne.",
                  .head = {"step", "depth, mm", "x, mm", "y, mm", "twist, °", "P, N", "Qx, N", "Qy, N", "M, N mm", "S",
                           "|Q| / µP", "stick, %", "residual", "met"}};
  for (const PadStep& step : outcome.solution.steps) {
    const auto part = [&](double value) { return short_number(without_rounding(value, step.P)); };
    table.add({std::to_string(table.rows.size() + 1), short_number(step.indentation), short_number(step.x),
               short_number(step.y), fmt::format("{:.3g}", fem::degrees(step.twist)), short_number(step.P),
               part(step.Q[0]), part(step.Q[1]), part(step.M), step.slip_index ? fixed(*step.slip_index, 4) : "-",
               step.force_ratio ? fixed(*step.force_ratio, 4) : "-", fmt::format("{:.0f}", 100 * step.stick_fraction),
               fmt::format("{:.1e}", largest_residual(step)), met_cell(step.converged)});
  }
  return table;
}

Page page_of(const auto& outcome, std::size_t shown) {
  const auto& scene = outcome.scene;
  Page page(scene.title.empty() ? fem::shape_name(scene.indenter.shape) : scene.title,
            fmt::format("A contact solved by tactel {}: {} solver, {}, {}", TACTEL_VERSION, outcome.solver,
                        outcome.precision, outcome.device));
  page.verdict(headline(outcome));
  add_findings(page, outcome);
  page.contact(scene, outcome.solution, shown);
  page.table(steps_table(outcome));
  if (outcome.convergence) add_convergence(page, *outcome.convergence);
  return page;
}

}  // namespace

Page answer_page(const SolveOutcome& outcome, std::size_t shown) { return page_of(outcome, shown); }
Page answer_page(const PadOutcome& outcome, std::size_t shown) { return page_of(outcome, shown); }

}  // namespace tactel::host
