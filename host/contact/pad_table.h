// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "host/contact/pad_solve.h"

namespace tactel::host {

/// Returns the answer as a table: scene, model and solver, then a line per load step, then what to expect of it.
std::string pad_table(const PadOutcome& outcome);

}  // namespace tactel::host
