// SPDX-License-Identifier: Apache-2.0

// Errors of S and of P that `solve` says beside those that it makes, on scenes that the ladder was not measured on:
//
//     build/bench/tactel_said_and_made [SCENES OF A CLASS, 100] [SEED, 4077] [CLASS; all]
//
// Classes: mix, of another seed than the ladder's, and those of bench/unlike_scenes.h.
//
// With TACTEL_EACH=1 every answer has a line on stderr.
//
// Inside the sensor the judge has 96 elements and 20 pressing increments; its own error is the difference from 48 and
// 10, by which the judge may be off and which therefore counts for the answer. Over an end it is the mesh of 641
// columns, beside that of 321.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>

#include "bench/unlike_scenes.h"
#include "fem/layer/layer_model.h"
#include "fem/layer/patch_reference.h"
#include "host/answers/solve.h"
#include "host/contact/lines/contact_fallback.h"
#include "host/contact/lines/contact_stream.h"
#include "host/contact/lines/patch_contact.h"
#include "host/contact/lines/solve_on_rung.h"

namespace tactel::host {
namespace {

struct Judged {
  fem::ContactSolution answer;
  AnswerError own_error{};
  bool solved = false;
};

AnswerError difference(const fem::ContactSolution& a, const fem::ContactSolution& b) {
  std::vector<std::size_t> steps(std::min(a.steps.size(), b.steps.size()));
  for (std::size_t k = 0; k < steps.size(); ++k) steps[k] = k;
  return answer_error(a, steps, b, steps);
}

Judged judge_inside(const fem::Scene& scene) {
  const fem::LayerModel model = fem::layer_model(scene.sensor);
  const auto on = [&](int elements, int increments) {
    return fem::PatchReference(model, {.elements = elements, .pressing_increments = increments}).solve(scene);
  };
  Judged judged{on(96, 20)};
  const fem::ContactSolution coarser = on(48, 10);
  judged.solved = every_step_converged(judged.answer) && every_step_converged(coarser);
  judged.own_error = difference(judged.answer, coarser);
  return judged;
}

Judged judge_over_end(Executor& executor, const fem::Scene& scene) {
  const auto on = [&](const char* name) {
    const Rung& rung = rung_named(name);
    fem::Scene meshed = on_mesh(scene, rung);
    const int parts = fem::pressing_parts(scene.load, rung.steps);
    meshed.load.indentation_steps = scene.load.indentation_steps * parts;
    ContactModel model = model_of(rung);
    std::get<MeshModel>(model.surface).options.nodes = false;
    auto answers = ContactStream(executor, model).solve(std::span(&meshed, 1));
    fem::keep_own_steps(answers.front(), scene.load, parts);
    return std::move(answers.front());
  };
  Judged judged{on("mesh-641")};
  const fem::ContactSolution coarser = on("mesh-321");
  judged.solved = every_step_converged(judged.answer);
  judged.own_error = difference(judged.answer, coarser);
  return judged;
}

struct Tally {
  std::size_t answers = 0, open = 0, kept = 0, thrice = 0;
  std::vector<double> said, made;
  double worst = 0;  ///< made over said
  std::size_t kept_P = 0;
  double worst_P = 0;
};

void add(Tally& tally, const SolveOutcome& outcome, const Judged& truth) {
  ++tally.answers;
  const auto error = mesh_error(outcome);
  const bool unknown = !error || error->expected.S >= 1;
  if (unknown || !every_step_converged(outcome.solution) || (outcome.plan && !outcome.plan->kept)) {
    ++tally.open;
    return;
  }
  const AnswerError off = difference(outcome.solution, truth.answer);
  const double made = std::max(0.0, off.S - truth.own_error.S), made_P = std::max(0.0, off.P - truth.own_error.P);
  const double said = error->expected.S;
  tally.said.push_back(said), tally.made.push_back(made);
  tally.kept += made <= said;
  tally.thrice += made <= 3 * said;
  tally.worst = std::max(tally.worst, made / std::max(said, 1e-12));
  tally.kept_P += made_P <= error->expected.P;
  tally.worst_P = std::max(tally.worst_P, made_P / std::max(error->expected.P, 1e-6));
}

void print(const std::string& what, const std::string& answer, const Tally& t) {
  const double estimated = std::max<double>(1, static_cast<double>(t.said.size()));
  fmt::print(
      "{:<48} {:<16} {:>4} {:>6} {:>8.4f} {:>8.4f} {:>8.4f} {:>8.4f} {:>6.1f} % {:>6.1f} % {:>6.1f} {:>6.1f} % "
      "{:>6.1f}\n",
      what, answer, t.answers, t.open, covering_value(t.said, 0.5), covering_value(t.made, 0.5),
      covering_value(t.said, 0.95), covering_value(t.made, 0.95), 100 * static_cast<double>(t.kept) / estimated,
      100 * static_cast<double>(t.thrice) / estimated, t.worst, 100 * static_cast<double>(t.kept_P) / estimated,
      t.worst_P);
}

std::vector<std::pair<std::string, SolveOptions>> all_options() {
  std::vector<std::pair<std::string, SolveOptions>> all(5);
  all[0].first = "default";
  all[1] = {"patch-24", {}}, all[1].second.rung = "patch-24";
  for (int k = 0; k < 3; ++k) {
    const double accuracy = std::array{0.05, 0.02, 0.01}[k];
    all[2 + k].first = fmt::format("--accuracy {:g}", accuracy);
    all[2 + k].second.accuracy = accuracy;
  }
  return all;
}

int run(std::size_t scenes, std::uint64_t seed, const std::string& one, bool each) {
  Executor executor{Device("").for_one_contact()};
  fmt::print("{:<48} {:<16} {:>4} {:>6} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>6} {:>8} {:>6}\n", "scenes", "answer",
             "all", "open", "said 50%", "made 50%", "said 95%", "made 95%", "kept", "thrice", "worst", "kept P",
             "worst");
  std::map<std::string, Tally> all;
  const auto judge_class = [&](const char* class_name, const char* description, bool at_end,
                               const std::vector<fem::Scene>& of_class) {
    if (!one.empty() && one != class_name) return;
    std::map<std::string, Tally> own;
    std::vector<double> judges;
    std::size_t unjudged = 0;
    for (fem::Scene scene : of_class) {
      scene.model = fem::SurfaceModel::patch;
      const Judged truth = at_end ? judge_over_end(executor, scene) : judge_inside(scene);
      if (!truth.solved) {
        ++unjudged;
        continue;
      }
      judges.push_back(truth.own_error.S);
      for (const auto& [name, options] : all_options()) {
        const SolveOutcome outcome = solve(scene, options);
        add(own[name], outcome, truth), add(all[name], outcome, truth);
        if (!each) continue;
        const auto error = mesh_error(outcome);
        fmt::print(
            stderr,
            "{}; nu {:g}, mu {:.3g}: {}, {}: said {:.4f} made {:.4f} (judge {:.4f}), P {:.4f} {:.4f} ({:.4f}){}{}\n",
            scene.title, scene.sensor.poisson, scene.friction, name, model_name(outcome),
            error ? error->expected.S : -1, difference(outcome.solution, truth.answer).S, truth.own_error.S,
            error ? error->expected.P : -1, difference(outcome.solution, truth.answer).P, truth.own_error.P,
            outcome.plan ? " " + outcome.plan->rung.name : "",
            every_step_converged(outcome.solution) ? "" : " NOT SOLVED");
      }
    }
    for (const auto& [name, tally] : own) print(description, name, tally);
    fmt::print("  judge's own change: {:.4f} (median), {:.4f} (95 %); {} scenes not judged\n",
               covering_value(judges, 0.5), covering_value(judges, 0.95), unjudged);
    std::fflush(stdout);
  };
  judge_class("mix", "the mix, another seed", false, mixed_scenes(seed, scenes));
  for (const UnlikeClass& c : all_unlike)
    judge_class(c.name, c.description, c.respect == Unlike::over_end || c.respect == Unlike::ends,
                unlike_scenes(c.respect, seed, scenes));
  bool good = true;
  for (const auto& [name, tally] : all) {
    print("all", name, tally);
    const std::size_t estimated = tally.said.size();
    good = good && tally.kept * 100 >= 97 * estimated && tally.thrice == estimated;
  }
  return good ? 0 : 1;
}

}  // namespace
}  // namespace tactel::host

int main(int count, char** arguments) {
  const std::size_t scenes = count > 1 ? std::strtoull(arguments[1], nullptr, 10) : 100;
  const std::uint64_t seed = count > 2 ? std::strtoull(arguments[2], nullptr, 10) : 4077;
  return tactel::host::run(scenes, seed, count > 3 ? arguments[3] : "", std::getenv("TACTEL_EACH") != nullptr);
}
