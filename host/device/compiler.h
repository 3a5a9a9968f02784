// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "host/device/device.h"

namespace tactel::host {

/// Words that start a process of this program that calls compile_for_parent() with the two words behind them: kernels
/// are then compiled in that process. It may die there, for want of memory: an error says so, and this process never
/// calls a compiler. A library has no program of its own and compiles in its process. Call it before the first device.
void set_compiler(std::vector<std::string> words);

/// Compiles kernels for the process that started this one, until that ends or asks for nothing for some seconds. The
/// folders: CompileCache's. Returns the exit code.
int compile_for_parent(const std::filesystem::path& folder, const std::filesystem::path& own);

}  // namespace tactel::host
