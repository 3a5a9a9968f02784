// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <numeric>

#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_mix.h"
#include "fem/pad/pad_reference.h"
#include "host/contact/pads/pad_stream.h"
#include "host/studies/tradeoff/tradeoff.h"
#include "host/support/errors.h"
#include "host/support/seconds.h"
#include "host/support/side_by_side.h"

namespace tactel::host {
namespace {

const char* const pad_definitions =
    "Errors are the largest over the load steps: of S itself; of P over the largest of the path; of Q, and of M over "
    "half the "
    "contact's size, over the larger of both along the path; of σ_z and τ at any tactel over the largest of each along "
    "the path. Median and 95 % are over the scenes. Errors of the reference are its own estimates. Speed counts load "
    "steps over the time in kernels.";

std::vector<fem::PadScene> random_scenes(fem::PadMix mix, std::size_t count) {
  std::vector<fem::PadScene> scenes;
  while (scenes.size() < count) scenes.push_back(mix());
  return scenes;
}

AnswerError answer_error(const AnswerError& e) {
  return {.S = e.S, .P = e.P, .Q = std::max(e.Q, e.M), .sigma = e.sigma, .tau = e.tau};
}

double asked_on_pads(const std::vector<fem::PadScene>& scenes) {
  return std::transform_reduce(scenes.begin(), scenes.end(), 0.0, std::plus(), [](const fem::PadScene& scene) {
    return static_cast<double>(fem::pad_targets(scene.load).size());
  });
}

/// Scenes of the mix on one sensor in one batch.
double pad_steps_per_second(const PadStream& stream, const PadRung& rung) {
  const fem::PadSensor sensor;
  const auto scenes = random_scenes(fem::PadMix(7, &sensor), rung.cells > 12 ? 2048 : 4096);
  return asked_on_pads(scenes) / seconds_of(stream, scenes, 3);
}

}  // namespace

Tradeoff measure_pad_tradeoff(Executor& executor, const TradeoffOptions& options) {
  const auto scenes = random_scenes(fem::PadMix(static_cast<unsigned>(options.seed)), options.scenes);
  const std::vector<PadRung>& rungs = all_rungs<PadRung>();
  const auto go_on = [&](std::size_t done) {
    if (options.progress && !options.progress(done, scenes.size() + rungs.size() - 1))
      throw Stopped("stopped; no report is written");
  };
  Tradeoff result{.mix = fmt::format("{} contacts on pads drawn with seed {}: nine kinds of indenters in turn, nu 0.3 "
                                     "to 0.5, mu 0.1 to 1.5, 2 to 20 % of the thickness deep, eight drags, straight, "
                                     "curved or back, half of them with twists",
                                     options.scenes, options.seed),
                  .device = executor.device().info().name,
                  .scenes = options.scenes,
                  .seed = options.seed,
                  .definitions = pad_definitions};
  std::vector<fem::PadSolution> truth(scenes.size());
  std::vector<AnswerError> own(scenes.size());
  const auto start = Clock::now();
  const auto threads = static_cast<std::size_t>(executor.threads());
  for (std::size_t first = 0; first < scenes.size(); first += threads) {
    go_on(first);
    side_by_side(std::min(threads, scenes.size() - first), executor.threads(), [&](std::size_t k) {
      const fem::PadScene& scene = scenes[first + k];
      fem::PadReferenceSolution answer = fem::PadReference(fem::pad_layer(scene.sensor.poisson)).solve(scene);
      truth[first + k] = std::move(answer.solution), own[first + k] = answer_error(answer.error);
    });
  }
  const double reference_seconds = seconds_since(start);
  for (const PadRung& rung : rungs) {
    if (rung.exact) {
      result.models.push_back(judged_model(rung, truth, own));
      result.models.back().steps_per_second = asked_on_pads(scenes) / reference_seconds;
      continue;
    }
    go_on(scenes.size() + result.models.size());
    const PadStream stream(executor, model_of(rung));
    const std::vector<fem::PadSolution> answers = stream.solve(scenes);
    std::vector<AnswerError> errors;
    for (std::size_t i = 0; i < scenes.size(); ++i)
      errors.push_back(answer_error(fem::pad_difference(answers[i], truth[i])));
    result.models.push_back(judged_model(rung, answers, errors));
    result.models.back().steps_per_second = pad_steps_per_second(stream, rung);
  }
  result.judge_error = result.models.back().error.most95.S;
  mark_front(result.models);
  return result;
}

}  // namespace tactel::host
