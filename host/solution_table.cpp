#include "host/solution_table.h"

#include <fmt/format.h>

#include <algorithm>

namespace tactel::host {
namespace {

double largest(const fem::Residual& r) {
  return std::max({r.penetration, r.cone, r.complementarity, r.drift, r.balance});
}

std::string header(const fem::Scene& scene, const SolveOutcome& outcome) {
  const fem::Sensor& s = scene.sensor;
  std::string out = scene.title.empty() ? "" : scene.title + "\n";
  out += fmt::format("{} on {:g} x {:g} mm of rubber, E = {:g} MPa, nu = {:g}, mu = {:g}; mesh {} x {} {}\n",
                     fem::shape_name(scene.indenter.shape), s.length, s.thickness, s.young, s.poisson, scene.friction,
                     s.columns, s.rows, fem::name(s.element));
  return out + fmt::format("solver {}, {}, {}\n\n", outcome.solver, outcome.precision, outcome.device);
}

/// Without the sign of a zero.
std::string fixed(double value, int digits) {
  const std::string text = fmt::format("{:.{}f}", value, digits);
  return text.find_first_not_of("-0.") == std::string::npos && text.front() == '-' ? text.substr(1) : text;
}

std::string row(std::size_t number, const fem::ContactStep& step) {
  const auto count = [&](fem::GapStatus status) { return std::ranges::count(step.status, status); };
  const std::string index = step.slip_index ? fixed(*step.slip_index, 4) : "-";
  return fmt::format("{:>4} {:>9} {:>9} {:>11} {:>11} {:>8} {:>5} {:>5} {:>5} {:>10} {:>9} {:>9.1e}\n", number,
                     fixed(step.indentation, 5), fixed(step.tangential, 5), fixed(step.P, 6), fixed(step.Q, 6), index,
                     count(fem::GapStatus::open), count(fem::GapStatus::stick), count(fem::GapStatus::slip),
                     step.iterations, step.converged ? "yes" : "NO", largest(step.residual));
}

}  // namespace

std::string solution_table(const fem::Scene& scene, const SolveOutcome& outcome) {
  std::string out = header(scene, outcome);
  out += fmt::format("{:>4} {:>9} {:>9} {:>11} {:>11} {:>8} {:>5} {:>5} {:>5} {:>10} {:>9} {:>9}\n", "step", "depth",
                     "drag", "P", "Q", "S", "open", "stick", "slip", "iterations", "converged", "residual");
  out += fmt::format("{:>4} {:>9} {:>9} {:>11} {:>11} {:>8} {:>17} {:>29}\n", "", "mm", "mm", "N/mm", "N/mm",
                     "Q/(mu P)", "surface nodes", "largest");
  const auto& steps = outcome.solution.steps;
  for (std::size_t k = 0; k < steps.size(); ++k) out += row(k + 1, steps[k]);
  if (outcome.solution.sliding) out += "the whole contact slides\n";
  if (outcome.solution.fell_back) out += "the sweeps gave up: solved on the host by the exact fallback, in fp64\n";
  return out;
}

}  // namespace tactel::host
