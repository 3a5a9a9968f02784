// SPDX-License-Identifier: Apache-2.0
#include "host/support/host_limits.h"

#include <fmt/format.h>
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
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

namespace {

constexpr std::size_t unlimited = std::numeric_limits<std::size_t>::max();
constexpr std::size_t enough = std::size_t{2} << 30;
constexpr std::size_t usual_stack = std::size_t{8} << 20;
constexpr std::size_t arena = std::size_t{64} << 20;  // that the C library's allocator takes for a thread

std::size_t limit_of(__rlimit_resource_t resource) {
  rlimit limit{};
  return ::getrlimit(resource, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY ? unlimited : limit.rlim_cur;
}

}  // namespace

std::size_t address_space_left() {
  const std::size_t limit = limit_of(RLIMIT_AS);
  if (limit == unlimited) return unlimited;
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return limit - std::min(limit, pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)));
}

std::size_t stack_size() {
  const std::size_t limit = limit_of(RLIMIT_STACK);
  return limit == unlimited ? usual_stack : limit;
}

int most_threads() {
  const std::size_t limit = limit_of(RLIMIT_AS);
  return limit == unlimited ? INT_MAX
                            : static_cast<int>(std::clamp<std::size_t>(limit / 2 / (stack_size() + arena), 1, INT_MAX));
}

std::string address_space_advice() {
  const std::size_t limit = limit_of(RLIMIT_AS);
  if (limit >= enough) return "";
  return fmt::format("the address space is limited to {} MB; allow {} MB (ulimit -v {}) or more", limit >> 20,
                     enough >> 20, enough >> 10);
}

void keep_freed_memory([[maybe_unused]] int most) {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 1 << 25);  // bytes, the most that the library takes
  mallopt(M_TRIM_THRESHOLD, most);
#endif
}

}  // namespace tactel::host
