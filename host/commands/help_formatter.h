#pragma once
#include <memory>
#include <string>

namespace CLI {
class App;
class FormatterBase;
}  // namespace CLI

namespace tactel::host {

/// Formats the help of the program and of its commands: two columns, wrapped at 80; types and defaults in words.
std::shared_ptr<CLI::FormatterBase> help_formatter();

/// Throws ConfigError for nan or infinity as the value of an option that takes a number. `command`: parsed.
void check_numbers(const CLI::App& command);

/// Returns the message about the unknown arguments of `command`: the first of them, with the most similar
/// option.
std::string unknown_argument(const CLI::App& command);

}  // namespace tactel::host
