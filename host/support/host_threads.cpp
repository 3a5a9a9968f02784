// SPDX-License-Identifier: Apache-2.0
#include "host/support/host_threads.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>

#include "host/support/errors.h"

namespace tactel::host {

int host_threads() {
  const char* text = std::getenv("TACTEL_THREADS");
  if (!text || !*text) return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  int threads = 0;
  const char* end = text + std::strlen(text);
  const auto [stop, error] = std::from_chars(text, end, threads);
  if (error != std::errc{} || stop != end || threads < 1 || threads > most_host_threads)
    throw ConfigError("", "TACTEL_THREADS", text, "a whole number from 1 to " + std::to_string(most_host_threads));
  return threads;
}

}  // namespace tactel::host
