// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/commands/command.h"
#include "host/support/tables.h"

namespace tactel::host {

/// Whether the help shows a value that is there from the beginning.
template <class M>
bool is_shown(const M&) {
  return std::is_arithmetic_v<M>;
}
inline bool is_shown(const std::string& value) { return !value.empty(); }

/// Adds a flag.
inline CLI::Option* add_option(CLI::App& command, const std::string& names, bool& value, const std::string& help,
                               const Taken& = {}) {
  return command.add_flag(names, value, help);
}
/// Adds an option. The help shows the value where there is one and the text names
/// no default. Each value of a list comes with an option of its own.
template <class M>
CLI::Option* add_option(CLI::App& command, const std::string& names, M& value, const std::string& help,
                        const Taken& taken = {}) {
  using Number = typename decltype(std::optional(value))::value_type;
  using Bound = std::conditional_t<std::is_floating_point_v<Number>, Number, int>;
  CLI::Option* option = command.add_option(names, value, help);
  std::vector<std::string> words;
  for (const char* word : taken.words)
    if (word != nullptr) words.emplace_back(word);
  if (!words.empty()) option->check(CLI::IsMember(words));
  if (taken.positive) option->check(CLI::PositiveNumber);
  if (taken.type != nullptr) option->type_name(taken.type);
  if (taken.most > 0) option->check(CLI::Range(static_cast<Bound>(taken.least), static_cast<Bound>(taken.most)));
  if (!std::is_arithmetic_v<Number> && !std::is_same_v<M, std::string>) option->allow_extra_args(false);
  if (is_shown(value) && help.find("(default: ") == std::string::npos) option->capture_default_str();
  return option;
}

/// Adds the options of a table, in its order.
template <class Request, class Table>
void add_options(CLI::App& command, Request& request, const Table& table) {
  each(table, [&](const auto& option) {
    add_option(command, option.names, request.*option.member, option.help, option.taken)->group(option.place);
  });
}

/// Adds a command to a group of the help, which calls run(request) with the request that its options fill. Returns the
/// two.
template <class Argument, class Request = std::remove_cvref_t<Argument>>
std::pair<CLI::App&, Request&> add_command(CLI::App& app, Action& action, const char* group, const char* name,
                                           const char* help, int (*run)(Argument)) {
  const auto request = std::make_shared<Request>();
  CLI::App* command = app.add_subcommand(name, help);
  command->group(group);
  command->callback([=, &action] { action = [=] { return run(*request); }; });
  return {*command, *request};
}

}  // namespace tactel::host
