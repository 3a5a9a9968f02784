// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>

#include "host/device/executor.h"
#include "host/scenes/paper_sets.h"
#include "host/sets/contact_set.h"

namespace tactel::host {

/// Simulates a family by SetSimulator. Warns on the device's log of contacts that stay unsolved.
ContactSet simulate_family(Executor& executor, const SceneFamily& family, Precision precision, double tolerance);

/// Returns a warning about contacts that stayed unsolved, with their count; none where there are none.
std::optional<std::string> unsolved_warning(const ContactSet& set);

}  // namespace tactel::host
