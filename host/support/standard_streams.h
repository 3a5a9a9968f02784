// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>

namespace tactel::host {

/// Makes the three standard streams safe to use; call it first in main.
/// - A stream that is closed is opened on /dev/null in the wrong direction. No file that is opened later takes its
///   number, and writing to it fails as before.
/// - A file that grows beyond its limit (ulimit -f) fails the write, with EFBIG, and does not end the program.
/// - A failed write to `stderr` is ignored: a message that cannot be shown does not end a job.
void prepare_standard_streams();

/// Flushes standard output. Returns the reason why output was lost ("No space left on device"), or none where all
/// of it was written.
std::optional<std::string> lost_output();

}  // namespace tactel::host
