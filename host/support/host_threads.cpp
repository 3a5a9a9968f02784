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

bool shows_processors(const std::filesystem::path& sys) {
  namespace fs = std::filesystem;
  std::error_code error;
  bool cpus = false, nodes = true;
  for (const char* folder : {"bus/cpu/devices", "devices/system/cpu"})
    cpus = cpus || fs::exists(sys / folder / "cpu0/topology", error);
  for (const char* folder : {"bus/node/devices", "devices/system/node"}) {
    if (!fs::exists(sys / folder, error)) continue;  // a kernel without them
    bool any = false;
    for (const auto& entry : fs::directory_iterator(sys / folder, error))
      any = any || (entry.path().filename().native().starts_with("node") && entry.exists(error));
    nodes = nodes && any;
  }
  return cpus && nodes;
}

}  // namespace tactel::host
