// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "host/answers/line_error.h"
#include "host/contact/stream_of.h"
#include "host/device/executor.h"
#include "host/figures/plot.h"
#include "host/scenes/ladder.h"

namespace tactel::host {

struct TradeoffOptions {
  std::size_t scenes =
      288;  ///< for patches; meshes, which are slower, are judged on the first third of them, 8 at least
  std::uint64_t seed = 1998;
  Progress progress{};  ///< models, and of pads the judge's scenes; false stops
};

/// Error and speed of a model on the mix of scenes.
struct MeasuredModel {
  std::variant<Rung, PadRung> rung;
  ErrorQuantiles error;         ///< against the judge
  double unsolved = 0;          ///< share of increments that missed the model's tolerance
  double sweeps = 0;            ///< Gauss-Seidel sweeps an increment, mean
  double steps_per_second = 0;  ///< requested load increments, in a batch; 0: not timed
  bool front = false;           ///< no other model is as fast with a smaller 95 % error in S
};

/// Returns the errors of answers on a rung beside those of the judge, [scenes]. Answers may be fewer than the judge's.
std::vector<AnswerError> answer_errors(std::span<const fem::Scene> scenes,
                                       const std::vector<fem::ContactSolution>& answers, const Rung& rung,
                                       const std::vector<fem::ContactSolution>& truth, const Rung& judge);
/// Returns error, misses and sweeps of a model; its speed is not measured. `answers`, `errors`: [scenes].
MeasuredModel judged_model(const auto& rung, const auto& answers, const std::vector<AnswerError>& errors) {
  MeasuredModel model{.rung = rung, .error = quantiles(errors)};
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

struct Tradeoff {
  std::string mix, device;
  std::size_t scenes = 0;
  std::uint64_t seed = 0;
  std::string definitions;              ///< of errors and speed
  double judge_error = 0;               ///< of the reference in S, 95 % of the scenes
  std::vector<MeasuredModel> models{};  ///< named rungs first
};

/// Judges the models of lines by the reference and times them. Throws Stopped where progress returns false.
Tradeoff measure_tradeoff(Executor& executor, const TradeoffOptions& options);
/// The same of pads, on scenes of fem::PadMix.
Tradeoff measure_pad_tradeoff(Executor& executor, const TradeoffOptions& options);

/// Marks the models that no other one beats in both error and speed.
void mark_front(std::vector<MeasuredModel>& models);

/// Returns the seconds in kernels, as sets run them: without forces of elements; best of a few runs.
template <class Contacts>
double seconds_of(const StreamOf<Contacts>& stream, const std::vector<typename Contacts::Scene>& scenes, int runs) {
  typename StreamOf<Contacts>::Part part;
  for (const auto& scene : scenes) stream.add(part, scene, Contacts::path(scene));
  part.lay_out();
  double best = std::numeric_limits<double>::infinity();
  for (int run = 0; run < runs; ++run) {
    part.run();
    best = std::min(best, part.seconds());
  }
  return best;
}

nlohmann::ordered_json to_json(const Tradeoff& tradeoff);

/// Returns a figure of the error in S against speed, and the Pareto front.
Figure tradeoff_figure(const Tradeoff& tradeoff);

std::string tradeoff_page(const Tradeoff& tradeoff);

/// Returns the table for a terminal.
std::string tradeoff_table(const Tradeoff& tradeoff);

}  // namespace tactel::host
