// SPDX-License-Identifier: Apache-2.0
#include "host/device/thread_team.h"

#include <algorithm>
#include <chrono>
#include <system_error>

#include "host/support/host_limits.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace tactel::host {
namespace {

void relax() {
#if defined(__x86_64__)
  _mm_pause();
#else
  std::this_thread::yield();
#endif
}

// Waits until `ready()`, for at most so long; says whether it came.
template <class Ready>
bool spin_until(const Ready& ready, double seconds) {
  using clock = std::chrono::steady_clock;
  const auto end = clock::now() + std::chrono::duration_cast<clock::duration>(std::chrono::duration<double>(seconds));
  do {
    for (int i = 0; i < 32; ++i) {
      if (ready()) return true;
      relax();
    }
  } while (clock::now() < end);
  return ready();
}

}  // namespace

ThreadTeam::ThreadTeam(int threads, double spin_seconds) : spin_seconds_(spin_seconds) {
  threads = std::min(threads, most_threads());
  workers_.reserve(threads - 1);
  try {
    for (int index = 1; index < threads; ++index) workers_.emplace_back([this, index] { work(index); });
  } catch (const std::system_error&) {  // a limit on threads or memory: the existing threads do the work
  }
}

ThreadTeam::~ThreadTeam() {
  closing_ = true;
  run_number_.fetch_add(1);
  run_number_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void ThreadTeam::run(const std::function<void(int)>& body) {
  body_ = &body;
  error_ = nullptr;
  const std::uint32_t number = run_number_.load() + 1;
  gate_.store(std::uint64_t{number} << 32 | open_);
  run_number_.store(number);
  run_number_.notify_all();
  call_body(0);
  close_gate();
  if (error_) std::rethrow_exception(error_);
}

// Whoever has not come by now finds the gate closed: the caller never waits for a thread to wake up, only for those
// inside.
void ThreadTeam::close_gate() {
  std::uint64_t gate = gate_.fetch_and(~open_) & ~open_;
  const auto empty = [&] { return ((gate = gate_.load()) & inside_) == 0; };
  if (!spin_until(empty, spin_seconds_))
    while (!empty()) gate_.wait(gate);
}

void ThreadTeam::work(int index) {
  std::uint32_t seen = 0;
  while (await_run(seen)) {
    if (!enter(seen)) continue;
    call_body(index);
    leave();
  }
}

// Until there is a run after `seen`; false when the team is closing. The difference is signed: a worker may have passed
// the open gate just before the number was set.
bool ThreadTeam::await_run(std::uint32_t seen) {
  std::uint32_t number = seen;
  const auto called = [&] { return static_cast<std::int32_t>((number = run_number_.load()) - seen) > 0; };
  if (!spin_until(called, spin_seconds_))
    while (!called()) run_number_.wait(number);
  return !closing_;
}

// Into the run at the gate if it is open; `seen` becomes its number either way.
bool ThreadTeam::enter(std::uint32_t& seen) {
  std::uint64_t gate = gate_.load();
  while (gate & open_)
    if (gate_.compare_exchange_weak(gate, gate + 1)) break;
  seen = static_cast<std::uint32_t>(gate >> 32);
  return gate & open_;
}

void ThreadTeam::leave() {
  if (((gate_.fetch_sub(1) - 1) & inside_) == 0) gate_.notify_all();
}

void ThreadTeam::call_body(int index) {
  try {
    (*body_)(index);
  } catch (...) {
    const std::lock_guard lock(error_mutex_);
    if (!error_) error_ = std::current_exception();
  }
}

}  // namespace tactel::host
