// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace tactel::host {

/// Consecutive groups of one job.
struct Chunk {
  std::size_t job = 0, first = 0, count = 0;
};

/// The groups of several jobs in sequence, drawn in chunks by any number of threads. Each group is drawn exactly
/// once.
class GroupSupply {
 public:
  explicit GroupSupply(std::span<const std::size_t> groups_of_job);
  /// Returns the next groups of one job: at least one, at most size(job). Returns none when all are drawn.
  template <class Size>
  std::optional<Chunk> draw(const Size& size) {
    std::size_t first = next_.load(std::memory_order_relaxed);
    while (first < total()) {
      const std::size_t job = std::upper_bound(ends_.begin(), ends_.end(), first) - ends_.begin();
      const std::size_t count = std::min(std::max<std::size_t>(size(job), 1), ends_[job] - first);
      if (next_.compare_exchange_weak(first, first + count)) return Chunk{job, first - begin(job), count};
    }
    return std::nullopt;
  }
  void stop() { next_.store(total()); }  ///< groups not yet drawn are not run
  std::size_t total() const { return ends_.empty() ? 0 : ends_.back(); }
  std::size_t remaining() const { return total() - next_.load(std::memory_order_relaxed); }

 private:
  std::size_t begin(std::size_t job) const { return job == 0 ? 0 : ends_[job - 1]; }

  std::vector<std::size_t> ends_;  ///< [jobs] groups of this job and those before it
  std::atomic<std::size_t> next_{0};
};

/// Number of groups that a thread should draw next. A launch costs some 0.5 us, and up to 2 us where another
/// thread launches at the same time, so a chunk should take much longer. A chunk cannot be shared, so it should be
/// short beside the remaining work. Heavy groups may be anywhere, also adjacent: chunks therefore grow gradually. No
/// chunk is larger than earlier runs of the kernel suggest on average. Without an earlier run, none is longer than a
/// small part of the run so far.
class ChunkPace {
 public:
  /// `expected`: seconds of a group in an earlier run, 0 if there was none. `equal`: every group takes as long.
  ChunkPace(std::size_t largest, int threads, double expected, bool equal = false)
      : largest_(largest), threads_(threads), expected_(expected), equal_(equal) {}
  void measured(std::size_t groups, double seconds);
  std::size_t next(std::size_t remaining) const;

  static constexpr double chunk_seconds = 20e-6;  ///< target: 40 launch costs
  static constexpr double most_seconds = 100e-6;  ///< the same while much work remains
  static constexpr double part_of_rest =
      1.0 / 64;  ///< of a thread's share in it, up to which a chunk may exceed its target
  static constexpr double cautious_seconds = 3e-6;  ///< the same at the start of a first run
  static constexpr double cautious_part = 0.02;     ///< largest part of the time so far for a chunk of a first run
  static constexpr double short_seconds = 30e-6;    ///< a remainder shorter than this is split once

 private:
  double aim(double rest_seconds) const;

  std::size_t largest_;
  int threads_;
  double expected_;
  bool equal_;
  std::size_t last_groups_ = 0;
  double last_seconds_ = 0;  ///< a group
  double busy_seconds_ = 0;  ///< all chunks
};

}  // namespace tactel::host
