// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "host/commands/command.h"

namespace tactel::host {

/// Runs a command. Reports its exception on stderr, in one line, and returns the exit code of that exception.
/// After a first Ctrl-C an error of device or hardware is the effect of the stop: the exit code is then 130.
int guarded(const Action& action);

/// Writes "error: MESSAGE" to stderr and returns `code`; never throws for a stream that takes nothing.
int complain(ExitCode code, const std::string& message);

}  // namespace tactel::host
