#pragma once
#include "host/device/executor.h"
#include "host/scenes/paper_sets.h"
#include "host/sets/contact_set.h"

namespace tactel::host {

/// Simulates a family by SetSimulator.
ContactSet simulate_family(Executor& executor, const SceneFamily& family, Precision precision, double tolerance);

}  // namespace tactel::host
