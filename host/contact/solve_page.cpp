// SPDX-License-Identifier: Apache-2.0
#include "host/contact/solve_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fem/angles.h"
#include "fem/contact_laws.h"
#include "host/contact/convergence.h"
#include "host/contact/solution_table.h"

namespace tactel::host {
namespace {

using fem::ContactStep;
using fem::GapStatus;
using fem::PadStep;

auto number_of(const ContactStep& step, GapStatus status) { return std::ranges::count(step.status, status); }

std::string title_of(const fem::Scene& scene) {
  return scene.title.empty() ? fem::shape_name(scene.indenter.shape) : scene.title;
}

std::string headline(const fem::ContactSolution& solution, bool patch) {
  const ContactStep& last = solution.steps.back();
  const auto stick = number_of(last, GapStatus::stick), slip = number_of(last, GapStatus::slip);
  const std::string forces = fmt::format("P = {:.3f} N/mm and Q = {:.3f} N/mm", last.P, last.Q);
  if (stick + slip == 0) return "The indenter does not touch the rubber at the end of the path.";
  if (!last.slip_index) return fmt::format("The contact ends with {}; S is not defined.", forces);
  if (stick == 0) {
    std::size_t first = solution.steps.size() - 1;  // of the steps at the end in which the whole contact slides
    while (first > 0 && number_of(solution.steps[first - 1], GapStatus::stick) == 0 &&
           number_of(solution.steps[first - 1], GapStatus::slip) > 0)
      --first;
    return fmt::format("The whole contact slides from load step {} on, at a drag of {:.3g} mm: S = {:.3f}, with {}.",
                       first + 1, solution.steps[first].tangential, *last.slip_index, forces);
  }
  return fmt::format("The contact holds with S = {:.3f}: {} of {} touching {} stick, {}.", *last.slip_index, stick,
                     stick + slip, patch ? "elements" : "nodes", forces);
}

/// `residuals` of the steps, `met` of them within the tolerance.
void add_certificate(Page& page, const std::vector<double>& residuals, std::ptrdiff_t met) {
  const bool all = met == std::ssize(residuals);
  page.finding(
      all ? Tone::good : Tone::poor, all ? "certified" : "not met",
      fmt::format("{} of {} load steps meet the tolerance of the contact laws; the largest residual is {:.1e}.", met,
                  residuals.size(), std::ranges::max(residuals)));
}

void add_errors(Page& page, const AnswerError& e, const char* sigma, const char* tau, const std::string& judge) {
  page.finding(Tone::fact, "error",
               fmt::format("To expect from the model: {:.2g} in S, {} of the largest P, {} of the largest {} and {} of "
                           "the largest {} at the tactels ({}).",
                           e.S, percent(e.P), percent(e.sigma), sigma, percent(e.tau), tau, judge));
}

void add_findings(Page& page, const SolveOutcome& outcome) {
  const auto& steps = outcome.solution.steps;
  std::vector<double> residuals(steps.size());
  std::ranges::transform(steps, residuals.begin(), [](const ContactStep& step) { return fem::largest(step.residual); });
  add_certificate(page, residuals, std::ranges::count_if(steps, &ContactStep::converged));
  if (outcome.mesh_error) {
    add_errors(page, outcome.mesh_error->expected, "σ_y", "τ_xy", "beside " + outcome.mesh_error->finer);
  }
  page.finding(Tone::fact, "model",
               model_name(outcome) + (outcome.model_reason.empty() ? "" : ": " + outcome.model_reason) + ".");
  for (const std::string& warning : warnings(outcome)) page.finding(Tone::fair, "warning", warning);
}

PageTable steps_table(const SolveOutcome& outcome) {
  PageTable table{.caption =
                      "The load steps. P and Q are the forces of the indenter on the rubber for each millimetre "
                      "of depth along z; S = Q / µP.",
                  .head = {"step", "depth, mm", "drag, mm", "P, N/mm", "Q, N/mm", "S", "stick", "slip", "iterations",
                           "residual", "met"}};
  for (const ContactStep& step : outcome.solution.steps)
    table.add({std::to_string(table.rows.size() + 1),
               short_number(step.indentation),
               short_number(step.tangential),
               short_number(step.P),
               short_number(without_rounding(step.Q, step.P)),
               step.slip_index ? fixed(without_rounding(*step.slip_index, 1), 4) : "-",
               std::to_string(number_of(step, GapStatus::stick)),
               std::to_string(number_of(step, GapStatus::slip)),
               std::to_string(step.iterations),
               fmt::format("{:.1e}", fem::largest(step.residual)),
               {step.converged ? "yes" : "no", step.converged ? Tone::plain : Tone::poor}});
  return table;
}

// ---- of a pad

std::string title_of(const fem::PadScene& scene) {
  return scene.title.empty() ? fem::shape_name(scene.indenter.shape) : scene.title;
}

bool slides(const PadStep& step) { return step.P > 0 && step.stick_fraction == 0; }

std::string headline(const fem::PadSolution& solution) {
  const PadStep& last = solution.steps.back();
  const auto number = [&](GapStatus status) { return std::ranges::count(last.status, status); };
  const auto stick = number(GapStatus::stick), touch = stick + number(GapStatus::slip);
  const std::string forces =
      fmt::format("P = {:.3f} N, |Q| = {:.3f} N and M = {:.3f} N mm", last.P, last.Q.norm(), last.M);
  if (touch == 0) return "The indenter does not touch the rubber at the end of the path.";
  if (!last.slip_index) return fmt::format("The contact ends with {}; S is not defined.", forces);
  if (!slides(last))
    return fmt::format("The contact holds with S = {:.3f}: {} of {} touching cells stick, with {}.", *last.slip_index,
                       stick, touch, forces);
  std::size_t first = solution.steps.size() - 1;  // of the steps at the end in which the whole contact slides
  while (first > 0 && slides(solution.steps[first - 1])) --first;
  return fmt::format("The whole contact slides from load step {} on: S = {:.3f}, with {}.", first + 1, *last.slip_index,
                     forces);
}

void add_findings(Page& page, const PadOutcome& outcome) {
  const auto& steps = outcome.solution.steps;
  std::vector<double> residuals(steps.size());
  std::ranges::transform(steps, residuals.begin(), [](const PadStep& step) { return step.residual.largest(); });
  add_certificate(page, residuals, std::ranges::count_if(steps, &PadStep::converged));
  if (outcome.error) {
    const auto& e = outcome.error->most95;
    add_errors(page, {.S = e.slip_index, .P = e.P, .sigma = e.sigma, .tau = e.tau}, "σ_z", "τ",
               judged_by(*outcome.error));
  }
  page.finding(Tone::fact, "model", fmt::format("{} ({}).", model_name(outcome), outcome.rung.name));
  for (const std::string& warning : warnings(outcome)) page.finding(Tone::fair, "warning", warning);
}

PageTable steps_table(const PadOutcome& outcome) {
  PageTable table{.caption =
                      "The load steps. P, Q and M are the forces and the torque of the indenter on the rubber, M about "
                      "its axis. S is 1 where no larger Q and M could be borne.",
                  .head = {"step", "depth, mm", "x, mm", "y, mm", "twist, °", "P, N", "Qx, N", "Qy, N", "M, N mm", "S",
                           "|Q| / µP", "stick, %", "residual", "met"}};
  for (const PadStep& step : outcome.solution.steps) {
    const auto part = [&](double value) { return short_number(without_rounding(value, step.P)); };
    table.add({std::to_string(table.rows.size() + 1),
               short_number(step.indentation),
               short_number(step.x),
               short_number(step.y),
               fmt::format("{:.3g}", fem::degrees(step.twist)),
               short_number(step.P),
               part(step.Q[0]),
               part(step.Q[1]),
               part(step.M),
               step.slip_index ? fixed(*step.slip_index, 4) : "-",
               step.force_ratio ? fixed(*step.force_ratio, 4) : "-",
               fmt::format("{:.0f}", 100 * step.stick_fraction),
               fmt::format("{:.1e}", step.residual.largest()),
               {step.converged ? "yes" : "no", step.converged ? Tone::plain : Tone::poor}});
  }
  return table;
}

std::string subtitle(const auto& outcome) {
  return fmt::format("A contact solved by tactel {}: {} solver, {}, {}", TACTEL_VERSION, outcome.solver,
                     outcome.precision, outcome.device);
}

}  // namespace

Page solve_page(const PadOutcome& outcome, std::size_t shown) {
  Page page(title_of(outcome.scene), subtitle(outcome));
  page.verdict(headline(outcome.solution));
  add_findings(page, outcome);
  page.contact(outcome.scene, outcome.solution, shown);
  page.table(steps_table(outcome));
  if (outcome.convergence) add_convergence(page, *outcome.convergence);
  return page;
}

Page solve_page(const SolveOutcome& outcome, std::size_t shown) {
  Page page(title_of(outcome.scene), subtitle(outcome));
  page.verdict(headline(outcome.solution, outcome.on_patch()));
  add_findings(page, outcome);
  page.contact(outcome.scene, outcome.solution, shown);
  page.table(steps_table(outcome));
  if (outcome.convergence) add_convergence(page, *outcome.convergence);
  return page;
}

}  // namespace tactel::host
