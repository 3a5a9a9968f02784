// SPDX-License-Identifier: Apache-2.0
#include "host/support/side_by_side.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "host/support/stop_scope.h"

namespace tactel::host {

void side_by_side(std::size_t count, int threads, const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next = 0;
  std::mutex mutex;
  std::exception_ptr error;
  const auto work_on = [&, asked = StopScope::current()] {
    const StopScope scope(asked);
    try {
      for (std::size_t k = next++; k < count; k = next++) StopScope::check(), work(k);
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!error) error = std::current_exception();
      next = count;
    }
  };
  {
    std::vector<std::jthread> team;
    try {
      for (std::size_t i = 1; i < std::min(count, static_cast<std::size_t>(std::max(threads, 1))); ++i)
        team.emplace_back(work_on);
    } catch (const std::system_error&) {
      // The system has no more threads: those that were made do all the work.
    }
    work_on();
  }
  if (error) std::rethrow_exception(error);
}

}  // namespace tactel::host
