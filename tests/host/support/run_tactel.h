// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gtest/gtest.h>

#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "host/support/child_process.h"
#include "test_paths.h"
#include "tests/scratch.h"

namespace tactel::host {

using tactel::Environment;
using tactel::ScratchFolder;
using tactel::text_of;

/// Runs the program as a user would, with these arguments and then `more`.
inline ChildResult run_tactel(const std::vector<std::string>& arguments, const std::vector<std::string>& more = {}) {
  std::vector<std::string> command{TACTEL_PROGRAM};
  command.insert(command.end(), arguments.begin(), arguments.end());
  command.insert(command.end(), more.begin(), more.end());
  return run_child(command);
}

/// The words of a line, which spaces separate.
inline std::vector<std::string> words(const std::string& line) {
  std::vector<std::string> all;
  std::istringstream in(line);
  for (std::string word; std::getline(in, word, ' ');) all.push_back(word);
  return all;
}

/// A call that the program refuses, as a row of a table.
struct WrongCall {
  std::string name;       ///< of the test
  std::string arguments;  ///< separated by spaces
  std::string says;       ///< a part of the message
  friend void PrintTo(const WrongCall& call, std::ostream* out) { *out << call.name; }
};

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

/// While it lives, the programs that run_tactel starts keep their caches apart from those of all others: also of this
/// process, which names PoCL's to its children once it has opened a device.
class OwnCache {
  const ScratchFolder folder_;
  const Environment ours_{"TACTEL_CACHE_DIR", (folder_ / "").string()}, of_pocl_{"POCL_CACHE_DIR", std::nullopt};
};

inline std::string source_file(const std::string& name) { return std::string(TACTEL_SOURCE_DIR) + "/" + name; }

}  // namespace tactel::host
