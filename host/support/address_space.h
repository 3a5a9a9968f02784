// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>

namespace tactel::host {

/// Address space, bytes, that OpenCL takes beside a stack for each core, and that its compiler takes.
inline constexpr std::size_t opencl_space = std::size_t{352} << 20, compiler_space = std::size_t{768} << 20;

/// Returns what the limit on this process (ulimit -v) leaves, bytes; the largest number where there is no limit.
std::size_t address_space_left();
/// Returns the address space of a thread's stack, bytes.
std::size_t stack_size();
/// Returns the most threads that leave half of a limited address space to their work.
int most_threads();
/// Returns what to do where the address space is limited to less than 2 GB; else nothing.
std::string address_space_advice();

}  // namespace tactel::host
