// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace tactel::host {

inline constexpr int most_host_threads = 1024;

/// Returns the number of threads for work on the host: $TACTEL_THREADS, else one a core of the machine. Throws
/// ConfigError where the variable is not a whole number from 1 to most_host_threads.
int host_threads();

}  // namespace tactel::host
