// SPDX-License-Identifier: Apache-2.0

// What the planner rests on: where the error of a model comes from, and how the errors of neighbouring rungs belong
// together, on the mix of scenes of `tactel tradeoff`:
//
//     build/bench/tactel_ladder_study [SCENES, 288] [SEED, 1998] [FILE]
//
// FILE becomes host/answers/measured_ladder.cpp, which was made of 640 scenes of seed 500.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <variant>

#include "bench/error_line.h"
#include "fem/gap/accuracy.h"
#include "fem/gap/gap_reference.h"
#include "host/answers/planner.h"
#include "host/contact/lines/solve_on_rung.h"
#include "host/studies/tradeoff/scene_mix.h"
#include "host/studies/tradeoff/tradeoff.h"

namespace tactel::host {
namespace {

using Answers = std::vector<fem::ContactSolution>;

/// Models that differ from the judge in one quantity alone.
struct Source {
  std::string what;
  Rung judge;
  std::vector<Rung> models;
};

Rung with(Rung rung, const std::function<void(Rung&)>& change) {
  rung.name.clear();
  change(rung);
  return rung;
}

std::vector<Source> patch_sources() {
  using enum Precision;
  const Rung& reference = ladder().back();
  const Rung patch{
      .name = "", .elements = 16, .columns = 161, .rows = 25, .steps = 6, .precision = fp64, .tolerance = 1e-8};
  std::vector<Source> all = {{"elements of a patch", reference, {}},
                             {"elements of the reference", reference, {}},
                             {"pressing increments of a patch", with(patch, [](Rung& r) { r.steps = 24; }), {}},
                             {"tolerance of a patch", patch, {}},
                             {"free sides of a patch", reference, {}}};
  for (int elements : {8, 12, 16, 24})
    all[0].models.push_back(with(patch, [&](Rung& r) { r.elements = elements, r.steps = 20; }));
  for (int elements : {30, 60}) all[1].models.push_back(with(reference, [&](Rung& r) { r.elements = elements; }));
  for (int steps : {1, 2, 3, 4, 6, 12}) all[2].models.push_back(with(patch, [&](Rung& r) { r.steps = steps; }));
  for (double tolerance : {1e-2, 1e-3, 1e-4})
    all[3].models.push_back(with(patch, [&](Rung& r) {
      r.tolerance = tolerance, r.accept = fem::slow_on_patch * tolerance, r.precision = fp32;
    }));
  for (bool sides : {true, false})
    all[4].models.push_back(with(rung_named("patch-12"), [&](Rung& r) { r.sides = sides; }));
  return all;
}

std::vector<Source> mesh_sources() {
  const Rung& finest = rung_named("mesh-641");
  const Rung middle = with(finest, [](Rung& r) { r.columns = 161; });
  std::vector<Source> all = {
      {"contact mesh (gap elements)", finest, {}},
      {"block mesh (nodes through the thickness)", with(middle, [](Rung& r) { r.rows = 49; }), {}},
      {"load steps to an indentation", with(middle, [](Rung& r) { r.steps = 40; }), {}},
      {"tolerance of the iteration", with(middle, [](Rung& r) { r.tolerance = 1e-10; }), {}},
      {"rounding (fp32, by tolerance)", with(middle, [](Rung& r) { r.tolerance = 1e-10; }), {}}};
  for (int columns : {41, 81, 161, 321})
    all[0].models.push_back(with(all[0].judge, [&](Rung& r) { r.columns = columns; }));
  for (int rows : {4, 6, 11, 17, 25}) all[1].models.push_back(with(all[1].judge, [&](Rung& r) { r.rows = rows; }));
  for (int steps : {1, 2, 4, 10, 20}) all[2].models.push_back(with(all[2].judge, [&](Rung& r) { r.steps = steps; }));
  for (double tolerance : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
    all[3].models.push_back(
        with(all[3].judge, [&](Rung& r) { r.tolerance = tolerance, r.accept = fem::slow_on_mesh * tolerance; }));
    if (tolerance < 1e-4)
      all[4].models.push_back(with(all[3].models.back(), [](Rung& r) { r.precision = Precision::fp32; }));
  }
  return all;
}

std::vector<Source> sources() {
  std::vector<Source> all = patch_sources();
  for (Source& source : mesh_sources()) all.push_back(std::move(source));
  return all;
}

void print(const MeasuredModel& model) {
  fmt::print("  {:<42}", description(std::get<Rung>(model.rung)));
  for (std::size_t k = 0; k < error_members.size(); ++k)
    fmt::print(" | {} {:8.2g} {:8.2g}", error_names[k], model.error.median.*error_members[k],
               model.error.most95.*error_members[k]);
  fmt::print(" | {:.1e}\n", model.unsolved);
}

/// Rung `low` of the ladder beside the next: what the planner reads.
MeasuredRung planner_row(std::span<const fem::Scene> scenes, std::size_t low, const std::vector<Answers>& answers) {
  constexpr double share = 0.98;
  const auto& rungs = ladder();
  const auto of_S = [&](std::size_t rung, std::size_t judge) {
    std::vector<double> values;
    for (const AnswerError& e : answer_errors(scenes, answers[rung], rungs[rung], answers[judge], rungs[judge]))
      values.push_back(e.S);
    return values;
  };
  const std::size_t last = rungs.size() - 1;
  const std::vector<double> own = of_S(low, last), differences = of_S(low, low + 1);
  return {rungs[low].name.c_str(), error_line(differences, own, share),
          error_line(differences, of_S(low + 1, last), share), covering_value(own, share)};
}

/// The finest mesh beside the reference, where the mesh resolves the contact: smooth indenters on wide contacts.
void compare_finest_mesh(std::span<const fem::Scene> scenes, const Answers& mesh, const Answers& truth) {
  constexpr double smooth_width = 2;  // mm
  std::vector<AnswerError> errors;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::Shape& shape = scenes[i].indenter.shape;
    const bool smooth = std::holds_alternative<fem::Parabola>(shape) || std::holds_alternative<fem::Cylinder>(shape) ||
                        std::holds_alternative<fem::RoundedFlat>(shape);
    if (!smooth || truth[i].surface_width.sum() < smooth_width) continue;
    errors.push_back(answer_error(scenes[i], mesh[i], rung_named("mesh-641"), truth[i], ladder().back()));
  }
  const ErrorQuantiles found = quantiles(errors);
  fmt::print(
      "finest mesh beside the reference, {} smooth contacts wider than {:g} mm: S {:.2g} (median), {:.2g} (95 %)\n",
      errors.size(), smooth_width, found.median.S, found.most95.S);
}

/// The solver on the whole mesh, which has neither condensation nor Gauss-Seidel, beside the condensed one.
void compare_full_mesh(Executor& executor, std::span<const fem::Scene> scenes) {
  const Rung rung = with(rung_named("mesh-641"), [](Rung& r) {
    r.columns = 81;
    r.rows = 17;
    r.steps = 2;
    r.tolerance = 1e-11;
  });
  const std::span some = scenes.first(std::min<std::size_t>(scenes.size(), 8));
  const Answers condensed = solve_on_rung(executor, some, rung, false);
  double off = 0;
  for (std::size_t i = 0; i < some.size(); ++i)
    off = std::max(off,
                   answer_error(some[i], condensed[i], rung, fem::solve_gap_reference(on_rung(some[i], rung)), rung).S);
  fmt::print("full mesh beside the condensed one, {}: S {:.1e}\n", description(rung), off);
}

int run(std::size_t count, std::uint64_t seed, const char* file) {
  Executor executor{Device("")};
  const std::vector<fem::Scene> all = mixed_scenes(seed, count);
  const std::span few(all.data(), std::min(count, std::max<std::size_t>(8, count / 3)));  // meshes are slow
  const auto of = [&](const Rung& rung) { return rung.patch() ? std::span(all) : few; };
  fmt::print("{}\n", mix_description(seed, count));
  std::vector<Answers> climbed;
  for (const Rung& rung : ladder()) climbed.push_back(solve_on_rung(executor, all, rung));
  const Answers& truth = climbed.back();
  std::vector<MeasuredRung> planner;
  for (std::size_t k = 0; k + 1 < climbed.size(); ++k) planner.push_back(planner_row(all, k, climbed));
  std::map<std::string, Answers> known = {{ladder().back().name, truth}};
  double own_error = 0;
  for (const Source& source : sources()) {
    const std::span<const fem::Scene> scenes = of(source.judge);
    Answers& judge = known[source.judge.name.empty() ? source.what : source.judge.name];
    if (judge.empty()) judge = solve_on_rung(executor, scenes, source.judge);
    fmt::print("\n{}; judge: {}; median and 95 % of each error, unsolved\n", source.what, description(source.judge));
    std::vector<MeasuredModel> models;
    for (const Rung& rung : source.models) {
      const Answers answers = solve_on_rung(executor, scenes, rung, false);
      models.push_back(judged_model(rung, answers, answer_errors(scenes, answers, rung, judge, source.judge)));
      print(models.back());
    }
    if (source.what != "elements of the reference") continue;
    // With error c h^p, and the judge at h: |e(4h) - e(h)| / |e(2h) - e(h)| = (4^p - 1) / (2^p - 1) = 2^p + 1.
    const double order = std::log2(std::max(models.front().error.median.S / models.back().error.median.S - 1, 1e-3));
    own_error = models.back().error.most95.S / (std::exp2(std::clamp(order, 0.5, 1.0)) - 1);
    fmt::print("  observed order {:.2f}: the reference's own error in S is below {:.2g} (95 %)\n", order, own_error);
  }
  planner.push_back({ladder().back().name.c_str(), {}, {}, own_error});
  fmt::print("\n");
  compare_finest_mesh(few, known["mesh-641"], truth);
  compare_full_mesh(executor, few);
  if (file == nullptr) return 0;
  std::ofstream out(file);
  out << fmt::format(
      "// SPDX-License-Identifier: Apache-2.0\n\n// Written by `tactel_ladder_study {} {} FILE`; do not edit.\n// {}.\n"
      "// Device: {}\n#include \"host/answers/planner.h\"\n\nnamespace tactel::host {{\n\n"
      "std::span<const MeasuredRung> measured_ladder() {{\n  static constexpr MeasuredRung rungs[] = {{\n",
      count, seed, mix_description(seed, count), executor.device().info().name);
  for (const MeasuredRung& r : planner)
    out << fmt::format("      {{\"{}\", {{{:.3g}, {:.3g}}}, {{{:.3g}, {:.3g}}}, {:.3g}}},\n", r.name, r.error.least,
                       r.error.slope, r.next_error.least, r.next_error.slope, r.most);
  out << "  };\n  return rungs;\n}\n\n}  // namespace tactel::host\n";
  return out.flush() ? 0 : 1;
}

}  // namespace
}  // namespace tactel::host

int main(int count, char** arguments) {
  const std::size_t scenes = count > 1 ? std::strtoull(arguments[1], nullptr, 10) : 288;
  const std::uint64_t seed = count > 2 ? std::strtoull(arguments[2], nullptr, 10) : 1998;
  return tactel::host::run(scenes, seed, count > 3 ? arguments[3] : nullptr);
}
