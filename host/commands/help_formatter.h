// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

namespace CLI {
class FormatterBase;
}  // namespace CLI

namespace tactel::host {

/// Formats the help of the program and of its commands: two columns, wrapped at 80; types and defaults in words.
std::shared_ptr<CLI::FormatterBase> help_formatter();

}  // namespace tactel::host
