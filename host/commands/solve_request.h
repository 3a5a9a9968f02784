// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>

#include "fem/pad/pad_scene.h"
#include "host/commands/shared_options.h"

namespace tactel::host {

/// Options of `tactel solve`.
struct SolveRequest {
  SharedOptions shared;
  std::string scene, json, plot, field, html;
  std::optional<int> step;
  bool derivatives = false;
};

/// Returns the index of the step that --step names, from 1; the last by default. Throws ConfigError.
std::size_t chosen_step(const SolveRequest& request, std::size_t steps);

/// Prints a warning unless --quiet.
void warn(const SolveRequest& request, const std::string& text);

/// `tactel solve` of a pad.
int run_solve_pad(const SolveRequest& request, const fem::PadScene& scene);

}  // namespace tactel::host
