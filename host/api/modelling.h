// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <span>
#include <string>

#include "fem/scene.h"
#include "host/device/executor.h"
#include "host/scenes/ladder.h"

namespace tactel::api {

/// Throws ConfigError for what is neither "", "fp32" nor "fp64".
void check_precision(const std::string& precision);

/// Returns the rung for many contacts: that of the name, or the one that the planner takes for an accuracy on a sample
/// of them, or none. Throws ConfigError for contradictory options, and for a rung that solves single contacts.
std::optional<host::Rung> rung_for_many(host::Executor& executor, const std::string& rung,
                                        const std::optional<double>& accuracy, std::span<const fem::Scene> sample);

/// Number of contacts of a sample.
inline constexpr std::size_t sample_size = 64;

}  // namespace tactel::api
