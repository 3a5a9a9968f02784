// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

namespace tactel::host {

struct ChildResult {
  int exit_code = 0;  ///< 127: the program was not found; 128 + n: ended by signal n
  std::string out, err;
};

/// Runs a program of the PATH with arguments, without a shell, and waits for it. Standard input is empty.
ChildResult run_child(const std::vector<std::string>& command);

/// Runs the program at a path with the standard streams of this one; words[0] is the name that it sees. Returns its
/// exit code as in ChildResult. Throws std::runtime_error where it cannot be started.
int run_attached(const std::string& path, const std::vector<std::string>& words);

/// Returns true where the PATH holds an executable of this name.
bool program_exists(const std::string& name);

}  // namespace tactel::host
