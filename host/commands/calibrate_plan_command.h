// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "host/commands/command.h"

namespace tactel::host {

/// Adds `plan` to the command `calibrate`.
void add_calibrate_plan_command(CLI::App& calibrate, Action& action);

}  // namespace tactel::host
