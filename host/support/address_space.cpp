// SPDX-License-Identifier: Apache-2.0
#include "host/support/address_space.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <climits>
#include <fstream>
#include <limits>

namespace tactel::host {
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

}  // namespace tactel::host
