// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace CLI {
class App;
class Error;
}  // namespace CLI

namespace tactel::host {

/// Returns a wrong command line as one line of the form "command line: --scaling = row: must be one of set, frame", in
/// place of CLI11's text. `command`: the one that was typed, its options parsed as far as they could be.
std::string option_error(const CLI::App& command, const CLI::Error& error);

/// Throws ConfigError for nan or infinity as the value of an option that takes a number. `command`: parsed.
void check_numbers(const CLI::App& command);

}  // namespace tactel::host
