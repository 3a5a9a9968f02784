// SPDX-License-Identifier: Apache-2.0
#include "host/support/interrupt.h"

#include <array>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <ctime>

namespace tactel::host {
namespace {

constexpr std::int64_t no_signal = -1;
constexpr std::int64_t same_wish = 500'000'000;  ///< ns after the first signal within which others repeat it

// Of the first signal, ns on the monotonic clock. A signal may reach any thread.
std::atomic<std::int64_t> asked_at = no_signal;
static_assert(std::atomic<std::int64_t>::is_always_lock_free, "a signal handler takes no lock");
constexpr std::array stop_signals = {SIGINT, SIGTERM, SIGHUP};
std::array<struct sigaction, stop_signals.size()> before;

std::int64_t monotonic_ns() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

/// Notes the first signal and ends the program at a later one. Calls async-signal-safe functions alone.
void on_signal(int signal) {
  const std::int64_t time = monotonic_ns();
  std::int64_t first = no_signal;
  if (asked_at.compare_exchange_strong(first, time) || time - first < same_wish) return;
  std::signal(signal, SIG_DFL);
  std::raise(signal);  // taken when this handler returns
}

}  // namespace

Interrupt::Interrupt() {
  asked_at = no_signal;
  struct sigaction action {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  for (std::size_t k = 0; k < stop_signals.size(); ++k) {
    sigaction(stop_signals[k], &action, &before[k]);
    if (stop_signals[k] == SIGHUP && before[k].sa_handler == SIG_IGN) sigaction(SIGHUP, &before[k], nullptr);  // nohup
  }
}

Interrupt::~Interrupt() {
  for (std::size_t k = 0; k < stop_signals.size(); ++k) sigaction(stop_signals[k], &before[k], nullptr);
}

bool Interrupt::requested() const { return seen(); }
bool Interrupt::seen() { return asked_at != no_signal; }

HeldSignals::HeldSignals(When when) {
  sigset_t held;
  sigemptyset(&held);
  for (const int signal : stop_signals) {
    struct sigaction current {};
    sigaction(signal, nullptr, &current);
    const bool second = current.sa_handler == on_signal && Interrupt::seen();
    const bool ends_at_once = current.sa_handler == SIG_DFL || second;
    if (when == always || !ends_at_once) sigaddset(&held, signal);
  }
  pthread_sigmask(SIG_BLOCK, &held, &before_);
}

HeldSignals::~HeldSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

}  // namespace tactel::host
