// SPDX-License-Identifier: Apache-2.0
#include "host/studies/tradeoff/tradeoff.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <variant>

#include "fem/accuracy.h"
#include "fem/gap_reference.h"
#include "host/contact/contact_stream.h"
#include "host/contact/gap_sweep.h"
#include "host/contact/patch_contact.h"
#include "host/contact/solve_on_rung.h"
#include "host/studies/tradeoff/scene_mix.h"

namespace tactel::host {
namespace {

using Answers = std::vector<fem::ContactSolution>;

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

/// What else is set beside the named rungs.
std::vector<Rung> other_models() {
  using enum Precision;
  const auto model = [](int columns, int rows, int steps, Precision precision, double tolerance) {
    return Rung{
        .name = "", .columns = columns, .rows = rows, .steps = steps, .precision = precision, .tolerance = tolerance};
  };
  std::vector<Rung> models = {
      model(21, 6, 1, fp32, 1e-2),   model(41, 6, 1, fp32, 1e-3),   model(41, 6, 1, fp32, 1e-2),
      model(41, 11, 1, fp64, 1e-9),  model(41, 11, 4, fp32, 1e-3),  model(81, 11, 1, fp32, 1e-2),
      model(81, 11, 1, fp32, 1e-3),  model(81, 17, 4, fp32, 1e-4),  model(123, 33, 1, fp32, 1e-4),
      model(123, 33, 4, fp32, 1e-4), model(161, 17, 2, fp32, 1e-3), model(161, 25, 10, fp32, 1e-5),
      model(161, 25, 4, fp64, 1e-7), model(321, 25, 4, fp32, 1e-4),
  };
  for (const fem::Element element : {fem::Element::q4, fem::Element::q4i, fem::Element::q8})
    models.push_back(with(rung_named("paper"), [&](Rung& r) { r.element = element; }));
  return models;
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

std::size_t scenes_for_meshes(std::size_t scenes) { return std::min(scenes, std::max<std::size_t>(8, scenes / 3)); }

/// Runs models on the mix and says how far it is.
class Study {
 public:
  /// `done` of `total` models have been run before.
  Study(Executor& executor, const TradeoffOptions& options, std::vector<fem::Scene> scenes, std::size_t& done,
        std::size_t total)
      : executor_(executor), options_(options), scenes_(std::move(scenes)), done_(done), total_(total) {}

  const std::vector<fem::Scene>& scenes() const { return scenes_; }

  Answers answers(const Rung& rung, bool nodes = false) {
    step(rung);
    return solve_on_rung(executor_, scenes_, rung, nodes);
  }

  std::vector<AnswerError> errors(const Rung& rung, const Answers& answers, const Rung& judge,
                                  const Answers& truth) const {
    std::vector<AnswerError> result;
    for (std::size_t i = 0; i < scenes_.size(); ++i)
      result.push_back(answer_error(scenes_[i], answers[i], rung, truth[i], judge));
    return result;
  }

  MeasuredModel measured(const Rung& rung, const Answers& answers, const Rung& judge, const Answers& truth) const {
    MeasuredModel model{.rung = rung, .error = quantiles(errors(rung, answers, judge, truth))};
    double increments = 0;
    for (const auto& answer : answers)
      for (const auto& step : answer.steps) {
        increments += 1;
        model.unsolved += !step.converged;
        model.sweeps += step.iterations;
      }
    model.unsolved /= increments;
    model.sweeps /= increments;
    return model;
  }

  void step(const Rung& rung) {
    if (options_.progress && !options_.progress(description(rung), done_++, total_))
      throw Stopped("stopped; no report is written");
  }

 private:
  Executor& executor_;
  const TradeoffOptions& options_;
  std::vector<fem::Scene> scenes_;
  std::size_t& done_;
  std::size_t total_;
};

/// No other model is faster and better.
void mark_front(std::vector<MeasuredModel>& models) {
  for (MeasuredModel& m : models)
    m.front = std::ranges::none_of(models, [&](const MeasuredModel& other) {
      return other.steps_per_second > m.steps_per_second && other.error.most95.S <= m.error.most95.S;
    });
}

/// Rung `low` of the ladder beside the next: what the planner reads.
MeasuredRung planner_row(const Study& study, std::size_t low, const std::vector<Answers>& answers) {
  const auto& rungs = ladder();
  const Answers& truth = answers.back();
  const auto error = study.errors(rungs[low], answers[low], rungs.back(), truth);
  const auto next_error = study.errors(rungs[low + 1], answers[low + 1], rungs.back(), truth);
  const auto difference = study.errors(rungs[low], answers[low], rungs[low + 1], answers[low + 1]);
  constexpr double share = 0.98;
  const auto of_S = [](const std::vector<AnswerError>& errors) {
    std::vector<double> values;
    for (const AnswerError& e : errors) values.push_back(e.S);
    return values;
  };
  const std::vector<double> own = of_S(error), differences = of_S(difference);
  return {rungs[low].name.c_str(), error_line(differences, own, share),
          error_line(differences, of_S(next_error), share), covering_value(own, share)};
}

/// The finest mesh beside the reference, where the mesh resolves the contact: smooth indenters on wide contacts.
void compare_finest_mesh(const Study& study, const Answers& mesh, const Answers& truth, Tradeoff& result) {
  std::vector<AnswerError> errors;
  for (std::size_t i = 0; i < study.scenes().size(); ++i) {
    const fem::Scene& scene = study.scenes()[i];
    const bool smooth = std::holds_alternative<fem::Parabola>(scene.indenter.shape) ||
                        std::holds_alternative<fem::Cylinder>(scene.indenter.shape) ||
                        std::holds_alternative<fem::RoundedFlat>(scene.indenter.shape);
    if (!smooth || truth[i].surface_width.sum() < smooth_width) continue;
    errors.push_back(answer_error(scene, mesh[i], rung_named("mesh-641"), truth[i], ladder().back()));
  }
  result.smooth_scenes = errors.size();
  result.mesh_agreement = quantiles(errors);
}

/// The solver on the whole mesh, which has neither condensation nor Gauss-Seidel, beside the condensed one.
void compare_full_mesh(Executor& executor, const Study& study, Tradeoff& result) {
  const Rung rung = with(rung_named("mesh-641"), [](Rung& r) {
    r.columns = 81;
    r.rows = 17;
    r.steps = 2;
    r.tolerance = 1e-11;
  });
  const std::size_t count = std::min<std::size_t>(study.scenes().size(), 8);
  const std::span some(study.scenes().data(), count);
  const Answers condensed = solve_on_rung(executor, some, rung, false);
  const auto start = std::chrono::steady_clock::now();
  double asked = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto full = fem::solve_gap_reference(on_rung(some[i], rung));
    asked += static_cast<double>(asked_steps(on_rung(some[i], rung).load, full.steps.size()).size());
    result.full_mesh_difference =
        std::max(result.full_mesh_difference, answer_error(some[i], condensed[i], rung, full, rung).S);
  }
  result.full_mesh_per_second = asked / std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// What halving the elements of the reference does to S, and the reference's own error by extrapolation, with first
/// order at most.
void judge_the_reference(Tradeoff& result) {
  const auto source = std::ranges::find(result.sources, std::string("elements of the reference"), &ErrorSource::what);
  const AnswerError &coarse = source->models.front().error.median, &fine = source->models.back().error.median;
  // With error c h^p, and the judge at h: |e(4h) - e(h)| / |e(2h) - e(h)| = (4^p - 1) / (2^p - 1) = 2^p + 1.
  result.observed_order = std::log2(std::max(coarse.S / fine.S - 1, 1e-3));
  const double order = std::clamp(result.observed_order, 0.5, 1.0);
  result.reference_error = source->models.back().error.most95.S / (std::exp2(order) - 1);
}

/// Seconds in kernels, as sets run them: without forces of elements.
double seconds_of(Executor& executor, const std::vector<fem::Scene>& scenes, const Rung& rung, int runs) {
  const ContactStream stream(executor, model_of(rung));
  ContactStream::Part part;
  for (const fem::Scene& scene : scenes) stream.add(part, scene, fem::load_path(scene.load));
  part.lay_out();
  double best = 1e300;
  for (int run = 0; run < runs; ++run) {
    part.run();
    best = std::min(best, part.seconds());
  }
  return best;
}

double reference_steps_per_second(Executor& executor, const Rung& rung) {
  const std::vector<fem::Scene> scenes = mixed_scenes(7, 16);
  const auto start = std::chrono::steady_clock::now();
  double asked = 0;
  const Answers answers = solve_on_rung(executor, scenes, rung);
  for (std::size_t i = 0; i < scenes.size(); ++i)
    asked += static_cast<double>(asked_steps(scenes[i].load, answers[i].steps.size()).size());
  return asked / std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

double steps_per_second(Executor& executor, const Rung& rung) {
  if (rung.exact) return reference_steps_per_second(executor, rung);
  const std::size_t count = rung.patch() ? 16384 : rung.columns > 400 ? 48 : rung.columns > 150 ? 192 : 1536;
  const int runs = !rung.patch() && rung.columns > 400 ? 1 : 3;
  std::vector<fem::Scene> scenes = mixed_scenes(7, count);
  double asked = 0;
  for (fem::Scene& scene : scenes) {
    scene.sensor.poisson = fem::Sensor{}.poisson;
    scene = on_rung(scene, rung);
    const std::size_t increments = fem::load_path(scene.load).steps.size();
    asked += static_cast<double>(asked_steps(scene.load, increments).size());
  }
  return asked / seconds_of(executor, scenes, rung, runs);
}

Tradeoff measure_tradeoff(Executor& executor, const TradeoffOptions& options) {
  const auto& named = all_rungs();
  const auto others = other_models();
  const auto all_sources = sources();
  std::size_t total = named.size() + others.size();
  for (const Source& source : all_sources) total += source.models.size() + 1;
  std::size_t done = 0;
  Study study(executor, options, mixed_scenes(options.seed, options.scenes), done, total);
  Study on_meshes(executor, options, mixed_scenes(options.seed, scenes_for_meshes(options.scenes)), done, total);
  const auto of = [&](const Rung& rung) -> Study& { return rung.patch() ? study : on_meshes; };
  Tradeoff result{.mix = mix_description(options.seed, options.scenes),
                  .device = executor.device().info().name,
                  .scenes = options.scenes,
                  .seed = options.seed};

  const Rung& reference = ladder().back();
  std::map<std::string, Answers> known;  // of the named rungs
  known[reference.name] = study.answers(reference, true);
  const Answers& truth = known[reference.name];
  for (const Rung& rung : named) {
    if (!known.contains(rung.name)) known[rung.name] = of(rung).answers(rung, true);
    result.models.push_back(of(rung).measured(rung, known[rung.name], reference, truth));
    result.models.back().steps_per_second = steps_per_second(executor, rung);
  }
  std::vector<Answers> climbed;
  for (const Rung& rung : ladder()) climbed.push_back(known[rung.name]);
  for (std::size_t k = 0; k + 1 < climbed.size(); ++k) result.planner.push_back(planner_row(study, k, climbed));
  for (const Rung& rung : others) {
    result.models.push_back(of(rung).measured(rung, of(rung).answers(rung), reference, truth));
    result.models.back().steps_per_second = steps_per_second(executor, rung);
  }
  mark_front(result.models);
  for (const Source& source : all_sources) {
    const Answers judge = source.judge.name.empty() ? of(source.judge).answers(source.judge) : known[source.judge.name];
    ErrorSource found{source.what, source.judge, {}};
    for (const Rung& rung : source.models)
      found.models.push_back(of(rung).measured(rung, of(rung).answers(rung), source.judge, judge));
    result.sources.push_back(std::move(found));
  }
  judge_the_reference(result);
  result.planner.push_back({reference.name.c_str(), {}, {}, result.reference_error});
  compare_finest_mesh(on_meshes, known["mesh-641"], truth, result);
  compare_full_mesh(executor, study, result);
  return result;
}

namespace {

/// The planner on scenes of one class.
std::vector<Promise> promises_on(Study& study, const std::string& what, const std::vector<double>& accuracies) {
  const auto& rungs = ladder();
  std::vector<Answers> answers;
  for (const Rung& rung : rungs) answers.push_back(study.answers(rung, true));
  std::vector<Promise> promises;
  for (double accuracy : accuracies) {
    Promise promise{.what = what,
                    .accuracy = accuracy,
                    .scenes = study.scenes().size(),
                    .by_rung = std::vector<std::size_t>(rungs.size())};
    for (std::size_t i = 0; i < promise.scenes; ++i) {
      const std::span scene(&study.scenes()[i], 1);
      const Plan chosen =
          plan(scene, accuracy, [&](const Rung& rung) { return Answers{answers[&rung - rungs.data()][i]}; });
      const std::size_t place = std::ranges::find(rungs, chosen.rung.name, &Rung::name) - rungs.begin();
      ++promise.by_rung[place];
      promise.kept +=
          answer_error(scene[0], answers[place][i], rungs[place], answers.back()[i], rungs.back()).S <= accuracy;
    }
    promises.push_back(std::move(promise));
  }
  return promises;
}

void add(Promise& sum, const Promise& promise) {
  sum.scenes += promise.scenes;
  sum.kept += promise.kept;
  sum.by_rung.resize(promise.by_rung.size());
  for (std::size_t k = 0; k < promise.by_rung.size(); ++k) sum.by_rung[k] += promise.by_rung[k];
}

}  // namespace

std::vector<Promise> verify_planner(Executor& executor, const TradeoffOptions& options,
                                    const std::vector<double>& accuracies) {
  constexpr std::size_t classes = std::size(all_unlike);
  const std::size_t total = (1 + classes) * ladder().size();
  std::vector<Promise> promises, others(accuracies.size(), {.what = "all unlike the mix"});
  std::size_t done = 0;
  Study mix(executor, options, mixed_scenes(options.seed, options.scenes), done, total);
  promises = promises_on(mix, "the mix", accuracies);
  for (std::size_t c = 0; c < classes; ++c) {
    Study study(executor, options, unlike_scenes(all_unlike[c], options.seed, (options.scenes + c) / classes), done,
                total);
    for (Promise& promise : promises_on(study, description(all_unlike[c]), accuracies)) {
      const std::size_t k = std::ranges::find(accuracies, promise.accuracy) - accuracies.begin();
      others[k].accuracy = promise.accuracy;
      add(others[k], promise);
      promises.push_back(std::move(promise));
    }
  }
  promises.insert(promises.end(), others.begin(), others.end());
  return promises;
}

}  // namespace tactel::host
