// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <stdlib.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/support/child_process.h"
#include "test_paths.h"

namespace tactel::host {

/// Runs the program as a user would.
inline ChildResult run_tactel(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), TACTEL_PROGRAM);
  return run_child(arguments);
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

/// While it lives, the programs that run_tactel starts keep their caches apart from those of all others.
class OwnCache {
 public:
  OwnCache() {
    if (const char* shared = std::getenv(name)) shared_ = shared;
    ::setenv(name, (folder_ / "").c_str(), 1);
  }
  ~OwnCache() { shared_.empty() ? ::unsetenv(name) : ::setenv(name, shared_.c_str(), 1); }
  OwnCache(const OwnCache&) = delete;
  OwnCache& operator=(const OwnCache&) = delete;

 private:
  static constexpr const char* name = "TACTEL_CACHE_DIR";
  const ScratchFolder folder_;
  std::string shared_;
};

inline std::string source_file(const std::string& name) { return std::string(TACTEL_SOURCE_DIR) + "/" + name; }

}  // namespace tactel::host
