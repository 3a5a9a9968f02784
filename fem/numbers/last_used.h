// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <list>
#include <mutex>
#include <utility>

namespace tactel::fem {

/// The values of the keys that were asked for last, at most so many. Threads may use it at once.
template <class Key, class Value>
class LastUsed {
 public:
  explicit LastUsed(std::size_t most) : most_(most) {}
  void keep_at_least(std::size_t most) { most_ = std::max(most_, most); }

  /// Returns the value of a key: make() where it is not kept. Others wait meanwhile.
  template <class Make>
  Value get(const Key& key, const Make& make) {
    const std::lock_guard lock(turn_);
    if (!has(key)) all_.emplace_front(key, make());
    if (all_.size() > most_) all_.pop_back();
    return all_.front().second;
  }
  /// Returns it where it is kept.
  Value find(const Key& key) {
    const std::lock_guard lock(turn_);
    return has(key) ? all_.front().second : Value();
  }

 private:
  /// Whether it is there; then it is the first.
  bool has(const Key& key) {
    const auto found = std::ranges::find(all_, key, &std::pair<Key, Value>::first);
    if (found == all_.end()) return false;
    all_.splice(all_.begin(), all_, found);
    return true;
  }

  std::size_t most_;
  std::mutex turn_;
  std::list<std::pair<Key, Value>> all_;  ///< the last used first
};

}  // namespace tactel::fem
