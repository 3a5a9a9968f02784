// SPDX-License-Identifier: Apache-2.0
#include "host/contact/solution_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fem/contact_laws.h"
#include "host/contact/convergence.h"

namespace tactel::host {

std::string fixed(double value, int digits) {
  const std::string text = fmt::format("{:.{}f}", value, digits);
  return text.find_first_not_of("-0.") == std::string::npos && text.front() == '-' ? text.substr(1) : text;
}

std::string short_number(double value) {
  const double size = std::abs(value);
  if (size == 0 || (size >= 0.01 && size < 10)) return fixed(value, 4);
  if (size >= 1e-3 && size < 0.01) return fixed(value, 6);
  if (size >= 10 && size < 100) return fixed(value, 3);
  return size >= 100 && size < 1000 ? fixed(value, 2) : fmt::format("{:.3e}", value);
}

std::string percent(double share) {
  return share < 0.995 ? fmt::format("{:.2g} %", 100 * share) : fmt::format("{:.0f} %", 100 * share);
}

double without_rounding(double Q, double P) { return std::abs(Q) < 1e-6 * P ? 0 : Q; }

namespace {

std::string header(const fem::Scene& scene, const SolveOutcome& outcome) {
  const fem::Sensor& s = scene.sensor;
  std::string out = scene.title.empty() ? "" : scene.title + "\n";
  out += fmt::format("{} on {:g} x {:g} mm of rubber, E = {:g} MPa, nu = {:g}, mu = {:g}\n",
                     fem::shape_name(scene.indenter.shape), s.length, s.thickness, s.young, s.poisson, scene.friction);
  out += fmt::format("{}, solver {}, {}\n", model_name(outcome), outcome.solver, outcome.precision);
  return out + fmt::format("{}\n\n", outcome.device);
}

std::string row(std::size_t number, const fem::ContactStep& step) {
  const auto count = [&](fem::GapStatus status) { return std::ranges::count(step.status, status); };
  const std::string index = step.slip_index ? fixed(*step.slip_index, 4) : "-";
  return fmt::format("{:>4} {:>7} {:>7} {:>7} {:>7} {:>7}{:>5}{:>6}{:>5}{:>6}{:>4}{:>9.1e}\n", number,
                     short_number(step.indentation), short_number(step.tangential), short_number(step.P),
                     short_number(without_rounding(step.Q, step.P)), index, count(fem::GapStatus::open),
                     count(fem::GapStatus::stick), count(fem::GapStatus::slip), step.iterations,
                     step.converged ? "yes" : "NO", fem::largest(step.residual));
}

std::string mesh_error_line(const SolveOutcome& outcome) {
  const AnswerError& e = outcome.mesh_error->expected;
  return fmt::format(
      "error of the {} to expect (from {}): S {:.2g},\n  P {}, Q {}, sigma_y {}, tau_xy {} of the largest\n",
      outcome.on_patch() ? "patch" : "mesh", outcome.mesh_error->finer, e.S, percent(e.P), percent(e.Q),
      percent(e.sigma), percent(e.tau));
}

}  // namespace

std::string solution_table(const fem::Scene& scene, const SolveOutcome& outcome) {
  std::string out = header(scene, outcome);
  out += fmt::format("{:>4} {:>7} {:>7} {:>7} {:>7} {:>7}{:>5}{:>6}{:>5}{:>6}{:>4}{:>9}\n", "step", "depth", "drag",
                     "P", "Q", "S", "open", "stick", "slip", "iter", "met", "residual");
  out += fmt::format("{:>4} {:>7} {:>7} {:>7} {:>7} {:>7}{:>16}{:>19}\n", "", "mm", "mm", "N/mm", "N/mm", "Q/mu P",
                     outcome.on_patch() ? "elements" : "surface nodes", "largest");
  const auto& steps = outcome.solution.steps;
  for (std::size_t k = 0; k < steps.size(); ++k) out += row(k + 1, steps[k]);
  if (outcome.solution.sliding) out += "the whole contact slides\n";
  if (never_slid(scene, outcome.solution)) out += "the contact does not slide as a whole\n";
  if (outcome.mesh_error) out += mesh_error_line(outcome);
  if (outcome.solution.linear_elements)
    out += "wide elements on thin rubber: their pressures are linear, solved on the host in fp64\n";
  else if (outcome.solution.fell_back)
    out += "the sweeps did not converge: solved on the host by the exact fallback, in fp64\n";
  if (outcome.convergence) out += convergence_table(*outcome.convergence);
  return out;
}

}  // namespace tactel::host
