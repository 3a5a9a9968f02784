// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <string>

#include "host/commands/command.h"

namespace tactel::host {
namespace {

/// The words that may follow an option: "words set frame", "files toml", "files", or "" where only the user knows.
std::string values_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const auto open = type.find('{'), close = type.find('}');
  if (open != std::string::npos && close != std::string::npos) {
    std::string words = type.substr(open + 1, close - open - 1);
    for (char& c : words)
      if (c == ',') c = ' ';
    return "words " + words;
  }
  if (const auto dot = type.find('.'); dot != std::string::npos)
    return "files " + type.substr(dot + 1, type.find_first_of("|: ", dot) - dot - 1);
  return type == "FILE" || type == "DIR" ? "files" : "";
}

/// Names of an option as typed: "--json", "-h --help".
std::string names_of(const CLI::Option& option) {
  std::string names;
  for (const std::string& name : option.get_snames()) names += "-" + name + " ";
  for (const std::string& name : option.get_lnames()) names += "--" + name + " ";
  return names;
}

std::string joined(std::string names, const char* between) {
  if (!names.empty()) names.pop_back();
  for (std::size_t at = 0; (at = names.find(' ', at)) != std::string::npos; at += std::string(between).size())
    names.replace(at, 1, between);
  return names;
}

/// The branch of one command: what follows its options, its options, its own files.
std::string branch_of(const CLI::App& command) {
  std::string after, options, files = "files";
  for (const CLI::Option* option : command.get_options()) {
    const std::string names = names_of(*option);
    if (names.empty()) {
      if (const std::string own = values_of(*option); !own.empty()) files = own;
      continue;
    }
    options += names;
    if (option->get_type_size() != 0)
      after += fmt::format("        {}) _tactel_{} ;;\n", joined(names, "|"),
                           values_of(*option).empty() ? "words" : values_of(*option));
  }
  return fmt::format(
      "    {})\n      case $previous in\n{}        *) [[ $word == -* ]] && _tactel_words {} || _tactel_{} ;;\n"
      "      esac ;;\n",
      command.get_name(), after, joined(options, " "), files);
}

std::string bash_script(const CLI::App& app) {
  std::string commands, branches;
  for (const CLI::App* command : app.get_subcommands({})) {
    commands += command->get_name() + " ";
    branches += branch_of(*command);
  }
  return fmt::format(R"(# bash completion of tactel; written by `tactel completion`
_tactel_words() {{ mapfile -t COMPREPLY < <(compgen -W "$*" -- "$word"); }}
_tactel_files() {{
  compopt -o filenames 2>/dev/null
  mapfile -t COMPREPLY < <(compgen -d -- "$word"; compgen -f ${{1:+-X "!*.$1"}} -- "$word")
}}
_tactel() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD-1]}}
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then _tactel_words {} help --help --version; return; fi
  case ${{COMP_WORDS[1]}} in
    help) _tactel_words {} ;;
{}  esac
}}
complete -F _tactel tactel
)",
                     joined(commands, " "), joined(commands, " "), branches);
}

}  // namespace

void add_completion_command(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("completion", "print the completion of commands and options for bash");
  command->group("Set up");
  command->footer("Use it in this shell: source <(tactel completion)");
  command->callback([&app, &action] {
    action = [&app] { return std::fputs(bash_script(app).c_str(), stdout) < 0 ? wrong_input : done; };
  });
}

}  // namespace tactel::host
