// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace tactel::host {

/// Items first, first + 1, ..., made on threads of its own ahead of their use, and handed out in order.
template <class T>
class MadeAhead {
 public:
  /// `make(k)` returns item k; the threads call it at once. Without threads next() calls it. At most `ahead` items are
  /// under way or wait: memory stays bounded. Works with fewer threads where the system has no more.
  MadeAhead(std::uint64_t first, int threads, std::size_t ahead, std::function<T(std::uint64_t)> make)
      : make_(std::move(make)), ahead_(ahead), taken_(first), begun_(first) {
    try {
      for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { work(); });
    } catch (const std::system_error&) {
    }
  }
  /// Waits for the items under way.
  ~MadeAhead() {
    {
      const std::lock_guard lock(mutex_);
      stopped_ = true;
    }
    changed_.notify_all();
    threads_.clear();
  }

  int threads() const { return static_cast<int>(threads_.size()); }

  /// Waits for the next item and returns it. Throws what `make` threw for it.
  T next() {
    if (threads_.empty()) return make_(taken_++);
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return made_.contains(taken_); });
    Made made = std::move(made_.extract(taken_++).mapped());
    lock.unlock();
    changed_.notify_all();
    if (made.error) std::rethrow_exception(made.error);
    return std::move(*made.item);
  }

 private:
  struct Made {
    std::optional<T> item;
    std::exception_ptr error;
  };

  void work() {
    std::unique_lock lock(mutex_);
    while (true) {
      changed_.wait(lock, [&] { return stopped_ || begun_ < taken_ + ahead_; });
      if (stopped_) return;
      const std::uint64_t k = begun_++;
      lock.unlock();
      Made made = made_now(k);
      lock.lock();
      made_.emplace(k, std::move(made));
      changed_.notify_all();
    }
  }
  Made made_now(std::uint64_t k) const try { return {make_(k), nullptr}; } catch (...) {
    return {std::nullopt, std::current_exception()};
  }

  std::function<T(std::uint64_t)> make_;
  std::size_t ahead_;
  std::uint64_t taken_, begun_;
  bool stopped_ = false;
  std::map<std::uint64_t, Made> made_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::jthread> threads_;
};

}  // namespace tactel::host
