// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "host/commands/command.h"
#include "host/support/log.h"

namespace tactel::host {

/// Runs a command. Reports its exception on stderr, in one line, and returns the exit code of that exception.
/// After a first Ctrl-C an error of device or hardware is the effect of the stop: the exit code is then 130.
int guarded(const Action& action);

/// Writes "error: MESSAGE" to stderr and returns `code`; never throws for a stream that takes nothing.
int complain(ExitCode code, const std::string& message);

/// Returns a sink for the default log of the devices. It reports on stderr work of more than half a second on a
/// device, such as the compilation of kernels that are not in the cache, and ignores all else.
LogSink kernel_line();

/// Formats the help of the program and of its commands: two columns, wrapped at 80; types and defaults in words.
std::shared_ptr<CLI::FormatterBase> help_formatter();

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
