// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/support/child_process.h"
#include "test_paths.h"

namespace tactel::host {

/// Runs the program as a user would.
inline ChildResult run_tactel(const std::vector<std::string>& arguments) {
  std::vector<std::string> command{TACTEL_PROGRAM};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return run_child(command);
}

/// Whether a run ended with this exit code and a message that holds all of `says`.
inline ::testing::AssertionResult is_refused(const ChildResult& result, const std::vector<std::string>& says,
                                             int exit_code = 2) {
  if (result.exit_code != exit_code)
    return ::testing::AssertionFailure() << "exit code " << result.exit_code << "\n" << result.out << result.err;
  for (const std::string& text : says)
    if (result.err.find(text) == std::string::npos)
      return ::testing::AssertionFailure() << '"' << text << "\" is not in\n" << result.err;
  return ::testing::AssertionSuccess();
}

/// What the program said on stderr but how far it is, which it says when a job takes longer than a second.
inline std::string without_progress(const std::string& err) {
  std::string rest;
  std::istringstream lines(err);
  for (std::string line; std::getline(lines, line);)
    if (!line.ends_with(" ...") && !line.ends_with(" left") && !line.ends_with(" %")) rest += line + "\n";
  return rest;
}

inline std::string text_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// A folder that is gone after the test.
class ScratchFolder {
 public:
  ScratchFolder() : path_((std::filesystem::temp_directory_path() / "tactel-test-XXXXXX").string()) {
    if (::mkdtemp(path_.data()) == nullptr) throw std::runtime_error("no folder " + path_);
  }
  ~ScratchFolder() { std::filesystem::remove_all(path_); }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return std::filesystem::path(path_) / name; }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(*this / name, std::ios::binary) << text;
    return (*this / name).string();
  }
  std::size_t files() const {
    const std::filesystem::directory_iterator all(path_);
    return static_cast<std::size_t>(std::distance(begin(all), end(all)));
  }

 private:
  std::string path_;
};

/// While it lives, an environment variable has another value, or none.
class Environment {
 public:
  Environment(std::string name, const std::optional<std::string>& value) : name_(std::move(name)) {
    if (const char* before = std::getenv(name_.c_str())) before_ = before;
    set(value);
  }
  ~Environment() { set(before_); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  void set(const std::optional<std::string>& value) {
    value ? ::setenv(name_.c_str(), value->c_str(), 1) : ::unsetenv(name_.c_str());
  }

  std::string name_;
  std::optional<std::string> before_;
};

/// While it lives, the programs that run_tactel starts keep their caches apart from those of all others: also of this
/// process, which names PoCL's to its children once it has opened a device.
class OwnCache {
  const ScratchFolder folder_;
  const Environment ours_{"TACTEL_CACHE_DIR", (folder_ / "").string()}, of_pocl_{"POCL_CACHE_DIR", std::nullopt};
};

inline std::string source_file(const std::string& name) { return std::string(TACTEL_SOURCE_DIR) + "/" + name; }

}  // namespace tactel::host
