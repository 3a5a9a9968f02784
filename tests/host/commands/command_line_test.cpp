// SPDX-License-Identifier: Apache-2.0

// What every command shares: standard streams that fail, help, numbers that are none, and messages about words.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "tests/host/commands/small_sweep.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::command_line_test {

using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;

const std::string parabola = source_file("examples/parabola.toml");

ChildResult shell(const std::string& line) { return run_child({"sh", "-c", line}); }

// An error ends with its own code, whatever becomes of its message: closed, full, closed by its reader.
TEST(StandardError, ThatTakesNothingChangesNoExitCode) {
  for (const char* stream : {"2>&-", "2>/dev/full", "2>&1 >/dev/null | true; exit ${PIPESTATUS[0]}"}) {
    const std::string line = std::string(TACTEL_PROGRAM) + " solve /no/such/scene.toml " + stream;
    EXPECT_EQ(run_child({"bash", "-c", "trap '' PIPE; " + line}).exit_code, 2) << stream;
  }
}

// The scene's warning of its depth cannot be shown: the answer is there, and good.
TEST(StandardError, AWarningThatCannotBeShownEndsNoRun) {
  const ScratchFolder folder;
  const std::string deep = folder.write("deep.toml",
                                        "[indenter]\nshape = \"parabola\"\nradius = 10\n[contact]\nfriction = 0.5\n"
                                        "[load]\nindentation = 0.4\n");
  const std::string run = std::string(TACTEL_PROGRAM) + " solve --solver reference " + deep;
  ASSERT_THAT(shell(run).err, HasSubstr("warning"));
  const ChildResult full = shell(run + " 2>/dev/full");
  EXPECT_EQ(full.exit_code, 0);
  EXPECT_EQ(full.out, shell(run).out);
}

// The set is the first file that is opened. With standard error closed it would get number 2, and all messages.
TEST(StandardError, AFileNeverTakesItsPlace) {
  const ScratchFolder folder;
  const std::string answer = folder / "a.json", whole = folder / "b.json";
  const std::string run = std::string(TACTEL_PROGRAM) + " solve --solver reference " + parabola + " --json ";
  EXPECT_EQ(shell(run + answer + " 2>&- </dev/null >/dev/null").exit_code, 0);
  EXPECT_EQ(shell(run + whole).exit_code, 0);
  EXPECT_EQ(text_of(answer), text_of(whole));
}

TEST(StandardOutput, ThatTakesNotAllIsAnError) {
  for (const std::string& command :
       {"solve --solver reference " + parabola, "solve --solver reference --json - " + parabola, std::string("devices"),
        std::string("devices --json"), std::string("--help"), std::string("--version")}) {
    const ChildResult full = shell(std::string(TACTEL_PROGRAM) + " " + command + " >/dev/full");
    EXPECT_EQ(full.exit_code, 2) << command;
    EXPECT_THAT(full.err, AllOf(HasSubstr("standard output"),
                                AnyOf(HasSubstr("No space left on device"), HasSubstr("a write failed"))))
        << command;
    EXPECT_EQ(shell(std::string(TACTEL_PROGRAM) + " " + command + " >&-").exit_code, 2) << command;
  }
}

std::vector<std::string> every_command() {
  return {"solve",  "generate", "check",     "train",    "recall",   "calibrate bound", "monitor",
          "record", "tare",     "reproduce", "tradeoff", "extremes", "devices",         "demo"};
}

ChildResult help_of(const std::string& command) {
  return shell(std::string(TACTEL_PROGRAM) + " " + command + " --help");
}

TEST(Help, FitsSeventyNineColumnsInWordsOfOurOwn) {
  const std::string all = run_tactel({"--help"}).out;
  std::vector<std::string> commands = every_command();
  commands.emplace_back();
  for (const std::string& command : commands) {
    EXPECT_THAT(all, HasSubstr("  " + command.substr(0, command.find(' '))));
    const ChildResult result = help_of(command);
    EXPECT_EQ(result.exit_code, 0);
    std::istringstream lines(result.out);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 79u) << command << ": " << line;
    for (const char* notation : {"TEXT:", "FLOAT", "UINT", "POSITIVE", "Excludes", ":{", " in ["})
      EXPECT_THAT(result.out, Not(HasSubstr(notation))) << command;
  }
  EXPECT_THAT(run_tactel({"solve", "--help"}).out,
              AllOf(HasSubstr("--precision fp32|fp64"), HasSubstr("--solver batched|full-mesh|twin"),
                    HasSubstr("(default: batched)")));
  EXPECT_THAT(run_tactel({"generate", "--help"}).out, HasSubstr("(required)"));
}

// Its files and options are those of the command: the examples of examples/ are there, every option is one of the help.
TEST(Help, EndsWithAnExample) {
  for (const std::string& command : every_command()) {
    const std::string help = help_of(command).out;
    const std::size_t at = help.find("\nExamples:\n  tactel " + command);
    ASSERT_NE(at, std::string::npos) << help;
    std::istringstream words(help.substr(at + 12, help.find('\n', at + 12) - at - 12));
    for (std::string word; words >> word;) {
      if (word.starts_with("--")) {
        EXPECT_THAT(help.substr(0, at), HasSubstr("  " + word)) << command;
      }
      if (word.starts_with("examples/")) {
        EXPECT_TRUE(std::filesystem::exists(source_file(word))) << word;
      }
    }
  }
}

TEST(Help, GroupsTheCommandsByPurpose) {
  const std::string help = run_tactel({"--help"}).out;
  std::size_t at = 0;
  for (const char* word : {"\nSimulate:\n", "  solve ", "  generate ", "\nLearn:\n", "  train ", "\nRead a sensor:\n",
                           "  monitor ", "\nVerify:\n", "  tradeoff ", "\nSet up:\n", "  devices "}) {
    const std::size_t found = help.find(word, at);
    ASSERT_NE(found, std::string::npos) << word << " after\n" << help.substr(0, at);
    at = found;
  }
}

/// The output of a command whose standard streams are a terminal (a pseudo-terminal of `script`).
std::string on_terminal(const std::string& environment, const std::string& arguments) {
  return shell("TERM=xterm " + environment + " script -qec '" + std::string(TACTEL_PROGRAM) + " " + arguments +
               "' /dev/null </dev/null")
      .out;
}

TEST(Colour, IsForTerminalsAloneAndForUsersWhoWantIt) {
  const std::string escape = "\x1b[";
  EXPECT_THAT(on_terminal("", "solve /no/such.toml"), HasSubstr("\x1b[1;31merror:\x1b[0m"));
  EXPECT_THAT(on_terminal("NO_COLOR=1", "solve /no/such.toml"), AllOf(HasSubstr("error:"), Not(HasSubstr(escape))));
  EXPECT_THAT(on_terminal("NO_COLOR=", "solve /no/such.toml"), HasSubstr(escape)) << "empty is unset (no-color.org)";
  EXPECT_THAT(shell("TERM=xterm " + std::string(TACTEL_PROGRAM) + " solve /no/such.toml").err, Not(HasSubstr(escape)));
}

/// What bash offers for the last of these words.
std::string completed(const std::string& words, int last) {
  return run_child({"bash", "-c",
                    fmt::format("cd '{}'; source scripts/completion.bash; COMP_WORDS=({} {}); COMP_CWORD={}; _tactel; "
                                "echo \"${{COMPREPLY[@]}}\"",
                                TACTEL_SOURCE_DIR, TACTEL_PROGRAM, words, last)})
      .out;
}

TEST(Completion, KnowsCommandsOptionsValuesAndFiles) {
  EXPECT_EQ(completed("re", 1), "recall record reproduce\n");
  EXPECT_EQ(completed("solve --pr", 2), "--precision\n");
  EXPECT_EQ(completed("solve --precision ''", 3), "fp32 fp64\n");
  EXPECT_EQ(completed("help ta", 2), "tare\n");
  EXPECT_EQ(completed("solve examples/par", 2), "examples/parabola.toml\n");
  EXPECT_EQ(completed("solve examples/measured", 2), "examples/measured.toml\n") << "not measured.csv";
  EXPECT_EQ(completed("solve --tolerance ''", 3), "\n") << "only the user knows a number";
  EXPECT_EQ(completed("recall exa", 2), "examples\n") << "a directory of networks";
  EXPECT_EQ(completed("recall networks host/sets", 3), "host/sets\n");
}

TEST(Completion, OffersTheRungsOfTheProgram) {
  const std::string refusal = run_tactel({"generate", "--rung", "?"}).err;
  std::istringstream lines(completed("solve --rung ''", 3));
  std::size_t rungs = 0;
  for (std::string rung; lines >> rung; ++rungs) EXPECT_THAT(refusal, HasSubstr(" " + rung));
  EXPECT_GT(rungs, 9u);
  EXPECT_EQ(completed("solve --rung mesh-32", 3), "mesh-321\n");
  EXPECT_EQ(completed("train --rung patch-1", 3), "patch-12 patch-16\n");
}

// bash takes = and : for words of their own.
TEST(Completion, GoesOnBehindEqualSignsAndColons) {
  EXPECT_EQ(completed("solve --precision =", 3), "fp32 fp64\n");
  EXPECT_EQ(completed("solve --precision = fp3", 4), "fp32\n");
  EXPECT_EQ(completed("monitor --source s", 3), "simulate:\n");
  EXPECT_EQ(completed("monitor --source simulate : examples/par", 5), "examples/parabola.toml\n");
  EXPECT_EQ(completed("monitor --source csv : examples/measured.c", 5), "examples/measured.csv\n");
}

TEST(Completion, GoesOnAfterAnOptionWithoutValue) {
  EXPECT_EQ(completed("solve --converge examples/par", 3), "examples/parabola.toml\n");
  EXPECT_EQ(completed("solve --quiet --pr", 3), "--precision\n");
}

TEST(Completion, KnowsTheCommandsOfACommand) {
  EXPECT_EQ(completed("calibrate ''", 2), "bound\n");
  EXPECT_EQ(completed("help calibrate bo", 3), "bound\n");
  EXPECT_EQ(completed("calibrate bound --le", 3), "--level\n");
}

// Each option that a help shows is offered.
TEST(Completion, OffersEveryOption) {
  std::istringstream lines(run_tactel({"train", "--help"}).out), words(completed("train --", 2));
  const std::set<std::string> offered{std::istream_iterator<std::string>(words), {}};
  std::size_t options = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("  --")) continue;
    ++options;
    EXPECT_TRUE(offered.contains(line.substr(2, line.find_first_of(" ,", 2) - 2))) << line;
  }
  EXPECT_GT(options, 20u);
}

TEST(Help, ShowsTypesWhole) {
  EXPECT_THAT(run_tactel({"train", "--help"}).out, HasSubstr("--history K[:STRIDE] "));
  for (const std::string command : {"solve", "generate", "check", "train", "recall", "monitor", "record", "tare"}) {
    const std::string help = run_tactel({command, "--help"}).out;
    EXPECT_EQ(std::ranges::count(help, '['), std::ranges::count(help, ']')) << help;
    EXPECT_EQ(std::ranges::count(help, '{'), std::ranges::count(help, '}')) << help;
  }
}

TEST(Help, IsFoundByAnyOfItsNames) {
  const std::string help = run_tactel({"--help"}).out;
  EXPECT_EQ(run_tactel({"help"}).out, help);
  EXPECT_EQ(run_tactel({"help", "solve"}).out, run_tactel({"solve", "--help"}).out);
  EXPECT_EQ(run_tactel({"-V"}).out, run_tactel({"--version"}).out);
  const ChildResult nothing = run_tactel({});
  EXPECT_EQ(nothing.exit_code, 2);
  EXPECT_EQ(nothing.err, help);
}

// The same option stands in the same group of every command, and no group is a heap of the rest.
TEST(Help, ListsOptionsInTheSameGroupsEverywhere) {
  const std::set<std::string> known = {"Input", "Output",   "Network", "Learning",
                                       "Alarm", "Accuracy", "Device",  "Other"};
  std::map<std::string, std::set<std::string>> groups;  // of an option
  for (const std::string& command : every_command()) {
    std::istringstream lines(help_of(command).out);
    std::string group;
    for (std::string line; std::getline(lines, line);) {
      if (!line.empty() && line[0] != ' ' && line.back() == ':') group = line.substr(0, line.size() - 1);
      if (!line.starts_with("  -")) continue;
      EXPECT_TRUE(known.contains(group)) << command << ": " << line;
      groups[line.substr(2, line.find_first_of(" ,", 2) - 2)].insert(group);
    }
  }
  EXPECT_GT(groups.size(), 70u);
  for (const auto& [option, found] : groups) {
    const bool of_two_meanings = option == "--rows";
    EXPECT_EQ(found.size(), of_two_meanings ? 2u : 1u) << option;
    EXPECT_EQ(found.contains("Other"), option == "--quiet" || option == "-h") << option << " needs a group";
  }
}

// fp32 is generate's default, fp64 solve's.
TEST(Help, SaysTheTruthAboutPrecision) {
  const auto precision_line = [](const std::string& command) {
    const std::string text = run_tactel({command, "--help"}).out;
    std::string words;
    for (const char c : text.substr(text.find("--precision"), 300))
      if (c != ' ' && c != '\n') words += c;
    return words;
  };
  EXPECT_THAT(precision_line("generate"), HasSubstr("(default:fp32"));
  EXPECT_THAT(precision_line("solve"), HasSubstr("(default:fp64"));
}

TEST(Words, AFileOfTheOtherKindNamesTheOtherCommand) {
  EXPECT_TRUE(is_refused(run_tactel({"solve", source_file("examples/random_sweep.toml")}), {"tactel generate"}));
  const ScratchFolder folder;
  EXPECT_TRUE(is_refused(run_tactel({"generate", parabola, "--output", (folder / "a.h5").string()}), {"tactel solve"}));
}

TEST(Numbers, NanAndInfinityAreRefusedByEveryOption) {
  const std::vector<std::vector<std::string>> calls = {
      {"solve", parabola, "--accuracy"},
      {"solve", parabola, "--tolerance"},
      {"solve", parabola, "--step"},
      {"generate", parabola, "--output", "/tmp/x.h5", "--accuracy"},
      {"train", "/no/set.h5", "--output", "/tmp/x", "--noise"},
      {"train", "/no/set.h5", "--output", "/tmp/x", "--learning-rate"},
      {"train", "/no/set.h5", "--output", "/tmp/x", "--checkpoint-seconds"},
      {"tradeoff", "--scenes"},
      {"monitor", "--source", "x", "--network", "y", "--seconds"},
      {"monitor", "--source", "x", "--network", "y", "--late"},
      {"record", "--source", "x", "--output", "/tmp/x", "--seconds"},
      {"tare", "--source", "x", "--output", "/tmp/x", "--seconds"}};
  for (std::vector<std::string> call : calls) {
    call.emplace_back();
    for (const std::string value : {"nan", "inf", "NAN", "infinity", "nan(1)"}) {
      call.back() = value;
      EXPECT_TRUE(is_refused(run_tactel(call), {call[call.size() - 2]}));
    }
  }
}

// A 0 in front is not read as an octal number, in which 010 is 8.
TEST(Numbers, OfOtherBasesAreRefused) {
  for (const char* value : {"010", "0x10"})
    EXPECT_TRUE(is_refused(run_tactel({"monitor", "--source", "x", "--network", "y", "--every", value}),
                           {"--every = " + std::string(value), "decimal"}));
  EXPECT_TRUE(is_refused(run_tactel({"solve", "none.toml", "--tolerance", "0.001"}), {"none.toml"}));
}

// 2001 x 1001 nodes within 1 GB: no memory, which is the input's fault.
TEST(Memory, ThatIsNotThereIsSaidInWordsOfTheInput) {
  const ScratchFolder folder;
  const std::string scene = folder.write("huge.toml",
                                         "[sensor]\ncolumns = 2001\nrows = 1001\n[indenter]\nshape = \"parabola\"\n"
                                         "radius = 10\n[load]\nindentation = 0.1\n");
  const ChildResult result =
      shell("ulimit -v 600000; exec " + std::string(TACTEL_PROGRAM) + " solve --solver reference " + scene);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, AllOf(HasSubstr("error: not enough memory"), Not(HasSubstr("bad_alloc"))));
}

// A key of 50 000 parts would overflow the stack in the parser, a device would never end.
TEST(HostileFiles, EndWithTwo) {
  const ScratchFolder folder;
  const auto refused = [&](const std::string& text) {
    EXPECT_TRUE(is_refused(run_tactel({"solve", folder.write("hostile.toml", text)}), {"at most 16"}));
  };
  const auto repeated = [](std::string before, const std::string& part, int count) {
    for (int i = 0; i < count; ++i) before += part;
    return before;
  };
  refused(repeated("", "a.", 50000) + "a = 1\n");
  refused(repeated("[", "a.", 50000) + "a]\n");
  refused(repeated("\"a\"", ".\"a.b\"", 20) + " = 1\n");
  refused(repeated(repeated("a = ", "[", 50000), "]", 50000) + "\n");
  refused(repeated(repeated("a = ", "{a = ", 200) + "1", "}", 200) + "\n");
  EXPECT_TRUE(
      is_refused(run_child({"timeout", "20", "sh", "-c", "ulimit -v 2000000; exec " TACTEL_PROGRAM " solve /dev/zero"}),
                 {"it is no regular file"}));
}

// Every reader of a file ends at once where the name is that of a pipe that nothing writes to.
TEST(HostilePipe, APipeWithoutAWriterIsRefusedByEveryReader) {
  const ScratchFolder folder;
  const std::string pipe = (folder / "pipe").string(), net = (folder / "net").string(), set = folder / "set.h5";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const std::string profile =
      folder.write("profile.toml", "[indenter]\nshape = \"profile\"\nfile = \"pipe\"\n[load]\nindentation = 0.1\n");
  const std::string sweep = folder.write("sweep.toml", SmallSweep{.contacts = 50}.text());
  ASSERT_EQ(run_tactel({"generate", sweep, "--output", set, "--quiet"}).exit_code, 0);
  for (const char* name : {"report", "checkpoint", "model"}) std::filesystem::create_directories(folder / name);
  std::filesystem::create_symlink(pipe, folder / "report" / "training.json");
  std::filesystem::create_symlink(pipe, folder / "checkpoint" / "checkpoint");
  std::filesystem::create_symlink(pipe, folder / "model" / "a.onnx");
  std::filesystem::create_directories(folder / "b.h5.parts");
  std::filesystem::create_symlink(pipe, folder / "b.h5.parts" / "plan");
  for (const char* name : {"c.h5.parts/0000.chunks", "e.h5.parts/any"}) {
    std::filesystem::create_directories((folder / name).parent_path());
    ASSERT_EQ(::mkfifo((folder / name).c_str(), 0600), 0);
  }
  // A pipe that has no name of ours is nothing to us.
  EXPECT_EQ(shell("exec timeout 30 " TACTEL_PROGRAM " generate " + sweep + " --output " + (folder / "e.h5").string() +
                  " --resume")
                .exit_code,
            0);
  const std::string simulation = "'simulate:" + parabola + "?paced=0'", train = "--network 10-3-1 --cycles 3 --output ";
  for (const std::string& command :
       {"solve " + pipe, "solve " + profile, "generate " + pipe + " --output " + set + " --force",
        "generate " + sweep + " --output " + (folder / "b.h5").string() + " --resume",
        "generate " + sweep + " --output " + (folder / "c.h5").string() + " --resume", "check " + pipe,
        "train " + pipe + " " + train + net, "train " + set + " --resume " + train + (folder / "report").string(),
        "train " + set + " --resume " + train + (folder / "checkpoint").string(), "recall " + pipe + " " + set,
        "recall " + (folder / "model").string() + " " + set, "record --source replay:" + pipe + " --output /dev/null",
        "record --source usb:1234:5678 --profile " + pipe + " --output /dev/null",
        "record --source " + simulation + " --calibration " + pipe + " --output /dev/null"}) {
    const ChildResult result = shell("exec timeout 30 " TACTEL_PROGRAM " " + command);
    EXPECT_EQ(result.exit_code, 2) << command << "\n" << result.err;
  }
}

// A device that cannot open a file would not say so.
TEST(HostileFiles, TooFewOpenFilesAreNamed) {
  for (const char* command : {"solve ", "devices # "}) {
    const ChildResult result =
        shell("ulimit -n 16; exec " TACTEL_PROGRAM " " + std::string(command) + parabola + " </dev/null");
    EXPECT_EQ(result.exit_code, 3) << command;
    EXPECT_THAT(result.err, HasSubstr("Too many open files")) << command;
    EXPECT_THAT(result.err, HasSubstr("ulimit -n")) << command;
  }
}

// PoCL would abort. 20 blocks are 10 kB in dash, 20 in bash.
TEST(HostileFiles, TooSmallFilesAreNamed) {
  const ChildResult result = shell("ulimit -f 20; exec " TACTEL_PROGRAM " solve " + parabola + " </dev/null");
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.err, HasSubstr("File too large"));
  EXPECT_THAT(result.err, HasSubstr("ulimit -f"));
}

// A hundred thousand distributions took five minutes, and a list of as many numbers made as many load steps.
TEST(HostileFiles, LongListsAreRefusedAtOnce) {
  const ScratchFolder folder;
  for (const char* entry : {"0.1, ", "{ uniform = [0.1, 0.2] }, "}) {
    std::string list;
    for (int i = 0; i < 100000; ++i) list += entry;
    const std::string sweep = folder.write("sweep.toml", SmallSweep{.drag = "tangential = [" + list + "0]"}.text());
    EXPECT_TRUE(
        is_refused(run_child({"timeout", "30", TACTEL_PROGRAM, "generate", sweep, "--output", folder / "set.h5"}),
                   {"load.tangential = ", "at most 100000 load steps"}));
  }
}

// Dots and brackets in texts and comments count for nothing.
TEST(HostileFiles, NothingHarmlessIsRefused) {
  const ScratchFolder folder;
  std::string dots(60, '.'), open(60, '[');
  const std::string scene = folder.write(
      "scene.toml", "# " + dots + open + "\ntitle = \"" + dots + open + "\\\"" + open + "\" # " + open + "\n" +
                        "[indenter] # '" + "\nshape = 'parabola'\nradius = 10\n[load]\nindentation = 0.1\n");
  const ChildResult result = run_tactel({"solve", "--solver", "reference", scene});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr(dots));
}

class ProfileFile : public testing::Test {
 protected:
  ChildResult solve(const std::string& file, const std::string& content = "") {
    if (!content.empty()) folder_.write(file, content);
    return run_tactel({"solve", "--solver", "reference",
                       folder_.write("scene.toml", "[indenter]\nshape = \"profile\"\nfile = \"" + file +
                                                       "\"\n[load]\nindentation = 0.1\n")});
  }
  ScratchFolder folder_;
};

TEST_F(ProfileFile, OfADeviceIsRefused) { EXPECT_TRUE(is_refused(solve("/dev/zero"), {"no regular file"})); }

TEST_F(ProfileFile, ThatIsNoProfileIsNotQuoted) {
  for (const std::string secret : {"root:$6$topsecret:19000", "topsecret,word", "topsecret\n", "x,topsecret"}) {
    const ChildResult result = solve("secret.txt", secret);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.err,
                AllOf(HasSubstr("secret.txt:1: "), Not(HasSubstr("topsecret")), HasSubstr("x and y in mm")));
  }
}

// The same profile in every spelling that is taken gives the same table.
TEST_F(ProfileFile, IsReadInTheFormsThatInstrumentsWrite) {
  const ChildResult plain = solve("a.csv", "x,y\n-1.5,0.25\n0,0\n1.5,0.25\n");
  ASSERT_EQ(plain.exit_code, 0) << plain.err;
  for (const std::string content :
       {"-1.5,0.25\n0,0\n1.5,0.25\n", "x [mm],y [mm]\n-1.5,0.25\n0,0\n1.5,0.25\n", "X;Y\n-1.5;0.25\n0;0\n1.5;0.25\n",
        "x (mm);y (mm)\r\n-1,5;0,25\r\n0;0\r\n1,5;0,25\r\n", "x_mm\ty_mm\n-1.5\t0.25\n0\t0\n1.5\t0.25\n"}) {
    const ChildResult other = solve("a.csv", content);
    EXPECT_EQ(other.exit_code, 0) << other.err;
    EXPECT_EQ(other.out, plain.out) << content;
  }
  EXPECT_THAT(solve("a.csv", "x [um],y [um]\n-1500,250\n0,0\n1500,250\n").err, HasSubstr("in mm"));
}

// Of two faults in a table the misspelt key is named, not the key that is missing for it.
TEST(Keys, AMisspeltOneIsNamedBeforeTheOneThatIsMissingForIt) {
  const ScratchFolder folder;
  const auto error = [&](const std::string& text) {
    return run_tactel({"solve", folder.write("scene.toml", text)}).err;
  };
  const std::string load = "[load]\nindentation = 0.1\n", shape = "[indenter]\nshape = \"parabola\"\n";
  EXPECT_THAT(error(shape + "raduis = 10\n" + load),
              AllOf(HasSubstr(":3: indenter.raduis = 10"), HasSubstr("did you mean radius?")));
  EXPECT_THAT(error("[indenter]\nshpe = \"parabola\"\nradius = 10\n" + load),
              AllOf(HasSubstr(":2: indenter.shpe"), HasSubstr("did you mean shape?")));
  EXPECT_THAT(error(shape + "radius = 10\n[load]\nindentaton = 0.1\n"),
              AllOf(HasSubstr(":5: load.indentaton"), HasSubstr("did you mean indentation?")));
  const std::string sweep = folder.write("sweep.toml", "[sweep]\ncontact = 10\n" + shape + "radius = 10\n" + load);
  EXPECT_THAT(run_tactel({"generate", sweep, "--output", (folder / "a.h5").string()}).err,
              AllOf(HasSubstr(":2: sweep.contact = 10"), HasSubstr("did you mean contacts?")));
}

// std::abs of the least int64 is undefined; it passed as 0.
TEST(Keys, TheLeastIntegerIsNoWholeNumberOfUse) {
  const ScratchFolder folder;
  const std::string scene = folder.write("scene.toml",
                                         "[indenter]\nshape = \"parabola\"\nradius = 10\n[load]\nindentation = 0.1\n"
                                         "tangential_step = 0.1\ntangential_steps = -9223372036854775808\n");
  EXPECT_TRUE(is_refused(run_tactel({"solve", "--solver", "reference", scene}),
                         {":7: load.tangential_steps = -9223372036854775808: must be a whole number"}));
}

TEST(Tradeoff, InterruptedEndsAsSuch) {
  const ScratchFolder folder;
  const ChildResult result = run_child({"timeout", "--preserve-status", "-s", "INT", "1", TACTEL_PROGRAM, "tradeoff",
                                        "--scenes", "8", "--output", folder / "report"});
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_THAT(result.err, AllOf(HasSubstr("stopped"), Not(HasSubstr("error"))));
}

}  // namespace tactel::host::command_line_test
