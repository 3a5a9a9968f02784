#include "host/studies/tradeoff/tradeoff.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "fem/gap_reference.h"
#include "host/contact/gap_sweep.h"
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
    return Rung{"", columns, rows, 1, steps, precision, tolerance, fem::Element::bbar};
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
  for (const auto& [columns, spread] : {std::pair{41, 2}, {41, 4}, {81, 2}}) {
    models.push_back(model(columns, 11, 1, fp32, 1e-3));
    models.back().spread = spread;
  }
  return models;
}

std::vector<Source> sources() {
  const Rung& reference = ladder().back();
  const Rung middle = with(reference, [](Rung& r) { r.columns = 161; });
  std::vector<Source> all = {
      {"contact mesh (gap elements)", reference, {}},
      {"block mesh (nodes through the thickness)", with(middle, [](Rung& r) { r.rows = 49; }), {}},
      {"load steps to an indentation", with(middle, [](Rung& r) { r.steps = 40; }), {}},
      {"tolerance of the iteration", with(middle, [](Rung& r) { r.tolerance = 1e-10; }), {}},
      {"rounding (fp32, by tolerance)", with(middle, [](Rung& r) { r.tolerance = 1e-10; }), {}}};
  for (int columns : {41, 81, 161, 321})
    all[0].models.push_back(with(all[0].judge, [&](Rung& r) { r.columns = columns; }));
  for (int rows : {4, 6, 11, 17, 25}) all[1].models.push_back(with(all[1].judge, [&](Rung& r) { r.rows = rows; }));
  for (int steps : {1, 2, 4, 10, 20}) all[2].models.push_back(with(all[2].judge, [&](Rung& r) { r.steps = steps; }));
  for (double tolerance : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
    all[3].models.push_back(with(all[3].judge, [&](Rung& r) { r.tolerance = tolerance; }));
    if (tolerance < 1e-4)
      all[4].models.push_back(with(all[3].models.back(), [](Rung& r) { r.precision = Precision::fp32; }));
  }
  return all;
}

/// Runs models on the mix and says how far it is.
class Study {
 public:
  Study(Executor& executor, const TradeoffOptions& options, std::size_t total)
      : executor_(executor), options_(options), scenes_(mixed_scenes(options.seed, options.scenes)), total_(total) {}

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
  std::size_t done_ = 0, total_;
};

/// No other model is faster and better.
void mark_front(std::vector<MeasuredModel>& models) {
  for (MeasuredModel& m : models)
    m.front = std::ranges::none_of(models, [&](const MeasuredModel& other) {
      return other.steps_per_second > m.steps_per_second && other.error.most95.S <= m.error.most95.S;
    });
}

/// Measures a named rung beside the next, for the planner.
MeasuredRung planner_row(const Study& study, const MeasuredModel& model, const Answers& answers, const Answers& next,
                         const Rung& next_rung, const Answers& truth) {
  const auto error = study.errors(model.rung, answers, ladder().back(), truth);
  const auto difference = study.errors(model.rung, answers, next_rung, next);
  std::vector<double> ratio;
  std::array<std::vector<double>, std::tuple_size_v<ByTouching>> by_class;
  for (std::size_t i = 0; i < error.size(); ++i) {
    if (difference[i].S > 0) ratio.push_back(error[i].S / difference[i].S);
    by_class[touching_class(touching_nodes(answers[i]))].push_back(error[i].S);
  }
  MeasuredRung row{rung_named(model.rung.name).name.c_str(),
                   model.steps_per_second,
                   model.error.median.S,
                   model.error.most95.S,
                   covering_value(ratio, 0.9),
                   {}};
  for (std::size_t c = 0; c < by_class.size(); ++c)  // a class that the mix has hardly any of: the rung's median
    row.least[c] = by_class[c].size() < 5 ? model.error.median.S : covering_value(by_class[c], 0.5);
  return row;
}

/// The solver on the whole mesh, which has neither condensation nor Gauss-Seidel, beside the condensed one.
void compare_full_mesh(Executor& executor, const Study& study, Tradeoff& result) {
  const Rung rung = with(ladder().back(), [](Rung& r) {
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

/// What halving the columns does to the error in S: the order between the two finest meshes but the judge's own, and
/// the judge's error by extrapolation with it (but with first order at most).
void judge_the_reference(Tradeoff& result) {
  const auto& models = result.sources.front().models;
  const AnswerError &coarse = models[models.size() - 2].error.median, &fine = models.back().error.median;
  // With error c h^p, and the judge at h: |e(4h) - e(h)| / |e(2h) - e(h)| = (4^p - 1) / (2^p - 1) = 2^p + 1.
  result.observed_order = std::log2(std::max(coarse.S / fine.S - 1, 1e-3));
  const double order = std::clamp(result.observed_order, 0.5, 1.0);
  result.reference_error = models.back().error.most95.S / (std::exp2(order) - 1);
}

template <class Real>
double timed(Executor& executor, const std::vector<fem::Scene>& scenes, const GapSweepOptions& options, int runs) {
  auto batch = GapSweep<Real>(executor, scenes.front().sensor, options).prepare(scenes);
  double best = 1e300;
  for (int run = 0; run < runs; ++run) {
    batch.run();
    best = std::min(best, batch.seconds());
  }
  return best;
}

}  // namespace

double steps_per_second(Executor& executor, const Rung& rung) {
  const std::size_t count = rung.columns > 400 ? 48 : rung.columns > 150 ? 192 : 1536;
  const int runs = rung.columns > 400 ? 1 : 3;
  std::vector<fem::Scene> scenes = mixed_scenes(7, count);
  double asked = 0;
  for (fem::Scene& scene : scenes) {
    scene.sensor.poisson = fem::Sensor{}.poisson;
    scene = on_rung(scene, rung);
    const std::size_t increments = fem::load_path(scene.load).steps.size();
    asked += static_cast<double>(asked_steps(scene.load, increments).size());
  }
  GapSweepOptions options;
  options.tolerance = rung.tolerance;
  options.spread = rung.spread;
  options.nodes = false;
  return asked / (rung.precision == Precision::fp32 ? timed<float>(executor, scenes, options, runs)
                                                    : timed<double>(executor, scenes, options, runs));
}

Tradeoff measure_tradeoff(Executor& executor, const TradeoffOptions& options) {
  const auto& named = ladder();
  const auto others = other_models();
  const auto all_sources = sources();
  std::size_t total = named.size() + others.size();
  for (const Source& source : all_sources) total += source.models.size() + 1;
  Study study(executor, options, total);
  Tradeoff result{.mix = mix_description(options.seed, options.scenes),
                  .device = executor.device().info().name,
                  .scenes = options.scenes,
                  .seed = options.seed};

  const Rung& reference = named.back();
  const Answers truth = study.answers(reference, true);
  std::vector<Answers> rung_answers;
  for (const Rung& rung : named) {
    rung_answers.push_back(rung.name == reference.name ? truth : study.answers(rung, true));
    result.models.push_back(study.measured(rung, rung_answers.back(), reference, truth));
    result.models.back().steps_per_second = steps_per_second(executor, rung);
  }
  for (std::size_t k = 0; k + 1 < named.size(); ++k)
    result.planner.push_back(planner_row(study, result.models[k], rung_answers[k], rung_answers[finer_rung(k)],
                                         named[finer_rung(k)], truth));
  for (const Rung& rung : others) {
    result.models.push_back(study.measured(rung, study.answers(rung), reference, truth));
    result.models.back().steps_per_second = steps_per_second(executor, rung);
  }
  mark_front(result.models);
  for (const Source& source : all_sources) {
    const Answers judge = source.judge.columns == reference.columns ? truth : study.answers(source.judge);
    ErrorSource found{source.what, source.judge, {}};
    for (const Rung& rung : source.models)
      found.models.push_back(study.measured(rung, study.answers(rung), source.judge, judge));
    result.sources.push_back(std::move(found));
  }
  judge_the_reference(result);
  compare_full_mesh(executor, study, result);
  return result;
}

std::vector<Promise> verify_planner(Executor& executor, const TradeoffOptions& options,
                                    const std::vector<double>& accuracies) {
  const auto& rungs = ladder();
  Study study(executor, options, rungs.size());
  std::vector<Answers> answers;
  for (const Rung& rung : rungs) answers.push_back(study.answers(rung, true));
  std::vector<Promise> promises;
  for (double accuracy : accuracies) {
    Promise promise{.accuracy = accuracy, .scenes = options.scenes, .by_rung = std::vector<std::size_t>(rungs.size())};
    for (std::size_t i = 0; i < options.scenes; ++i) {
      const std::span scene(&study.scenes()[i], 1);
      const Plan chosen =
          plan(scene, accuracy, [&](const Rung& rung) { return Answers{answers[&rung - rungs.data()][i]}; });
      const std::size_t place = std::ranges::find(rungs, chosen.rung.name, &Rung::name) - rungs.begin();
      ++promise.by_rung[place];
      if (place + 1 == rungs.size())
        ++promise.reference;
      else
        promise.kept +=
            answer_error(scene[0], answers[place][i], rungs[place], answers.back()[i], rungs.back()).S <= accuracy;
    }
    promises.push_back(promise);
  }
  return promises;
}

}  // namespace tactel::host
