// SPDX-License-Identifier: Apache-2.0

// Errors of the rungs of pads, by class of scenes, on the mix of fem/pad/pad_mix.h against the
// reference, whose own error is printed too; with cell sizes that scenes share, as `solve` has them, and fitted ones:
//
//     build/bench/tactel_pad_study [SCENES, 72] [SEED, 2026] [FILE] [ANSWERS]
//
// FILE becomes host/contact/measured_pads.cpp. ANSWERS, a folder, keeps the reference's answers, ten seconds each, so
// that other solvers can be judged by them.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <vector>

#include "fem/pad/pad_mix.h"
#include "fem/pad/pad_reference.h"
#include "host/contact/pad_rung.h"

namespace tactel::host {
namespace {

using Errors = fem::PadReferenceSolution::Errors;
constexpr std::array<double Errors::*, 6> members = {&Errors::slip_index, &Errors::P,     &Errors::Q,
                                                     &Errors::M,          &Errors::sigma, &Errors::tau};
constexpr std::array<const char*, 6> member_names = {"S", "P", "Q", "M", "sigma", "tau"};

/// Numbers of an answer that errors are made of, in order.
template <class F>
void each_number(fem::PadReferenceSolution& answer, F f) {
  f(answer.solution.cells.hx), f(answer.solution.cells.hy);
  for (const auto member : members) f(answer.error.*member);
  for (fem::PadStep& step : answer.solution.steps) {
    f(step.P), f(step.Q[0]), f(step.Q[1]), f(step.M), f(*step.slip_index);
    for (double& stress : step.stress.reshaped()) f(stress);
  }
}

/// The reference's answer to a scene: from a file of an earlier run, or solved and written there.
fem::PadReferenceSolution judge(const fem::PadScene& scene, const fem::PadLayer& layer, const std::string& path) {
  fem::PadReferenceSolution answer;
  if (std::ifstream in(path); !path.empty() && in) {
    answer.solution.cells.n = fem::PadReferenceOptions{}.cells;
    answer.solution.steps.resize(fem::pad_targets(scene.load).size());
    for (fem::PadStep& step : answer.solution.steps)
      step.slip_index = 0, step.stress.resize(scene.sensor.tactels[0] * scene.sensor.tactels[1], 3);
    each_number(answer, [&](double& number) { in >> number; });
    if (in) return answer;
  }
  answer = fem::PadReference(layer).solve(scene);
  if (path.empty()) return answer;
  std::ofstream out(path);
  each_number(answer, [&](double& number) { out << fmt::format("{}\n", number); });
  return answer;
}

double quantile(std::vector<double> values, double share) {
  std::ranges::sort(values);
  const auto k = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  return values.at(std::max<std::size_t>(k, 1) - 1);
}

PadErrors quantiles(const std::vector<Errors>& errors, double Errors::*member) {
  std::vector<double> values;
  for (const Errors& e : errors) values.push_back(e.*member);
  return {quantile(values, 0.5), quantile(values, 0.95), quantile(values, 1)};
}

void print(const std::string& what, const std::vector<Errors>& errors) {
  fmt::print("  {:<14}{:3}", what, errors.size());
  for (std::size_t k = 0; k < members.size(); ++k) {
    const PadErrors q = quantiles(errors, members[k]);
    fmt::print(" | {} {:.4f} {:.4f} {:.4f}", member_names[k], q.median, q.most95, q.largest);
  }
  fmt::print("\n");
}

/// Errors of a rung by class; the last of them all.
using ByClass = std::array<std::vector<Errors>, pad_classes + 1>;

void print(const std::string& what, const ByClass& errors) {
  fmt::print("{}: median, 95 % and largest of each error\n", what);
  for (int k = 0; k < pad_classes; ++k) print(name(static_cast<PadClass>(k)), errors[k]);
  print("all", errors[pad_classes]);
}

int run(int count, unsigned seed, const char* file, const std::string& answers) {
  if (!answers.empty()) std::filesystem::create_directories(answers);
  ByClass own;
  std::map<std::string, ByClass> laddered, fitted;
  fem::PadMix mix(seed);
  for (int i = 0; i < count; ++i) {
    const fem::PadScene scene = mix();
    const fem::PadLayer layer(scene.sensor.poisson);
    const fem::PadReferenceSolution truth =
        judge(scene, layer, answers.empty() ? "" : fmt::format("{}/{}_{:03}.txt", answers, seed, i));
    const auto add = [&, of = static_cast<int>(pad_class(scene))](ByClass& to, const Errors& error) {
      to[of].push_back(error), to[pad_classes].push_back(error);
    };
    add(own, truth.error);
    for (const PadRung& rung : pad_rungs()) {
      if (rung.exact) continue;
      fem::PadOptions options{.cells = rung.cells, .pressing_increments = rung.increments};
      add(laddered[rung.name], fem::pad_difference(fem::PadSolver(layer, options).solve(scene), truth.solution));
      options.ladder = false;
      add(fitted[rung.name], fem::pad_difference(fem::PadSolver(layer, options).solve(scene), truth.solution));
    }
  }
  fmt::print("{} scenes of seed {}\n", count, seed);
  print("the reference, its own estimate", own);
  for (const PadRung& rung : pad_rungs()) {
    if (rung.exact) continue;
    print(rung.name, laddered[rung.name]);
    print(rung.name + ", cells fitted", fitted[rung.name]);
  }
  if (file == nullptr) return 0;
  std::ofstream out(file);
  out << fmt::format(
      "// SPDX-License-Identifier: Apache-2.0\n\n// Written by `tactel_pad_study {} {} FILE`; do not edit.\n"
      "// Errors in S against the reference of {} contacts of nine shapes: H 1 to 4 mm, nu 0.3 to 0.5, mu 0.1 to 1.5,\n"
      "// 2 to 20 % of H deep, eight drags, half of them with twists. By class: smooth, sharp edge, rounded edge, "
      "tilted.\n#include \"host/contact/pad_rung.h\"\n\nnamespace tactel::host {{\n\n"
      "std::span<const MeasuredPadRung> measured_pads() {{\n  static constexpr MeasuredPadRung rungs[] = {{\n",
      count, seed, count);
  for (const PadRung& rung : pad_rungs()) {
    if (rung.exact) continue;
    out << fmt::format("      {{\"{}\",\n       {{{{", rung.name);
    for (int k = 0; k < pad_classes; ++k) {
      const PadErrors q = quantiles(laddered[rung.name][k], &Errors::slip_index);
      out << fmt::format("{}{{{:.4f}, {:.4f}, {:.4f}}}", k == 0 ? "" : ", ", q.median, q.most95, q.largest);
    }
    out << "}}},\n";
  }
  out << "  };\n  return rungs;\n}\n\n}  // namespace tactel::host\n";
  return out.flush() ? 0 : 1;
}

}  // namespace
}  // namespace tactel::host

int main(int count, char** arguments) {
  const int scenes = count > 1 ? std::atoi(arguments[1]) : 72;
  const auto seed = static_cast<unsigned>(count > 2 ? std::atoi(arguments[2]) : 2026);
  return tactel::host::run(scenes, seed, count > 3 ? arguments[3] : nullptr, count > 4 ? arguments[4] : "");
}
