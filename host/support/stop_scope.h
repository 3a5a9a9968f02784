// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <utility>

#include "host/support/errors.h"

namespace tactel::host {

/// While it lives, long work of this thread, and of the threads that help it (side_by_side, Executor), ends by Stopped
/// soon after `asked` returns true. Of two scopes the inner one counts.
class StopScope {
 public:
  using Asked = std::function<bool()>;  ///< called by any thread
  explicit StopScope(const Asked* asked) : before_(std::exchange(current_, asked)) {}
  ~StopScope() { current_ = before_; }
  StopScope(const StopScope&) = delete;
  StopScope& operator=(const StopScope&) = delete;

  static const Asked* current() { return current_; }  ///< null: none
  static bool asked() { return current_ && *current_ && (*current_)(); }
  /// Throws Stopped where a stop is asked for.
  static void check() {
    if (asked()) throw Stopped("stopped");
  }
  /// Returns check() of the scope that is current now, for any thread to call while it lives.
  static std::function<void()> checker() {
    return [asked = current_] { StopScope(asked).check(); };
  }

 private:
  static inline thread_local const Asked* current_ = nullptr;
  const Asked* before_;
};

}  // namespace tactel::host
