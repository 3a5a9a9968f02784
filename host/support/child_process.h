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

/// Returns true where the PATH holds an executable of this name.
bool program_exists(const std::string& name);

}  // namespace tactel::host
