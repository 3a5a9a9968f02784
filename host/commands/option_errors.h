// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

namespace CLI {
class App;
class Error;
}  // namespace CLI

namespace tactel::host {

/// "8 to 100000" of CLI11's type "UINT:INT in [8 - 100000]"; empty of others.
std::string range_in(const std::string& type);

/// "tactel calibrate bound": a command as a user writes it.
std::string called(const CLI::App& command);

/// "--html" of each option.
std::vector<std::string> names_of_options(const CLI::App& command);

/// Returns a wrong command line as one line of the form "command line: --scaling = row: must be one of set, frame", in
/// place of CLI11's text. `command`: the one that was typed, its options parsed as far as they could be.
std::string option_error(const CLI::App& command, const CLI::Error& error);

/// Throws ConfigError for nan or infinity as the value of an option that takes a number. `command`: parsed.
void check_numbers(const CLI::App& command);

}  // namespace tactel::host
