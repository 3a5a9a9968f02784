// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "host/sets/set_simulator.h"

namespace tactel::host {

/// Returns the simulator of a sweep of grips that hold an object, [load.hold]: contacts with one sensor are stepped
/// together (host/contact/pad_step.h), a frame a row from the end of the pressing on, on cells of which the pad's
/// shorter side has as many as the rung says. The rows of a grip depend on the source and its number alone.
std::unique_ptr<SetSimulator::State> hold_simulator(Executor& executor, const PadSource& source,
                                                    const SetOptions& options);

}  // namespace tactel::host
