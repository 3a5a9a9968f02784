// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace tactel::host {

/// Worker threads beside the calling thread. An idle worker spins for `spin_seconds`, then sleeps. Consecutive
/// short runs therefore cost no wake-up, and an idle program costs no processor time.
class ThreadTeam {
 public:
  /// `threads` includes the thread that calls run. Where the system creates fewer threads, the team is smaller;
  /// threads() returns its size.
  ThreadTeam(int threads, double spin_seconds);
  ~ThreadTeam();
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;

  int threads() const { return 1 + static_cast<int>(workers_.size()); }

  /// Calls body(0) in the calling thread, and body(1), body(2), ... in the workers that arrive before body(0)
  /// returns, each at most once. The body must therefore draw its work from a common supply. Waits for these
  /// workers, then rethrows the first exception. Not reentrant.
  void run(const std::function<void(int)>& body);

 private:
  void work(int index);
  bool await_run(std::uint32_t seen);
  bool enter(std::uint32_t& seen);
  void leave();
  void close_gate();
  void call_body(int index);

  // The gate holds the run's number (upper half), whether the run still takes workers, and how many are inside.
  static constexpr std::uint64_t open_ = 1u << 31;
  static constexpr std::uint64_t inside_ = open_ - 1;
  double spin_seconds_;
  std::atomic<std::uint64_t> gate_{0};
  std::atomic<std::uint32_t> run_number_{0};  ///< polled by idle workers; set after the gate is open
  std::atomic<bool> closing_{false};
  const std::function<void(int)>* body_ = nullptr;
  std::mutex error_mutex_;
  std::exception_ptr error_;
  std::vector<std::thread> workers_;
};

}  // namespace tactel::host
