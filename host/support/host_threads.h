// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

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

}  // namespace tactel::host
