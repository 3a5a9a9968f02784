// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <optional>
#include <string>

#include "fem/pad/pad_scene.h"
#include "host/commands/shared_options.h"
#include "host/contact/convergence.h"
#include "host/figures/contact_figure.h"
#include "host/figures/pad_view.h"
#include "host/support/progress_line.h"

namespace tactel::host {

/// Options of `tactel solve`.
struct SolveRequest {
  SharedOptions shared;
  std::string scene, json, plot, field, html;
  std::optional<int> step;
  bool derivatives = false, converge = false;
};

/// Returns the index of the step that --step names, from 1; the last by default. Throws ConfigError.
std::size_t chosen_step(const SolveRequest& request, std::size_t steps);

/// Prints a warning unless --quiet.
void warn(const SolveRequest& request, const std::string& text);

/// Judges the step of --step, or a telling one, beside ever smaller cells where --converge asks for it.
template <class Outcome>
void judge(const SolveRequest& request, Outcome& outcome) {
  if (!request.converge) return;
  std::unique_ptr<StageLine> stage;
  const std::size_t last = chosen_step(request, outcome.solution.steps.size());
  const std::size_t step = request.step ? last : telling_step(outcome.solution);
  outcome.convergence = std::make_shared<const Convergence>(converge(outcome, step, [&](const std::string& rung) {
    stage.reset();
    stage = std::make_unique<StageLine>("solving " + rung, request.shared.quiet);
  }));
}

/// `tactel solve` of a pad.
int run_solve_pad(const SolveRequest& request, const fem::PadScene& scene);

}  // namespace tactel::host
