// SPDX-License-Identifier: Apache-2.0

// How often the uncertainty that `solve --converge` states covers the answer of smaller cells:
//
//     build/bench/tactel_converge_study [lines|pads, both] [SCENES, 40] [SEED, 4077] [FIRST, 0]
//
// Scenes are those of `tactel tradeoff`, each judged at another load step. The answer beside the limit has 360
// elements, three times the finest: ten seconds a line; or 96 x 96 cells, one and a half times the finest along a side:
// half a minute a pad. Values that do not change with the cells, such as S = 1, do not count.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string>

#include "fem/layer/layer_model.h"
#include "fem/layer/patch_reference.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_mix.h"
#include "fem/pad/pad_reference.h"
#include "host/answers/convergence.h"
#include "host/studies/tradeoff/scene_mix.h"

namespace tactel::host {
namespace {

struct Tally {
  std::size_t values = 0, covered = 0, with_order = 0, between = 0;  ///< between: orders above 0.5, below 2
  std::vector<double> uncertainty, error, finest;  ///< over the larger of P and the value; of S itself
};

void add(std::map<std::string, Tally>& all, int scene, const Convergence& found) {
  if (found.quantities.empty()) fmt::print("scene {}: {}", scene, convergence_table(found));
  double P = 1;
  for (const ConvergedQuantity& q : found.quantities) {
    if (q.name == "P") P = q.answer;
    if (q.fit.trend == std::string("constant")) continue;
    const double scale = q.name == "S" ? 1 : q.name[0] == 's' ? q.answer : std::max(P, std::abs(q.answer));
    const double error = std::abs(q.error()), uncertainty = q.fit.uncertainty;
    const bool covered = error <= uncertainty;
    if (!covered)
      fmt::print("  scene {}, step {}, {}: {:.6g} is not {:.6g} +- {:.2g}, {}, order {:g}\n", scene, found.step + 1,
                 q.name, q.answer, q.fit.limit, uncertainty, q.fit.trend, q.fit.order);
    for (Tally* tally : {&all[q.name], &all["all"]}) {
      ++tally->values, tally->covered += covered;
      tally->with_order += q.fit.order > 0, tally->between += q.fit.order > 0.5 && q.fit.order < 2;
      tally->uncertainty.push_back(uncertainty / scale), tally->error.push_back(error / scale);
      tally->finest.push_back(std::abs(q.values.back() - q.answer) / scale);
    }
  }
  std::fflush(stdout);
}

void print(const std::map<std::string, Tally>& all) {
  fmt::print(
      "{:<8}{:>8}{:>9}{:>12}{:>10}   median and 95 % of: uncertainty; limit, finest rung less the finer answer\n", "",
      "values", "covered", "with order", "0.5 to 2");
  for (const auto& [name, t] : all) {
    fmt::print("{:<8}{:>8}{:>8.1f}%{:>12}{:>10}  ", name, t.values, 100.0 * double(t.covered) / double(t.values),
               t.with_order, t.between);
    for (const auto& values : {t.uncertainty, t.error, t.finest})
      fmt::print(" {:.5f} {:.5f};", covering_value(values, 0.5), covering_value(values, 0.95));
    fmt::print("\n");
  }
}

void lines(int first, int count, std::uint64_t seed) {
  std::map<std::string, Tally> all;
  const std::vector<fem::Scene> scenes = mixed_scenes(seed, count);
  for (int i = first; i < count; ++i) {
    SolveOutcome finer;
    finer.scene = scenes[i];
    finer.solution =
        fem::PatchReference(fem::layer_model(scenes[i].sensor), {.elements = 360, .pressing_increments = 60})
            .solve(scenes[i]);
    add(all, i, converge(finer, i % finer.solution.steps.size()));
  }
  fmt::print("lines {} to {} of seed {}\n", first, count - 1, seed);
  print(all);
}

void pads(int first, int count, std::uint64_t seed) {
  std::map<std::string, Tally> all;
  fem::PadMix mix(static_cast<unsigned>(seed));
  for (int i = 0; i < count; ++i) {
    PadOutcome finer;
    finer.scene = mix();
    if (i < first) continue;
    const fem::PadLayer layer = fem::pad_layer(finer.scene.sensor.poisson);
    finer.solution = fem::PadReference(layer, fem::pad_reference_options(96)).solve(finer.scene).solution;
    add(all, i, converge(finer, i % finer.solution.steps.size()));
  }
  fmt::print("pads {} to {} of seed {}\n", first, count - 1, seed);
  print(all);
}

}  // namespace
}  // namespace tactel::host

int main(int count, char** arguments) {
  const std::string which = count > 1 ? arguments[1] : "";
  const int scenes = count > 2 ? std::atoi(arguments[2]) : 40, first = count > 4 ? std::atoi(arguments[4]) : 0;
  const std::uint64_t seed = count > 3 ? std::strtoull(arguments[3], nullptr, 10) : 4077;
  if (which != "pads") tactel::host::lines(first, scenes, seed);
  if (which != "lines") tactel::host::pads(first, scenes, seed);
}
