// SPDX-License-Identifier: Apache-2.0
#include "host/studies/tradeoff/tradeoff.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/answers/planner.h"
#include "host/contact/lines/contact_stream.h"
#include "host/contact/lines/solve_on_rung.h"
#include "host/studies/tradeoff/scene_mix.h"
#include "host/support/seconds.h"

namespace tactel::host {
namespace {

using Answers = std::vector<fem::ContactSolution>;

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
  for (const fem::Element element : {fem::Element::q4, fem::Element::q4i, fem::Element::q8}) {
    models.push_back(rung_named("paper"));
    models.back().name.clear(), models.back().element = element;
  }
  return models;
}

const char* const line_definitions =
    "Errors are the largest over the load steps that the scene requests: of S itself; of P and Q over the path's "
    "largest; of σ_y and τ_xy at any tactel over the largest at any of them along the path. The two tactels at the "
    "very ends are excluded: there the bonded base meets the free side and the exact stress is infinite. Median and "
    "95 % are over the scenes. Speed counts requested load steps; finer increments therefore reduce it.";

double asked_in_all(std::span<const fem::Scene> scenes) {
  double asked = 0;
  for (const fem::Scene& scene : scenes)
    asked += static_cast<double>(asked_steps(scene.load, fem::load_path(scene.load).steps.size()).size());
  return asked;
}

/// Requested load increments per second: scenes of the mix on one sensor in one batch, best of a few runs.
double steps_per_second(Executor& executor, const Rung& rung) {
  const std::size_t count = rung.patch() ? 16384 : rung.columns > 400 ? 48 : rung.columns > 150 ? 192 : 1536;
  const int runs = !rung.patch() && rung.columns > 400 ? 1 : 3;
  std::vector<fem::Scene> scenes = mixed_scenes(7, count);
  for (fem::Scene& scene : scenes) {
    scene.sensor.poisson = fem::Sensor{}.poisson;
    scene = on_rung(scene, rung);
  }
  return asked_in_all(scenes) / seconds_of(ContactStream(executor, model_of(rung)), scenes, runs);
}

}  // namespace

void mark_front(std::vector<MeasuredModel>& models) {
  for (MeasuredModel& m : models)
    m.front = std::ranges::none_of(models, [&](const MeasuredModel& other) {
      return other.steps_per_second > m.steps_per_second && other.error.most95.S <= m.error.most95.S;
    });
}

std::vector<AnswerError> answer_errors(std::span<const fem::Scene> scenes, const Answers& answers, const Rung& rung,
                                       const Answers& truth, const Rung& judge) {
  std::vector<AnswerError> errors;
  for (std::size_t i = 0; i < answers.size(); ++i)
    errors.push_back(answer_error(scenes[i], answers[i], rung, truth[i], judge));
  return errors;
}

Tradeoff measure_tradeoff(Executor& executor, const TradeoffOptions& options) {
  std::vector<Rung> models = all_rungs();
  for (const Rung& rung : other_models()) models.push_back(rung);
  const std::vector<fem::Scene> scenes = mixed_scenes(options.seed, options.scenes);
  const std::span few(scenes.data(), std::min(options.scenes, std::max<std::size_t>(8, options.scenes / 3)));
  Tradeoff result{.mix = mix_description(options.seed, options.scenes),
                  .device = executor.device().info().name,
                  .scenes = options.scenes,
                  .seed = options.seed,
                  .definitions = line_definitions,
                  .judge_error = measured_ladder().back().most};
  const Rung& reference = ladder().back();
  std::size_t done = 0;
  double seconds = 0;  // of the last call
  const auto solve = [&](std::span<const fem::Scene> some, const Rung& rung) {
    if (options.progress && !options.progress(done++, models.size())) throw Stopped("stopped; no report is written");
    const auto start = Clock::now();
    Answers answers = solve_on_rung(executor, some, rung, false);
    seconds = seconds_since(start);
    return answers;
  };
  const Answers truth = solve(scenes, reference);
  const double reference_seconds = seconds;
  for (const Rung& rung : models) {
    const bool judge = rung.name == reference.name;
    const std::span<const fem::Scene> some = rung.patch() ? std::span(scenes) : few;
    const Answers answers = judge ? truth : solve(some, rung);
    result.models.push_back(judged_model(rung, answers, answer_errors(some, answers, rung, truth, reference)));
    result.models.back().steps_per_second =
        rung.exact ? asked_in_all(some) / (judge ? reference_seconds : seconds) : steps_per_second(executor, rung);
  }
  mark_front(result.models);
  return result;
}

}  // namespace tactel::host
