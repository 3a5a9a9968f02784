// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "host/commands/program.h"
#include "host/support/errors.h"
#include "host/support/nearest_word.h"

namespace tactel::host {
namespace {

std::string message(const std::string& name, const std::string& value, const std::string& allowed) {
  return ConfigError("command line", name, value, allowed).what();
}

bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() != 0; }

/// "--output"; of an argument without a name its type: "SCENE.toml".
std::string name_of(const CLI::Option& option) {
  return option.get_positional() ? option.get_type_name() : option.get_name();
}

/// The option that CLI11's text names, by the name that CLI11 gives it; none where it names none.
const CLI::Option* named_option(const CLI::App& command, const std::string& text) {
  const CLI::Option* found = nullptr;
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    const auto at = text.find(name);
    if (name.empty() || at == std::string::npos || (at > 0 && text[at - 1] != ' ')) continue;
    const auto end = at + name.size();
    if (end < text.size() && text[end] != ' ' && text[end] != ':') continue;
    if (found == nullptr || at < text.find(found->get_name())) found = option;
  }
  return found;
}

/// "set", "frame" of "TEXT:{set,frame}"; none of others.
std::vector<std::string> choices_in(const std::string& type) {
  const auto open = type.find('{'), close = type.find('}');
  if (open == std::string::npos || close == std::string::npos) return {};
  return CLI::detail::split(type.substr(open + 1, close - open - 1), ',');
}

bool whole_number(const std::string& type) {
  const std::string plain = type.substr(0, type.find(':'));
  return plain == "INT" || plain == "UINT" || plain == "N" || plain == "K" || plain == "ROWS";
}

/// What the option takes, in words: "one of set, frame", "a whole number above 0", "given as FILE".
std::string allowed_by(const CLI::Option& option) {
  if (!takes_value(option)) return "given without a value";
  const std::string type = option.get_type_name();
  const auto holds = [&](const char* word) { return type.find(word) != std::string::npos; };
  if (const auto choices = choices_in(type); !choices.empty()) return "one of " + listed(choices);
  std::string number = whole_number(type) ? "a whole number" : "a number";
  if (const std::string range = range_in(type); !range.empty()) return number + ", " + range;
  if (holds("NONNEGATIVE")) return number + " of 0 or more";
  if (holds("POSITIVE") || holds("above 0")) return number + " above 0";
  if (type == "UINT") return number + " of 0 or more";
  if (whole_number(type) || type == "FLOAT") return number;
  return type.empty() || type == "TEXT" ? "given" : "given as " + type;
}

bool is_number(const std::string& text) {
  char* end = nullptr;
  std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0';
}

/// The value that CLI11 refused, of those that the option was given.
std::string refused_value(const CLI::Option& option, const std::string& text) {
  const std::vector<std::string>& values = option.results();
  if (values.empty()) return "(missing)";
  const std::string type = option.get_type_name();
  if (text.starts_with("Could not convert")) {
    const auto none = std::ranges::find_if(values, [](const std::string& value) { return !is_number(value); });
    return none == values.end() ? values.back() : *none;
  }
  const auto quoted = [&](const std::string& value) {
    return text.find(" " + value + " ") != std::string::npos || text.find(" " + value + ":") != std::string::npos;
  };
  const auto found = std::ranges::find_if(values, quoted);
  return found == values.end() ? values.back() : *found;
}

bool is_option(const std::string& word) { return word.starts_with("-"); }

/// The first argument that the command does not know, with the most similar option.
std::string unknown_argument(const CLI::App& command) {
  const std::vector<std::string> extras = command.remaining();
  const auto found = std::ranges::find_if(extras, is_option);
  if (found == extras.end())
    return message("argument", extras.empty() ? "" : extras.back(),
                   fmt::format("left out: {} takes no more", called(command)));
  const std::string word = found->substr(0, found->find('='));
  if (word == "--derivatives" && called(command) == "tactel solve")
    return message(word, "", "left out: they are differences of two answers (Python: solve, Scene.with_)");
  return message(word, "",
                 fmt::format("an option of {}{}", called(command), did_you_mean(word, names_of_options(command))));
}

/// Whether the text reads as nan or an infinity, as strtod does.
bool is_not_finite(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' && !std::isfinite(value);
}

/// Whether the text has a 0 in front, by which CLI11 reads a hexadecimal number or an octal one.
bool has_other_base(const std::string& text) {
  const std::size_t first = text.find_first_not_of("+-");
  return first != std::string::npos && text[first] == '0' && first + 1 < text.size() && text[first + 1] != '.' &&
         text[first + 1] != 'e' && text[first + 1] != 'E';
}

bool takes_number(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const auto holds = [&](const char* word) { return type.find(word) != std::string::npos; };
  return holds("FLOAT") || holds("POSITIVE") || holds("NONNEGATIVE") || type.starts_with("INT") ||
         type.starts_with("UINT") || holds("INT in [");
}

}  // namespace

std::string range_in(const std::string& type) {
  const auto open = type.find(" in ["), between = type.find(" - ", open), close = type.find(']', open);
  if (open == std::string::npos || between == std::string::npos || close == std::string::npos) return "";
  return type.substr(open + 5, between - open - 5) + " to " + type.substr(between + 3, close - between - 3);
}

std::string called(const CLI::App& command) {
  return (command.get_parent() == nullptr ? "" : called(*command.get_parent()) + " ") + command.get_name();
}

std::vector<std::string> names_of_options(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::string option_error(const CLI::App& command, const CLI::Error& error) {
  const auto is = [&]<class Kind>(const Kind*) { return dynamic_cast<const Kind*>(&error) != nullptr; };
  const std::string text = error.what();
  const bool lacks = is(static_cast<CLI::RequiredError*>(nullptr));  // perhaps what a misspelt option should be
  if (is(static_cast<CLI::ExtrasError*>(nullptr)) || (lacks && std::ranges::any_of(command.remaining(), is_option)))
    return unknown_argument(command);
  const CLI::Option* option = named_option(command, text);
  if (option == nullptr) return "command line: " + text;
  if (lacks) {
    const std::string type = option->get_type_name();
    return message(name_of(*option), "(missing)", option->get_positional() ? "given" : allowed_by(*option));
  }
  if (is(static_cast<CLI::RequiresError*>(nullptr)))
    return message(option->get_name(), "", "left out, or with " + text.substr(text.rfind(' ') + 1));
  if (is(static_cast<CLI::ExcludesError*>(nullptr)))
    return message(option->get_name(), "", "left out with " + text.substr(text.rfind(' ') + 1));
  if (is(static_cast<CLI::ArgumentMismatch*>(nullptr)))
    return option->results().size() > 1 ? message(name_of(*option), option->results().back(), "given once")
                                        : message(name_of(*option), "(missing)", allowed_by(*option));
  if (is(static_cast<CLI::ValidationError*>(nullptr)) || is(static_cast<CLI::ConversionError*>(nullptr))) {
    const std::string value = refused_value(*option, text);
    return message(name_of(*option), value,
                   allowed_by(*option) + did_you_mean(value, choices_in(option->get_type_name())));
  }
  return "command line: " + text;
}

void check_numbers(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    if (!takes_number(*option)) continue;
    for (const std::string& value : option->results())
      if (is_not_finite(value) || has_other_base(value))
        throw ConfigError("command line", option->get_name(), value,
                          "a finite number, decimal and without a 0 in front");
  }
}

}  // namespace tactel::host
