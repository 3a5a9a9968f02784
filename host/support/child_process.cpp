// SPDX-License-Identifier: Apache-2.0
#include "host/support/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <stdexcept>

#include "host/support/interrupt.h"
#include "hw/descriptor.h"

extern char** environ;

namespace tactel::host {
namespace {

struct Pipe {
  hw::Descriptor read, write;
  Pipe() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error(std::string("pipe: ") + std::strerror(errno));
    read = hw::Descriptor(ends[0]), write = hw::Descriptor(ends[1]);
  }
};

/// The words as posix_spawn takes them.
std::vector<char*> pointers(const std::vector<std::string>& words) {
  std::vector<char*> all;
  all.reserve(words.size() + 1);
  for (const std::string& word : words) all.push_back(const_cast<char*>(word.c_str()));
  all.push_back(nullptr);
  return all;
}

/// Starts the program; 0 on success, else an error number.
int spawn(const std::vector<std::string>& command, const Pipe& out, const Pipe& err, pid_t& child) {
  const std::vector<char*> arguments = pointers(command);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, out.write, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err.write, STDERR_FILENO);
  const int error = posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

/// Reads both pipes as they fill, until both are closed: a child that fills one never waits for the other.
void drain(const Pipe& out, const Pipe& err, ChildResult& result) {
  std::array<pollfd, 2> waiting{pollfd{out.read, POLLIN, 0}, pollfd{err.read, POLLIN, 0}};
  std::array<std::string*, 2> texts{&result.out, &result.err};
  std::array<char, 4096> buffer;
  while (waiting[0].fd >= 0 || waiting[1].fd >= 0) {
    if (::poll(waiting.data(), waiting.size(), -1) < 0 && errno != EINTR) return;
    for (std::size_t i = 0; i < waiting.size(); ++i) {
      if (waiting[i].fd < 0 || waiting[i].revents == 0) continue;
      const ssize_t count = ::read(waiting[i].fd, buffer.data(), buffer.size());
      if (count > 0) texts[i]->append(buffer.data(), static_cast<std::size_t>(count));
      if (count == 0 || (count < 0 && errno != EINTR)) waiting[i].fd = -1;  // poll skips negative ones
    }
  }
}

/// The exit code of a child that has ended, as in ChildResult.
int exit_code(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

int wait_for(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return exit_code(status);
}

}  // namespace

ChildResult run_child(const std::vector<std::string>& command) {
  ChildResult result;
  Pipe out, err;
  pid_t child = -1;
  if (const int error = spawn(command, out, err, child); error != 0) {
    return {.exit_code = 127, .out = "", .err = command.front() + ": " + std::strerror(error)};
  }
  out.write.close();
  err.write.close();
  drain(out, err, result);
  result.exit_code = wait_for(child);
  return result;
}

int run_attached(const std::string& path, const std::vector<std::string>& words) {
  pid_t child = -1;
  if (const int error = ::posix_spawn(&child, path.c_str(), nullptr, nullptr, pointers(words).data(), environ);
      error != 0)
    throw std::runtime_error(path + ": " + std::strerror(error));
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR)
    if (Interrupt::seen()) ::kill(child, SIGTERM);  // the signal may have been for this process alone
  return exit_code(status);
}

bool program_exists(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (::access((std::filesystem::path(folder) / name).c_str(), X_OK) == 0) return true;
  }
  return false;
}

}  // namespace tactel::host
