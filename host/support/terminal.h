// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <string_view>

namespace tactel::host {

/// Returns true where a descriptor is a terminal that moves its cursor (TERM is set and is not "dumb").
bool is_terminal(int descriptor);

/// Returns true where a descriptor is such a terminal and the user has not set NO_COLOR (no-color.org).
bool takes_colour(int descriptor);

enum class Colour { red = 31, green = 32, yellow = 33 };
/// Returns the text in bold colour: an escape sequence on both sides.
std::string painted(std::string_view text, Colour colour);

/// Prints "error: TEXT" or "warning: TEXT" and a line end on stderr, at once; its first word in colour where stderr
/// takes it. A stream that takes nothing is ignored.
void print_error(std::string_view text);
void print_warning(std::string_view text);

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
