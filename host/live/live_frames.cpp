// SPDX-License-Identifier: Apache-2.0
#include "host/live/live_frames.h"

#include <algorithm>
#include <cmath>

namespace tactel::host {
namespace {

constexpr double finest = 0.1, ratio = 1.01;  // us; a bucket is 1 % wide
constexpr int buckets = 2400;                 // up to 0.1 us 1.01^2400 = 2300 s

}  // namespace

FrameQueue::FrameQueue(std::size_t capacity, std::size_t inputs)
    : inputs_(inputs), frames_(capacity), stresses_(capacity * inputs) {}

std::span<float> FrameQueue::push(const LiveFrame& frame) {
  if (size_ == frames_.size()) {
    pop();
    ++dropped_;
  }
  const std::size_t at = place(size_++);
  frames_[at] = frame;
  return std::span(stresses_).subspan(at * inputs_, inputs_);
}

void FrameQueue::pop() {
  first_ = place(1);
  --size_;
}

std::span<const float> FrameQueue::inputs(std::size_t i) const {
  return std::span(stresses_).subspan(place(i) * inputs_, inputs_);
}

LatencyHistogram::LatencyHistogram() : counts_(buckets, 0) {}

void LatencyHistogram::add(double microseconds) {
  if (!std::isfinite(microseconds)) return;
  const double bucket = std::log(std::max(microseconds, finest) / finest) / std::log(ratio);
  ++counts_[static_cast<std::size_t>(std::min(bucket, buckets - 1.0))];
  ++count_;
  largest_ = std::max(largest_, microseconds);
}

// The upper end of the bucket that the share falls into.
double LatencyHistogram::quantile(double share) const {
  const double wanted = share * static_cast<double>(count_);
  std::uint64_t below = 0;
  for (int i = 0; i < buckets && count_ > 0; ++i) {
    below += counts_[static_cast<std::size_t>(i)];
    if (static_cast<double>(below) >= wanted) return std::min(finest * std::pow(ratio, i + 1), largest_);
  }
  return largest_;
}

}  // namespace tactel::host
