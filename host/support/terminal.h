// SPDX-License-Identifier: Apache-2.0
#pragma once
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

}  // namespace tactel::host
