// SPDX-License-Identifier: Apache-2.0
#include "host/studies/extremes/extremes.h"

#include <fmt/format.h>

#include <cmath>

#include "fem/contact_laws.h"
#include "fem/gap_reference.h"
#include "fem/solution_difference.h"
#include "host/contact/solve.h"
#include "host/contact/solve_on_rung.h"

namespace tactel::host {
namespace {

using fem::ContactSolution;
using fem::ContactStep;

struct Answered {
  ContactSolution solution;
  ExtremeAnswer answer;
};

template <class Solve>
Answered answered(const Solve& solve) {
  Answered result{solve(), {}};
  result.answer.solved = std::ranges::all_of(result.solution.steps, &ContactStep::converged);
  result.answer.fell_back = result.solution.fell_back;
  for (const ContactStep& step : result.solution.steps) {
    result.answer.iterations = std::max(result.answer.iterations, step.iterations);
    result.answer.residual = std::max(result.answer.residual, fem::largest(step.residual));
  }
  return result;
}

/// Two answers that are both certified and yet differ by more than rounding can explain.
constexpr double another_solution = 1e-6;

std::string told(const fem::Scene& scene, const Answered& fp32, const Answered& fp64, const Answered& reference) {
  std::vector<std::string> words;
  if (auto warning = depth_warning(scene, fp64.solution))
    words.push_back("warning: depth beyond 20 % of the thickness");
  const auto none = [](const ContactStep& step) { return !step.slip_index; };
  const auto missing = std::ranges::count_if(fp64.solution.steps, none);
  if (missing) words.push_back(fmt::format("S null in {} of {} steps", missing, fp64.solution.steps.size()));
  if (fp32.answer.fell_back) words.push_back("fp32: solved by the fallback");
  if (fp64.answer.fell_back) words.push_back("fp64: solved by the fallback");
  if (!fp32.answer.solved) words.push_back("fp32 NOT converged, exit 4");
  if (!fp64.answer.solved) words.push_back("fp64 NOT converged, exit 4");
  if (!reference.answer.solved) words.push_back("reference NOT converged, exit 4");
  if (fp64.answer.solved && reference.answer.solved && fp64.answer.off > another_solution)
    words.push_back("two certified solutions");
  return fmt::format("{}", fmt::join(words, "; "));
}

Extreme solve_extreme(Executor& executor, const ExtremeScene& extreme) {
  const auto batched = [&](Precision precision) {
    return answered([&] { return solve_on_meshes(executor, std::span(&extreme.scene, 1), precision).front(); });
  };
  Answered fp32 = batched(Precision::fp32), fp64 = batched(Precision::fp64);
  const Answered reference = answered([&] { return fem::solve_gap_reference(extreme.scene); });
  fp32.answer.off = fem::base_force_difference(fp32.solution, reference.solution);
  fp64.answer.off = fem::base_force_difference(fp64.solution, reference.solution);
  return {extreme.group, extreme.name,     fp32.answer,
          fp64.answer,   reference.answer, told(extreme.scene, fp32, fp64, reference)};
}

std::string columns_of(const ExtremeAnswer& answer) {
  return fmt::format("{:>6}{} {:>7.0e} {:>7.0e}", answer.iterations,
                     answer.solved ? (answer.fell_back ? "*" : " ") : "!", answer.residual, answer.off);
}

}  // namespace

std::vector<Extreme> scene_extremes(Executor& executor, bool quick, const Progress& progress) {
  std::vector<Extreme> extremes;
  const auto scenes = extreme_scenes(!quick);
  for (const ExtremeScene& extreme : scenes) {
    if (progress && !progress(extremes.size(), scenes.size())) break;
    extremes.push_back(solve_extreme(executor, extreme));
  }
  return extremes;
}

std::string extremes_table(const std::vector<Extreme>& extremes) {
  std::string out = fmt::format(
      "{:<19} {:<22} {:^23} {:^23} {:^14}\n{:<19} {:<22} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>6} {:>8}  {}\n", "", "",
      "fp32", "fp64", "reference", "what", "how far", "sweeps", "resid.", "off", "sweeps", "resid.", "off", "trials",
      "resid.", "message to the user");
  for (const Extreme& e : extremes)
    out += fmt::format("{:<19} {:<22} {} {} {:>6} {:>8.0e}  {}\n", e.group, e.name, columns_of(e.fp32),
                       columns_of(e.fp64), e.reference.iterations, e.reference.residual, e.told);
  return out +
         "sweeps, trials: most in one load step; resid.: worst of the certificate; off: base forces beside the "
         "reference's;\n"
         "*: the sweeps did not converge, the exact fallback answered; !: not converged\n";
}

}  // namespace tactel::host
