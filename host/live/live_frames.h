// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace tactel::host {

/// Number and times of a frame.
struct LiveFrame {
  std::uint64_t number = 0;             ///< from 0, in the order of decoding
  std::optional<double> device_time{};  ///< s
  double arrival = 0;                   ///< s
  double decoded = 0;                   ///< s, the same clock
};

/// Decoded frames that wait for their slippage index: a ring of fixed size. A full ring drops its oldest frames.
class FrameQueue {
 public:
  FrameQueue(std::size_t capacity, std::size_t inputs);
  /// Appends a frame. Returns its inputs [inputs] MPa, to be written by the caller.
  std::span<float> push(const LiveFrame& frame);
  void pop();
  std::size_t size() const { return size_; }
  std::size_t dropped() const { return dropped_; }                           ///< because of a full ring
  const LiveFrame& frame(std::size_t i) const { return frames_[place(i)]; }  ///< 0 is the oldest
  std::span<const float> inputs(std::size_t i) const;

 private:
  std::size_t place(std::size_t i) const { return (first_ + i) % frames_.size(); }
  std::size_t inputs_, first_ = 0, size_ = 0, dropped_ = 0;
  std::vector<LiveFrame> frames_;  ///< [capacity]
  std::vector<float> stresses_;    ///< [capacity, inputs] MPa
};

/// Quantiles of latencies within 1 %, in memory that does not grow.
class LatencyHistogram {
 public:
  LatencyHistogram();
  void add(double microseconds);        ///< non-finite values are ignored
  double quantile(double share) const;  ///< us; 0 without latencies
  double largest() const { return largest_; }
  std::uint64_t count() const { return count_; }

 private:
  std::vector<std::uint64_t> counts_;
  std::uint64_t count_ = 0;
  double largest_ = 0;
};

}  // namespace tactel::host
