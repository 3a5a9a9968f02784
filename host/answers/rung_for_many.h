// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <optional>

#include "fem/layer/sensor_family.h"
#include "host/answers/planner.h"
#include "host/answers/solve.h"
#include "host/contact/pads/pad_rung.h"
#include "host/device/executor.h"

namespace tactel::host {

/// Largest number of contacts that the planner tries for all of them.
inline constexpr std::uint64_t most_tried = 64;

/// Contacts of which the planner tries some.
struct ManyContacts {
  std::uint64_t count = 0;
  std::function<fem::Scene(std::uint64_t k)> contact;  ///< returns contact k
  std::optional<fem::SensorRange> own_sensors = {};    ///< where each contact has its own sensor, of this range
};

/// Returns the rung that --rung names; none where it names none. Throws ConfigError for contradictory options, and for
/// a rung that solves single contacts.
std::optional<Rung> named_rung_for_many(const SolveOptions& options);
std::optional<PadRung> pad_rung_for_many(const SolveOptions& options);  ///< of pads

/// Returns the planner's choice for at most most_tried of the contacts, one from each equal part of all.
RungChoice plan_for_many(Executor& executor, double accuracy, const ManyContacts& contacts);

/// Returns the rung that --rung names, or that --accuracy takes; none without both. Throws as named_rung_for_many.
std::optional<Rung> rung_for_many(Executor& executor, const SolveOptions& options, const ManyContacts& contacts);

}  // namespace tactel::host
