// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>

namespace tactel::host {

inline constexpr int most_host_threads = 1024;
/// What to do where a thread or a program cannot be started.
inline constexpr const char* thread_advice =
    "this user may have no more threads and processes: allow more (ulimit -u), or end some";

/// Returns the number of threads for work on the host: $TACTEL_THREADS, else one a core of the machine. Throws
/// ConfigError where the variable is not a whole number from 1 to most_host_threads.
int host_threads();

/// Whether the folder /sys shows processors and memory to programs that look there and abort (hwloc in PoCL). Some
/// containers and chroots hide them.
bool shows_processors(const std::filesystem::path& sys = "/sys");

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

/// Lets the process keep memory that it gives back, up to `most` bytes, for arrays that are taken and freed again and
/// again: the system would clear every page of it anew.
void keep_freed_memory(int most);

}  // namespace tactel::host
