// SPDX-License-Identifier: Apache-2.0

// Errors of the rungs of pads beside the reference, on scenes of bench/unlike_pads.h:
//
//     build/bench/tactel_pad_study [SCENES, 168] [SEED, 2026] [ANSWERS] [FILE]
//
// prints those that they make, by class of scenes; FILE becomes host/answers/measured_pads.cpp.
//
//     build/bench/tactel_pad_study judge [SCENES, 120] [SEED, 2027] [ANSWERS]
//     build/bench/tactel_pad_study sides [SCENES, 120] [SEED, 2027] [ANSWERS]
//     build/bench/tactel_pad_study markers [SCENES, 120] [SEED, 2027] [ANSWERS]
//     build/bench/tactel_pad_study layers [SCENES, 120] [SEED, 2027] [ANSWERS]
//
// prints those that `solve` states beside those that it makes, on scenes that are wider than those of the table, on
// pads with free sides, with markers or of layers, and how often --accuracy is kept. It fails where less than 95 % of
// stated errors hold, or 90 % of those of one quantity on one rung, one of S or P is exceeded threefold, or less than
// 97 % of accuracies are kept. By what the reference may itself be off (printed) counts for the answer. A scene whose
// reference does not settle has no answer to judge by: it is named and left out, and more than one in fifty fail.
//
// ANSWERS, a folder, keeps the reference's answers, some seconds each. They have 48 cells a side, 40 with
// markers and of layers, 32 with free sides, and so many increments that a path has 24.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <span>
#include <vector>

#include "bench/unlike_pads.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_markers.h"
#include "fem/pad/pad_reference.h"
#include "host/answers/line_error.h"
#include "host/answers/solve.h"

namespace tactel::host {
namespace {

using Errors = AnswerError;
constexpr std::array<const char*, 7> names = {"S", "P", "Q", "M", "sigma", "tau", "markers"};

/// Numbers of an answer that errors are made of, in order.
template <class F>
void each_number(fem::PadReferenceSolution& answer, F f) {
  f(answer.solution.cells.hx), f(answer.solution.cells.hy);
  for (const auto member : fem::pad_error_members)
    if (member != &Errors::markers || answer.solution.steps.front().markers.rows() > 0) f(answer.error.*member);
  for (fem::PadStep& step : answer.solution.steps) {
    if (!step.slip_index) step.slip_index = 0;
    double converged = step.converged;
    f(converged), step.converged = converged != 0;
    f(step.P), f(step.Q[0]), f(step.Q[1]), f(step.M), f(*step.slip_index);
    for (double& stress : step.stress.reshaped()) f(stress);
    for (double& u : step.markers.reshaped()) f(u);
  }
}

/// The reference's answer to a scene: from a file of an earlier run, or solved and written there.
fem::PadReferenceSolution reference(const fem::PadScene& scene, const std::string& path) {
  const int drags = std::max<int>(1, static_cast<int>(scene.load.drags.size()));
  fem::PadOptions options = fem::pad_reference_options(fem::has_free_sides(scene.sensor)               ? 32
                                                       : scene.markers || !scene.sensor.layers.empty() ? 40
                                                                                                       : 48);
  options.drag_increments = std::clamp(24 / drags, 4, 12);
  fem::PadReferenceSolution answer;
  if (std::ifstream in(path); !path.empty() && in) {
    answer.solution.cells.n = options.cells;
    answer.solution.steps.resize(fem::pad_targets(scene.load).size());
    for (fem::PadStep& step : answer.solution.steps)
      step.stress.resize(scene.sensor.tactels[0] * scene.sensor.tactels[1], 3),
          step.markers.resize(static_cast<Eigen::Index>(fem::marker_count(scene.markers)), 3);
    each_number(answer, [&](double& number) { in >> number; });
    if (in) return answer;
  }
  answer = fem::PadReference(fem::pad_layer(scene), options).solve(scene);
  if (path.empty()) return answer;
  std::ofstream out(path);
  each_number(answer, [&](double& number) { out << fmt::format("{}\n", number); });
  return answer;
}

/// As the table was measured; wider; with free sides; with markers; of layers.
enum class Scenes { measured, wide, free_sides, markers, layers };

UnlikePad unlike(Scenes scenes, unsigned seed, int k) {
  switch (scenes) {
    case Scenes::free_sides:
      return unlike_free_pad(seed, k);
    case Scenes::markers:
      return unlike_marked_pad(seed, k);
    case Scenes::layers:
      return unlike_layered_pad(seed, k);
    default:
      return unlike_pad(seed, k, scenes == Scenes::wide);
  }
}

/// Calls f with each scene and the reference's answer.
template <class F>
void each_scene(int count, unsigned seed, Scenes scenes, const std::string& answers, const F& f) {
  if (!answers.empty()) std::filesystem::create_directories(answers);
  for (int k = 0; k < count; ++k) {
    const UnlikePad pad = unlike(scenes, seed, k);
    const std::string kept = fmt::format("{}/{}_{}_{:03}.txt", answers, seed, static_cast<int>(scenes), k);
    f(pad, reference(pad.scene, answers.empty() ? "" : kept));
  }
}

std::vector<double> column(const std::vector<Errors>& errors, double Errors::*member) {
  std::vector<double> values;
  values.reserve(errors.size());
  for (const Errors& e : errors) values.push_back(e.*member);
  return values;
}

void print(const std::string& what, const std::vector<Errors>& errors) {
  fmt::print("  {:<14}{:3}", what, errors.size());
  for (std::size_t k = 0; k < names.size(); ++k) {
    const std::vector<double> values = column(errors, fem::pad_error_members[k]);
    fmt::print(" | {} {:.4f} {:.4f} {:.4f}", names[k], covering_value(values, 0.5), covering_value(values, 0.95),
               covering_value(values, 1));
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

fem::PadSolution twin(const PadRung& rung, const fem::PadScene& scene, double tolerance) {
  const fem::PadOptions options{.cells = rung.cells, .tolerance = tolerance, .pressing_increments = rung.increments};
  fem::PadSolution answer = fem::PadSolver(fem::pad_layer(scene), options).solve(scene);
  fem::see_markers(scene, answer);
  return answer;
}

int write_table(int count, unsigned seed, const std::map<std::string, ByClass>& errors, const char* file) {
  std::ofstream out(file);
  out << fmt::format(
      "// SPDX-License-Identifier: Apache-2.0\n\n// Written by `tactel_pad_study {} {} ANSWERS FILE`; do not edit.\n"
      "// Errors beside the reference of contacts of bench/unlike_pads.h. By class: what 95 % stay below, of S, P, Q, "
      "M,\n"
      "// sigma and tau; the largest of S.\n#include \"host/answers/pad_error.h\"\n\nnamespace tactel::host {{\n\n"
      "std::span<const MeasuredPadRung> measured_pads() {{\n  static constexpr MeasuredPadRung rungs[] = {{\n",
      count, seed);
  for (const PadRung& rung : all_rungs<PadRung>()) {
    if (rung.exact) continue;
    out << fmt::format("      {{\"{}\",\n       {{{{", rung.name);
    for (int k = 0; k < pad_classes; ++k) {
      const std::vector<Errors>& of = errors.at(rung.name)[k];
      out << (k == 0 ? "{{" : ",\n         {{");
      for (const auto member : std::span(fem::pad_error_members).first<6>())  // its scenes have no markers
        out << fmt::format("{}{:.4f}", member == &Errors::S ? "" : ", ", covering_value(column(of, member), 0.95));
      out << fmt::format("}}, {:.4f}}}", covering_value(column(of, &Errors::S), 1));
    }
    out << "}}},\n";
  }
  out << "  };\n  return rungs;\n}\n\n}  // namespace tactel::host\n";
  return out.flush() ? 0 : 1;
}

int table(int count, unsigned seed, const std::string& answers, const char* file) {
  ByClass own;
  std::map<std::string, ByClass> made;
  each_scene(count, seed, Scenes::measured, answers, [&](const UnlikePad& pad, const fem::PadReferenceSolution& truth) {
    const auto add = [of = static_cast<int>(pad_class(pad.scene))](ByClass& to, const Errors& error) {
      to[of].push_back(error), to[pad_classes].push_back(error);
    };
    add(own, truth.error);
    for (const PadRung& rung : all_rungs<PadRung>())
      if (!rung.exact) add(made[rung.name], fem::pad_difference(twin(rung, pad.scene, 1e-3), truth.solution));
  });
  fmt::print("{} scenes of seed {}\n", count, seed);
  print("the reference, its own estimate", own);
  for (const PadRung& rung : all_rungs<PadRung>())
    if (!rung.exact) print(rung.name, made[rung.name]);
  return file == nullptr ? 0 : write_table(count, seed, made, file);
}

/// Stated and made errors of answers.
struct Tally {
  std::array<std::vector<double>, names.size()> said, made;
  void add(const fem::PadSolution& answer, const ExpectedError& error, const fem::PadReferenceSolution& truth) {
    const Errors off = fem::pad_difference(answer, truth.solution);
    for (std::size_t k = 0; k < names.size(); ++k) {
      const auto member = fem::pad_error_members[k];
      said[k].push_back(error.expected.*member);
      made[k].push_back(std::max(0.0, off.*member - truth.error.*member));
    }
  }
  double held(std::size_t k) const {
    double all = 0;
    for (std::size_t i = 0; i < said[k].size(); ++i) all += made[k][i] <= said[k][i];
    return all / static_cast<double>(said[k].size());
  }
  double worst(std::size_t k) const {
    double worst = 0;
    for (std::size_t i = 0; i < said[k].size(); ++i) worst = std::max(worst, made[k][i] / said[k][i]);
    return worst;
  }
};

/// Answers of the rungs below the reference to one scene, in fp64, and the errors that solve() states of them.
struct Answers {
  explicit Answers(const fem::PadScene& scene) : scene(scene), judge(scene) {
    for (const PadRung& rung : all_rungs<PadRung>())
      if (!rung.exact) of.emplace(rung.name, twin(rung, scene, 1e-6));
  }
  ExpectedError error(const PadRung& rung, int cells) {
    const fem::PadSolution& answer = of.at(rung.name);
    const auto error = judge.error(rung, answer, cells);
    return error ? *error : expected_pad_error(rung, scene, deepest(scene, answer));
  }
  /// The rung that solve() takes for an accuracy; none: the reference.
  const PadRung* planned(double accuracy) {
    for (const PadRung& rung : all_rungs<PadRung>())
      if (!rung.exact && std::ranges::any_of(PadJudge::cells(rung), [&](int cells) {
            return cells <= 32 && error(rung, cells).expected.S <= accuracy;  // 48 take seconds
          }))
        return &rung;
    return nullptr;
  }

  const fem::PadScene& scene;
  PadJudge judge;
  std::map<std::string, fem::PadSolution> of;
};

int judge(int count, unsigned seed, Scenes scenes, const std::string& answers) {
  std::map<std::string, Tally> rungs;
  struct Kept {
    int all = 0, kept = 0, reference = 0;
    std::map<std::string, int> of;  ///< rungs that are taken
  };
  std::map<double, Kept> accuracies{{0.05, {}}, {0.02, {}}, {0.01, {}}};
  std::vector<Errors> own;
  int scene = -1, unsettled = 0;
  each_scene(count, seed, scenes, answers, [&](const UnlikePad& pad, const fem::PadReferenceSolution& truth) {
    ++scene;
    if (!std::ranges::all_of(truth.solution.steps, &fem::PadStep::converged)) {
      ++unsettled;
      fmt::print("left out, the reference does not settle: scene {}, {}, {}\n", scene,
                 fem::shape_name(pad.scene.indenter.shape), name(pad.way));
      return;
    }
    own.push_back(truth.error);
    Answers answers_of(pad.scene);
    for (const PadRung& rung : all_rungs<PadRung>()) {
      if (rung.exact) continue;
      rungs[rung.name].add(answers_of.of.at(rung.name), answers_of.error(rung, PadJudge::usual_cells(rung)), truth);
      if (std::getenv("TACTEL_EACH") == nullptr) continue;
      fmt::print(stderr, "{} {} {}: {}", scene, fem::shape_name(pad.scene.indenter.shape), name(pad.way), rung.name);
      for (std::size_t k = 0; k < names.size(); ++k)
        fmt::print(stderr, " {} {:.4f} {:.4f}", names[k], rungs[rung.name].said[k].back(),
                   rungs[rung.name].made[k].back());
      fmt::print(stderr, "\n");
    }
    for (auto& [accuracy, tally] : accuracies) {
      if (const PadRung* rung = answers_of.planned(accuracy))
        ++tally.all, tally.kept += rungs[rung->name].made[0].back() <= accuracy, ++tally.of[rung->name];
      else
        ++tally.reference;  // it would judge itself
    }
  });
  fmt::print("{} scenes of seed {}, {} left out\n", count, seed, unsettled);
  print("reference's own", own);
  fmt::print("{:<8} {:<6} {:>8} {:>8} {:>8} {:>8} {:>8} {:>6}\n", "rung", "error", "said 50%", "made 50%", "said 95%",
             "made 95%", "held", "worst");
  bool good = 50 * unsettled <= count;
  double all_held = 0, quantities = 0;
  for (const PadRung& rung : all_rungs<PadRung>()) {
    if (rung.exact) continue;
    const Tally& t = rungs[rung.name];
    for (std::size_t k = 0; k < names.size(); ++k) {
      if (std::ranges::all_of(t.said[k], [](double said) { return said == 0; })) continue;  // without markers
      fmt::print("{:<8} {:<7} {:>8.4f} {:>8.4f} {:>8.4f} {:>8.4f} {:>6.1f} % {:>6.2f}\n", rung.name, names[k],
                 covering_value(t.said[k], 0.5), covering_value(t.made[k], 0.5), covering_value(t.said[k], 0.95),
                 covering_value(t.made[k], 0.95), 100 * t.held(k), t.worst(k));
      good = good && t.held(k) >= 0.9 && (k > 1 || t.worst(k) <= 3);
      all_held += t.held(k), ++quantities;
    }
  }
  fmt::print("{:.1f} % of all stated errors hold\n", 100 * all_held / quantities);
  good = good && all_held >= 0.95 * quantities;
  for (const auto& [accuracy, tally] : accuracies) {
    fmt::print("--accuracy {:g}: kept by {} of {}; the reference answers {} more; of", accuracy, tally.kept, tally.all,
               tally.reference);
    for (const auto& [rung, count] : tally.of) fmt::print(" {} {}", rung, count);
    fmt::print("\n");
    good = good && 100 * tally.kept >= 97 * tally.all;
  }
  return good ? 0 : 1;
}

}  // namespace
}  // namespace tactel::host

int main(int count, char** arguments) {
  using tactel::host::Scenes;
  const std::map<std::string, Scenes> kinds{
      {"judge", Scenes::wide}, {"sides", Scenes::free_sides}, {"markers", Scenes::markers}, {"layers", Scenes::layers}};
  const auto kind = kinds.find(count > 1 ? arguments[1] : "");
  const bool judging = kind != kinds.end();
  if (judging) --count, ++arguments;
  const int scenes = count > 1 ? std::atoi(arguments[1]) : judging ? 120 : 168;
  const auto seed = static_cast<unsigned>(count > 2 ? std::atoi(arguments[2]) : judging ? 2027 : 2026);
  const std::string answers = count > 3 ? arguments[3] : "";
  return judging ? tactel::host::judge(scenes, seed, kind->second, answers)
                 : tactel::host::table(scenes, seed, answers, count > 4 ? arguments[4] : nullptr);
}
