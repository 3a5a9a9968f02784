// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "fem/numbers/angles.h"
#include "host/answers/answer_forms.h"
#include "host/answers/convergence.h"
#include "host/answers/step_quantities.h"
#include "host/answers/warnings.h"

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

std::string friction_of(const fem::Scene& scene) { return fmt::format("{:g}", scene.friction); }
std::string friction_of(const fem::PadScene& scene) {
  return scene.friction_map ? fem::friction_text(scene) : fmt::format("{:g}", scene.friction);
}

/// `rubber`: "20 x 2". `model`: with its rung.
std::string header(const auto& outcome, const std::string& rubber, const std::string& model) {
  const auto& [scene, s] = std::tie(outcome.scene, outcome.scene.sensor);
  const std::string layers = s.layers.empty() ? "" : fmt::format("{} layers, at the surface ", s.layers.size());
  return fmt::format("{}{}{} on {} mm of rubber, {}E = {:g} MPa, nu = {:g}, mu = {}\n{}, solver {}, {}\n{}\n\n",
                     scene.title, scene.title.empty() ? "" : "\n", fem::shape_name(scene.indenter.shape), rubber,
                     layers, s.young, s.poisson, friction_of(scene), model, outcome.solver, outcome.precision,
                     outcome.device);
}

// ---- of a line

std::string row(std::size_t number, const fem::ContactStep& step) {
  const auto count = [&](fem::GapStatus status) { return std::ranges::count(step.status, status); };
  const std::string index = step.slip_index ? fixed(*step.slip_index, 4) : "-";
  return fmt::format("{:>4} {:>7} {:>7} {:>7} {:>7} {:>7}{:>5}{:>6}{:>5}{:>6}{:>4}{:>9.1e}\n", number,
                     short_number(step.indentation), short_number(step.tangential), short_number(step.P),
                     short_number(without_rounding(step.Q, step.P)), index, count(fem::GapStatus::open),
                     count(fem::GapStatus::stick), count(fem::GapStatus::slip), step.iterations,
                     step.converged ? "yes" : "NO", largest_residual(step));
}

// ---- of a pad

/// A part of the tangential load with as many digits as P has.
std::string beside(double P, double part) {
  const double value = without_rounding(part, P);
  if (P < 0.01 || P >= 1000) return short_number(value);
  return fixed(value, P < 10 ? 4 : P < 100 ? 3 : 2);
}

std::string pad_row(std::size_t number, const fem::PadStep& step) {
  return fmt::format("{:>4} {:>7} {:>7} {:>7} {:>5.3g} {:>7} {:>7} {:>7} {:>7} {:>6} {:>4.0f}\n", number,
                     short_number(step.indentation), short_number(step.x), short_number(step.y),
                     fem::degrees(step.twist), short_number(step.P), beside(step.P, step.Q[0]),
                     beside(step.P, step.Q[1]), beside(step.P, step.M),
                     step.slip_index ? fixed(*step.slip_index, 4) : "-", 100 * step.stick_fraction);
}

}  // namespace

std::string answer_table(const SolveOutcome& outcome) {
  const fem::Sensor& s = outcome.scene.sensor;
  std::string out = header(outcome, fmt::format("{:g} x {:g}", s.length, s.thickness), model_name(outcome));
  out += fmt::format("{:>4} {:>7} {:>7} {:>7} {:>7} {:>7}{:>5}{:>6}{:>5}{:>6}{:>4}{:>9}\n", "step", "depth", "drag",
                     "P", "Q", "S", "open", "stick", "slip", "iter", "met", "residual");
  out += fmt::format("{:>4} {:>7} {:>7} {:>7} {:>7} {:>7}{:>16}{:>19}\n", "", "mm", "mm", "N/mm", "N/mm", "Q/mu P",
                     outcome.on_patch() ? "elements" : "surface nodes", "largest");
  const auto& steps = outcome.solution.steps;
  for (std::size_t k = 0; k < steps.size(); ++k) out += row(k + 1, steps[k]);
  if (outcome.solution.sliding) out += "the whole contact slides\n";
  if (never_slid(outcome.scene, outcome.solution)) out += "the contact does not slide as a whole\n";
  if (outcome.error) {
    const AnswerError& e = outcome.error->expected;
    out += fmt::format(
        "error of the {} to expect (from {}): S {:.2g},\n  P {}, Q {}, sigma_y {}, tau_xy {} of the largest\n",
        outcome.on_patch() ? "patch" : "mesh", outcome.error->from, e.S, percent(e.P), percent(e.Q), percent(e.sigma),
        percent(e.tau));
  }
  if (outcome.solution.linear_elements)
    out += "wide elements on thin rubber: their pressures are linear, solved on the host in fp64\n";
  else if (outcome.solution.fell_back)
    out += "the sweeps did not converge: solved on the host by the exact fallback, in fp64\n";
  if (outcome.convergence) out += convergence_table(*outcome.convergence);
  return out;
}

std::string answer_table(const PadOutcome& outcome) {
  const fem::PadSensor& s = outcome.scene.sensor;
  std::string out = header(outcome, fmt::format("{} x {} tactels, {:g}", s.tactels[0], s.tactels[1], s.thickness),
                           fmt::format("{} ({})", model_name(outcome), outcome.rung.name));
  out += fmt::format("{:>4} {:>7} {:>7} {:>7} {:>5} {:>7} {:>7} {:>7} {:>7} {:>6} {:>4}\n", "step", "depth", "x", "y",
                     "twist", "P", "Qx", "Qy", "M", "S", "stick");
  out += fmt::format("{:>4} {:>7} {:>7} {:>7} {:>5} {:>7} {:>7} {:>7} {:>7} {:>6} {:>4}\n", "", "mm", "mm", "mm", "deg",
                     "N", "N", "N", "N mm", "", "%");
  const auto& steps = outcome.solution.steps;
  double residual = 0;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    out += pad_row(k + 1, steps[k]);
    residual = std::max(residual, largest_residual(steps[k]));
  }
  const auto met = std::ranges::count_if(steps, &fem::PadStep::converged);
  out += fmt::format("{} of {} steps met the tolerance; largest residual {:.1e}\n", met, steps.size(), residual);
  if (outcome.error) {
    const AnswerError& e = outcome.error->expected;
    out += fmt::format("error in S to expect: {:.2g} ({})\n  P {}, Q {}, M {}, sigma_z {}, tau {} of the largest\n",
                       e.S, judged_by(*outcome.error), percent(e.P), percent(e.Q), percent(e.M), percent(e.sigma),
                       percent(e.tau));
  }
  if (outcome.solution.fell_back) out += "the sweeps did not converge: solved on the host by the twin, in fp64\n";
  if (outcome.convergence) out += convergence_table(*outcome.convergence);
  return out;
}

}  // namespace tactel::host
