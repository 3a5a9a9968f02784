// SPDX-License-Identifier: Apache-2.0

// The program itself, stopped and killed while it trains: what it writes in the end has the bits of a training that
// nothing disturbed.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "test_paths.h"
#include "tests/host/sets/network_files.h"

extern char** environ;

namespace train_resume_test {

using namespace tactel;
using namespace tactel::host;
using namespace std::chrono_literals;
using tactel::tests::networks_in;
using tactel::tests::PaperSetFiles;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// A run of the program that can be sent signals.
class Running {
 public:
  Running(std::vector<std::string> arguments, const std::string& messages) {
    arguments.insert(arguments.begin(), TACTEL_PROGRAM);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, messages.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (posix_spawn(&pid_, TACTEL_PROGRAM, &actions, nullptr, argv.data(), environ) != 0)
      throw std::runtime_error("cannot start " TACTEL_PROGRAM);
    posix_spawn_file_actions_destroy(&actions);
  }
  bool ended() { return ended_ || (ended_ = waitpid(pid_, &status_, WNOHANG) == pid_); }
  void send(int signal) const { kill(pid_, signal); }
  int wait() {
    if (!ended_) waitpid(pid_, &status_, 0);
    ended_ = true;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
  }

 private:
  pid_t pid_ = 0;
  int status_ = 0;
  bool ended_ = false;
};

struct ResumeCase {
  const char* name;
  std::vector<std::string> options;  ///< a training much longer than the three turns of the test, on any processor
};
void PrintTo(const ResumeCase& c, std::ostream* out) { *out << c.name; }

class TrainResume : public ::testing::TestWithParam<ResumeCase> {
 protected:
  /// `seconds`: between two checkpoints, each of which waits for the disk.
  std::vector<std::string> command(const std::string& directory, bool resume, const char* seconds) const {
    std::vector<std::string> all = {"train", PaperSetFiles::learning(), "--output", folder_ / directory};
    for (const std::string& option : GetParam().options)
      all.push_back(option == "RECALL" ? PaperSetFiles::recall() : option);
    for (const char* option : {"--stop-error", "0", "--checkpoint-seconds", seconds}) all.push_back(option);
    if (resume) all.push_back("--resume");
    return all;
  }
  /// Waits until the program has kept something new, then a little longer; false when it ended before.
  bool wait_for_progress(Running& program, const fs::path& checkpoint, std::chrono::milliseconds more) const {
    std::error_code none;
    const auto before = fs::last_write_time(checkpoint, none);
    while (!program.ended() && (!fs::exists(checkpoint) || fs::last_write_time(checkpoint, none) == before))
      std::this_thread::sleep_for(5ms);
    std::this_thread::sleep_for(more);
    return !program.ended();
  }

  ScratchFolder folder_;
  std::mt19937 random_{std::random_device{}()};  // the outcome must not depend on when the signals come
};

TEST_P(TrainResume, ToTheSameBitsAfterCtrlCAndKills) {
  const std::string messages = folder_ / "messages";
  const fs::path stopped = folder_ / "stopped";
  Running first(command("stopped", false, "0"), messages);
  ASSERT_TRUE(wait_for_progress(first, stopped / "checkpoint", 0ms));
  first.send(SIGINT);
  EXPECT_EQ(first.wait(), 130);
  EXPECT_THAT(text_of(messages), HasSubstr("--resume continues from"));
  EXPECT_TRUE(networks_in(stopped).empty());
  int kills = 0;
  for (int turn = 0; turn < 3; ++turn) {
    Running program(command("stopped", true, "0"), messages);
    const std::chrono::milliseconds more(std::uniform_int_distribution(0, 50)(random_));
    if (wait_for_progress(program, stopped / "checkpoint", more)) {
      program.send(SIGKILL);
      kills += program.wait() == 128 + SIGKILL;
    }
  }
  EXPECT_GE(kills, 1);
  EXPECT_EQ(run_tactel(command("stopped", true, "10")).exit_code, 0);
  EXPECT_EQ(run_tactel(command("whole", false, "10")).exit_code, 0);
  EXPECT_EQ(networks_in(stopped), networks_in(folder_ / "whole"));
  for (const auto& entry : fs::directory_iterator(stopped))
    EXPECT_THAT(entry.path().filename().string(), ::testing::Not(HasSubstr("checkpoint")));
}

INSTANTIATE_TEST_SUITE_P(Schedules, TrainResume,
                         ::testing::Values(ResumeCase{"Online",
                                                      {"--network", "6", "--network", "1", "--seeds", "2", "--noise",
                                                       "0.1", "--cycles", "2400"}},
                                           ResumeCase{"SmallBatches",
                                                      {"--network", "6", "--network", "1", "--noise", "0", "--noise",
                                                       "0.1", "--schedule", "batch", "--epochs", "6000"}},
                                           ResumeCase{"LargeBatches",
                                                      {"--network", "6", "--schedule", "batch", "--batch", "200",
                                                       "--optimizer", "delta", "--epochs", "12000"}},
                                           ResumeCase{"Cosine",
                                                      {"--network", "6", "--schedule", "cosine", "--batch", "32",
                                                       "--loss", "absolute", "--average", "0.99", "--validation",
                                                       "RECALL", "--patience", "4500", "--epochs", "5000"}}),
                         [](const auto& info) { return info.param.name; });

}  // namespace train_resume_test
