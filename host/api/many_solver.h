// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/solve.h>

#include <span>

#include "fem/scene.h"
#include "host/contact/solve.h"

namespace tactel::api {

/// Solves many scenes by streams (host/contact/contact_stream.h) into arrays. Throws ConfigError for options that
/// cannot be, Cancelled where progress, in scenes, says so.
Paths solve_paths(const host::SolveOptions& options, std::span<const fem::Scene> scenes,
                  const ProgressFunction& progress);

}  // namespace tactel::api
