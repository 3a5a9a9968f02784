// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace tactel::host {

/// Exit codes of the program; scripts of users rely on them. 130 is the code of shells for SIGINT.
enum ExitCode { done = 0, wrong_input = 2, device_failed = 3, not_converged = 4, interrupted = 130 };

}  // namespace tactel::host
