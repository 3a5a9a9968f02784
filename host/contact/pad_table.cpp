// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pad_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "fem/angles.h"
#include "host/contact/convergence.h"
#include "host/contact/solution_table.h"

namespace tactel::host {
namespace {

std::string pad_header(const PadOutcome& outcome) {
  const fem::PadSensor& s = outcome.scene.sensor;
  std::string out = outcome.scene.title.empty() ? "" : outcome.scene.title + "\n";
  out += fmt::format("{} on {} x {} tactels, {:g} mm of rubber, E = {:g} MPa, nu = {:g}, mu = {:g}\n",
                     fem::shape_name(outcome.scene.indenter.shape), s.tactels[0], s.tactels[1], s.thickness, s.young,
                     s.poisson, outcome.scene.friction);
  return out + fmt::format("{} ({}), solver {}, {}\n{}\n\n", model_name(outcome), outcome.rung.name, outcome.solver,
                           outcome.precision, outcome.device);
}

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

std::string error_line(const PadError& error) {
  const auto& e = error.most95;
  return fmt::format("error in S to expect: {:.2g} ({})\n  P {}, Q {}, M {}, sigma_z {}, tau {} of the largest\n",
                     e.slip_index, judged_by(error), percent(e.P), percent(e.Q), percent(e.M), percent(e.sigma),
                     percent(e.tau));
}

}  // namespace

std::string pad_table(const PadOutcome& outcome) {
  std::string out = pad_header(outcome);
  out += fmt::format("{:>4} {:>7} {:>7} {:>7} {:>5} {:>7} {:>7} {:>7} {:>7} {:>6} {:>4}\n", "step", "depth", "x", "y",
                     "twist", "P", "Qx", "Qy", "M", "S", "stick");
  out += fmt::format("{:>4} {:>7} {:>7} {:>7} {:>5} {:>7} {:>7} {:>7} {:>7} {:>6} {:>4}\n", "", "mm", "mm", "mm", "deg",
                     "N", "N", "N", "N mm", "", "%");
  const auto& steps = outcome.solution.steps;
  double residual = 0;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    out += pad_row(k + 1, steps[k]);
    residual = std::max(residual, steps[k].residual.largest());
  }
  const auto met = std::ranges::count_if(steps, &fem::PadStep::converged);
  out += fmt::format("{} of {} steps met the tolerance; largest residual {:.1e}\n", met, steps.size(), residual);
  if (outcome.error) out += error_line(*outcome.error);
  if (outcome.solution.fell_back) out += "the sweeps did not converge: solved on the host by the twin, in fp64\n";
  if (outcome.convergence) out += convergence_table(*outcome.convergence);
  return out;
}

}  // namespace tactel::host
