// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include "host/commands/command.h"
#include "host/commands/program.h"
#include "host/device/device.h"
#include "host/support/nearest_word.h"
#include "host/support/terminal.h"

namespace {

using namespace tactel;
using namespace tactel::host;

const std::string compile_word = "compile-kernels";  // of no user

/// Warnings of the library, and what keeps a device busy, unless the command was told to be quiet.
void show_messages(const CLI::App& command) {
  const CLI::Option* quiet = command.get_option_no_throw("--quiet");
  if (quiet != nullptr && quiet->count() > 0) return;
  set_default_log([busy = kernel_line()](LogLevel level, std::string_view message) {
    if (level == LogLevel::warning) print_warning(message);
    busy(level, message);
  });
}

constexpr std::pair<std::string_view, std::string_view> moved_to_python[] = {
    {"floor", "tactel.floor"},
    {"import-network", "tactel.import_network"},
    {"calibrate plan", "tactel.calibrate plan"},
    {"calibrate sensor", "tactel.calibrate sensor"}};

/// The exit code of a run, after all that it printed is out.
int finished(int code) {
  const auto lost = lost_output();
  if (!lost) return code;
  complain(wrong_input, "standard output: must be writable to its end (" + *lost + "); a part of the output is lost");
  return code == done ? static_cast<int>(wrong_input) : code;
}

std::vector<std::string> commands_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

bool holds(const std::vector<std::string>& words, const std::string& word) {
  return std::ranges::find(words, word) != words.end();
}

/// "; did you mean X?", or where options and files stand; empty of other words that are near to none.
std::string fix_of(const CLI::App& app, const std::string& word) {
  for (const CLI::App* command : app.get_subcommands({}))
    if (holds(commands_of(*command), word)) return "; did you mean " + command->get_name() + " " + word + "?";
  std::vector<std::string> known = commands_of(app);
  for (const std::string& name : names_of_options(app)) known.push_back(name);
  const std::string nearest = did_you_mean(word, known);
  const bool out_of_place = word.starts_with('-') || word.find('.') != std::string::npos;
  return nearest.empty() && out_of_place ? "; options and files stand behind it" : nearest;
}

/// Says that a word where a command should be is none, and which are; CLI11 would only say that one is missing.
bool refuse_unknown_command(const CLI::App& app, std::span<const std::string> words) {
  const std::vector<std::string> known = commands_of(app);
  const std::string word = words.empty() ? "(missing)" : words.front();
  if (known.empty() || app.get_option_no_throw(word) != nullptr) return false;
  if (holds(known, word)) return refuse_unknown_command(*app.get_subcommand(word), words.subspan(1));
  for (const auto& [moved, module] : moved_to_python)
    if (called(app) + " " + word == fmt::format("tactel {}", moved)) {
      complain(wrong_input,
               fmt::format("command line: command = {}: belongs to the Python package; python -m {}", moved, module));
      return true;
    }
  complain(wrong_input, fmt::format("command line: command = {}: must be one of {}{}\nsee {} --help", word,
                                    listed(known), fix_of(app, word), called(app)));
  return true;
}

/// The command that was typed: bound of `tactel calibrate bound`.
const CLI::App& chosen(const CLI::App& app) {
  const auto commands = app.get_subcommands();
  return commands.empty() ? app : chosen(*commands.front());
}

/// CLI11's complaint in the form of ours.
int refuse_options(const CLI::App& command, const CLI::ParseError& error) {
  return complain(wrong_input, fmt::format("{}\nsee {} --help", option_error(command, error), called(command)));
}

/// `tactel help [COMMAND]` as `tactel [COMMAND] --help`.
std::vector<std::string> arguments_of(int argc, char** argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  if (!words.empty() && words.front() == "help") {
    words.erase(words.begin());
    words.push_back("--help");
  }
  return words;
}

int run(int argc, char** argv) {
  CLI::App app{
      "tactel: a tactile rubber skin in contact. S is the slippage index: 0 sticks, 1 slides as a whole. Units: "
      "mm, MPa (N/mm2), N/mm (force per unit depth), s, degrees. `tactel demo` shows a contact, a network and a live "
      "view in a "
      "minute; `tactel COMMAND --help` lists options, with an example.",
      "tactel"};
  app.set_version_flag("-V,--version", "tactel " TACTEL_VERSION, "print the version");
  app.set_help_flag("-h,--help", "print this help");
  app.formatter(help_formatter());
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done, 2 wrong input, 3 device or hardware, 4 something did not meet its tolerance, 130 Ctrl-C.");
  Action action;
  add_solve_command(app, action);
  add_generate_command(app, action);
  add_check_command(app, action);
  add_train_command(app, action);
  add_recall_command(app, action);
  add_calibrate_command(app, action);
  add_monitor_command(app, action);
  add_record_command(app, action);
  add_tare_command(app, action);
  add_reproduce_command(app, action);
  add_tradeoff_command(app, action);
  add_extremes_command(app, action);
  add_devices_command(app, action);
  add_demo_command(app, action);
  std::vector<std::string> words = arguments_of(argc, argv);
  if (words.empty()) {
    std::fputs(app.help().c_str(), stderr);
    return wrong_input;
  }
  if (refuse_unknown_command(app, words)) return wrong_input;
  std::ranges::reverse(words);  // CLI11 takes them from the back
  try {
    app.parse(words);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    return refuse_options(chosen(app), error);
  }
  return guarded([&] {
    check_numbers(chosen(app));
    show_messages(chosen(app));
    return action();
  });
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 4 && argv[1] == compile_word) return compile_for_parent(argv[2], argv[3]);
  set_compiler({"/proc/self/exe", compile_word});
  prepare_standard_streams();
  return finished(run(argc, argv));
}
