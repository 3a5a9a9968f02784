// SPDX-License-Identifier: Apache-2.0

// What the program says of options whose value is wrong or missing: one form for all, of every command.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <map>
#include <regex>
#include <set>

#include "tests/host/support/run_tactel.h"

namespace tactel::host::option_errors_test {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::vector<std::string> commands = {"solve",    "generate", "check",   "train",  "recall", "reproduce",
                                           "tradeoff", "extremes", "monitor", "record", "tare",   "devices"};

/// The error's first line; fails where the exit code is not 2 or standard output holds something.
std::string error_of(const std::vector<std::string>& arguments) {
  const ChildResult result = run_tactel(arguments);
  EXPECT_EQ(result.exit_code, 2) << arguments.back();
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, HasSubstr("\nsee tactel " + arguments.front() + " "));
  return result.err.substr(0, result.err.find('\n'));
}

/// Options of a command, each with its type as the help shows it: "--scaling" "set|frame".
std::map<std::string, std::string> options_of(const std::string& command) {
  const std::string help = run_tactel({command, "--help"}).out;
  std::map<std::string, std::string> options;
  const std::regex option(R"((?:^|\n)  (?:-\w, )?(--[a-z-]+)(?:, --[a-z-]+)* ([^\s-][^\s]*))");
  for (std::sregex_iterator one(help.begin(), help.end(), option), end; one != end; ++one)
    options[(*one)[1]] = (*one)[2];
  return options;
}

TEST(OptionErrors, AChoiceNamesAllThatIsAllowed) {
  const std::regex choices("[a-z0-9-]+([|][a-z0-9-]+)+");
  std::set<std::string> found;
  for (const std::string& command : commands)
    for (auto [option, type] : options_of(command)) {
      if (!std::regex_match(type, choices)) continue;
      found.insert(fmt::format("{} {}", command, option));
      const std::string allowed = std::regex_replace(type, std::regex("[|]"), ", ");
      EXPECT_EQ(error_of({command, option, "row"}),
                fmt::format("error: command line: {} = row: must be one of {}", option, allowed));
      EXPECT_EQ(error_of({command, option}),
                fmt::format("error: command line: {} = (missing): must be one of {}", option, allowed));
    }
  EXPECT_THAT(found,
              testing::IsSupersetOf({"solve --solver", "solve --precision", "generate --precision", "train --scaling",
                                     "train --order", "train --schedule", "train --optimizer", "recall --precision"}));
}

// The rungs do not fit in a column: the help names them in words, the error lists all.
TEST(OptionErrors, ManyChoicesAreListedByTheError) {
  for (const char* command : {"solve", "generate"})
    EXPECT_EQ(
        error_of({command, "--rung", "row"}),
        "error: command line: --rung = row: must be one of patch-8, patch-12, patch-16, patch-24, paper, mesh-41, "
        "mesh-81, mesh-161, mesh-321, mesh-641, patch-60, reference, draft, medium, fine, finest, pad-8, pad-12, "
        "pad-16, pad-24");
}

TEST(OptionErrors, EveryOptionWithoutItsValueSaysWhatItTakes) {
  for (const std::string& command : commands)
    for (const auto& [option, type] : options_of(command)) {
      // Without a number that of tare; without a place 8080.
      if (command == "monitor" && (option == "--alarm" || option == "--serve")) continue;
      EXPECT_THAT(error_of({command, option}),
                  AllOf(HasSubstr("error: command line: " + option + " = (missing): must be "), Not(HasSubstr("TEXT")),
                        Not(HasSubstr("FLOAT")), Not(HasSubstr("INT")), Not(HasSubstr("POSITIVE"))))
          << command << " " << type;
    }
}

class WrongOptionTest : public testing::TestWithParam<WrongCall> {};

TEST_P(WrongOptionTest, IsNamedWithItsValueAndWhatIsAllowed) {
  EXPECT_EQ(error_of(words(GetParam().arguments)), "error: command line: " + GetParam().says);
}

const WrongCall wrong_calls[] = {
    {"Range", "tradeoff --scenes 3", "--scenes = 3: must be a whole number, 8 to 100000"},
    {"RangeOfWords", "reproduce --seeds many", "--seeds = many: must be a whole number, 1 to 100000"},
    {"Zero", "train --seeds 0", "--seeds = 0: must be a whole number above 0"},
    {"NegativeCount", "train --rows -5", "--rows = -5: must be a whole number above 0"},
    {"NoCount", "monitor --every 0", "--every = 0: must be a whole number above 0"},
    {"NegativeTime", "monitor --late -1", "--late = -1: must be a number above 0"},
    {"NoNumber", "solve a.toml --accuracy x", "--accuracy = x: must be a number above 0"},
    {"PartOfANumber", "solve a.toml --step 1.5", "--step = 1.5: must be a whole number"},
    {"ManyOfWhichOneIsNone", "train --noise 0.1 --noise 0.2x --noise 0.3", "--noise = 0.2x: must be a number"},
    {"MissingFile", "solve", "SCENE.toml = (missing): must be given"},
    {"MissingSecondFile", "recall net", "SET.h5|RECORDING = (missing): must be given"},
    {"MissingOption", "train a.h5", "--output = (missing): must be given as DIR"},
    {"Contradiction", "train --output a --resume --force", "--resume: must be left out with --force"},
    {"FlagWithAValue", "solve a.toml --quiet=maybe", "--quiet = maybe: must be given without a value"},
    {"Unknown", "train --sclaing set --output a",
     "--sclaing: must be an option of tactel train; did you mean --scaling?"},
    {"InPlaceOfARequiredOption", "generate a.toml --outptu b.h5",
     "--outptu: must be an option of tactel generate; did you mean --output?"},
    {"Beginning", "tradeoff --out a", "--out: must be an option of tactel tradeoff; did you mean --output?"},
    {"Capitals", "solve a.toml --JSON -", "--JSON: must be an option of tactel solve; did you mean --json?"},
    {"NearChoice", "train --target slipindex",
     "--target = slipindex: must be one of slip_index, force_ratio, stick_fraction, slid, slip_path, net_slip, "
     "slid_ahead; "
     "did you mean slip_index?"},
    {"Twice", "solve a.toml --rung paper --rung paper", "--rung = paper: must be given once"},
    {"OneTooMany", "check a.h5 b.h5", "argument = b.h5: must be left out: tactel check takes no more"},
    {"RangeOfNumbers", "monitor --alarm 200", "--alarm = 200: must be a number, 0 to 100"},
    {"Companion", "monitor --source x --network y --widest 1", "--widest: must be left out, or with --alarm"},
    {"UnknownOfANestedCommand", "calibrate bound a.onnx b.h5 --levle 0.9",
     "--levle: must be an option of tactel calibrate bound; did you mean --level?"},
    {"NoNumberOfANestedCommand", "calibrate bound a.onnx b.h5 --level most",
     "--level = most: must be a number, 0.5 to 0.9999"},
    {"RangeOfANestedCommand", "calibrate bound a.onnx b.h5 --level 95",
     "--level = 95: must be a number, 0.5 to 0.9999"},
    {"MissingOfANestedCommand", "calibrate bound a.onnx", "SET.h5 = (missing): must be given"},
    {"NestedCommand", "calibrate bount", "command = bount: must be one of bound; did you mean bound?"},
    {"NoNestedCommand", "calibrate", "command = (missing): must be one of bound"},
    {"OptionForACommand", "calibrate --html a.html",
     "command = --html: must be one of bound; options and files stand behind it"},
    {"ControlCharacters", "train --scaling a\x1b[31m\n", "--scaling = a [31m : must be one of set, frame, rest"}};
INSTANTIATE_TEST_SUITE_P(All, WrongOptionTest, testing::ValuesIn(wrong_calls),
                         [](const auto& info) { return info.param.name; });

TEST(OptionErrors, AMovedCommandSaysWhereItIs) {
  for (const auto& [arguments, moved] : {std::pair<std::string, std::string>{"floor a.toml", "floor"},
                                         {"calibrate sensor a.toml --profile b.toml", "calibrate sensor"}}) {
    const ChildResult result = run_tactel(words(arguments));
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.err, fmt::format("error: command line: command = {0}: belongs to the Python package; python -m "
                                      "tactel.{0}\n",
                                      moved));
  }
}

TEST(OptionErrors, AnOptionOfAlarmsNeedsTheirDecision) {
  for (const std::string option : {"--rate", "--touch", "--widest"})
    EXPECT_THAT(run_tactel({"recall", "a", "b.h5", option, "1"}).err,
                testing::StartsWith("error: command line: " + option + ": must be left out, or with --decision\n"));
}

}  // namespace tactel::host::option_errors_test
