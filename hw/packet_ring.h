// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <sys/eventfd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <vector>

#include "hw/descriptor.h"
#include "hw/frame_source.h"

namespace tactel::hw {

/// Passes packets from one thread to another, without allocation. A full ring drops its oldest packet. Packets
/// are copied in and out under a lock that is held for those bytes alone.
class PacketRing {
 public:
  /// slot_bytes: the longest packet; longer ones are truncated.
  PacketRing(std::size_t slots, std::size_t slot_bytes)
      : slot_bytes_(slot_bytes), slots_(slots), bytes_(slots * slot_bytes), taken_(slot_bytes) {}

  /// Returns a descriptor that is readable while packets or a failure wait; -1 where the system gives none. It exists
  /// from the first call on: a ring without it costs no call of the system.
  int event() {
    const std::lock_guard lock(mutex_);
    if (event_ < 0) {
      event_ = Descriptor(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
      if (size_ > 0 || failure_) raise_event();
    }
    return event_;
  }

  /// Appends a packet and wakes the reader. Returns true where the oldest packet was dropped; the oldest
  /// remaining one is then marked as after a gap.
  bool push(const Packet& packet) {
    const bool dropped = put(packet);
    arrived_.notify_one();
    return dropped;
  }

  /// Records the exception that ended the writing thread. `take` throws it once no packet is left.
  void fail(std::exception_ptr failure) {
    {
      const std::lock_guard lock(mutex_);
      failure_ = std::move(failure);
      raise_event();
    }
    arrived_.notify_one();
  }

  /// Returns the oldest packet; waits up to `timeout` s for one. Its bytes are valid until the next call. Only
  /// one thread may take packets. Throws the exception that ended the writing thread.
  std::optional<Packet> take(double timeout = 0) {
    std::unique_lock lock(mutex_);
    if (timeout > 0)
      arrived_.wait_for(lock, std::chrono::duration<double>(std::min(timeout, longest_wait)),
                        [this] { return size_ > 0 || failure_; });
    if (size_ == 0 && failure_) std::rethrow_exception(failure_);
    if (size_ == 0) return std::nullopt;
    const Packet packet = slots_[first_];
    std::ranges::copy(packet.bytes, taken_.data());
    drop_oldest();
    if (size_ == 0 && !failure_) clear_event();
    return Packet{Bytes(taken_).first(packet.bytes.size()), packet.arrival, packet.after_gap};
  }

 private:
  static constexpr double longest_wait = 3600;  // s: a longer timeout would leave the clock's range

  bool put(const Packet& packet) {
    const std::lock_guard lock(mutex_);
    const bool full = size_ == slots_.size();
    if (full) drop_oldest();
    if (size_ == 0) raise_event();
    const std::size_t at = place(size_++);
    slots_[at] = {{bytes_.data() + at * slot_bytes_, std::min(packet.bytes.size(), slot_bytes_)},
                  packet.arrival,
                  packet.after_gap};
    std::ranges::copy(packet.bytes.first(slots_[at].bytes.size()), bytes_.data() + at * slot_bytes_);
    if (full) slots_[first_].after_gap = true;
    return full;
  }
  // Both under the lock, so that the event says what the ring holds.
  void raise_event() {
    if (event_ >= 0) ::eventfd_write(event_, 1);
  }
  void clear_event() {
    eventfd_t raised = 0;
    if (event_ >= 0) ::eventfd_read(event_, &raised);
  }
  std::size_t place(std::size_t i) const { return (first_ + i) % slots_.size(); }
  void drop_oldest() {
    first_ = place(1);
    --size_;
  }

  std::mutex mutex_;
  std::condition_variable arrived_;  ///< size_ or failure_ changed
  std::exception_ptr failure_;
  Descriptor event_;
  std::size_t slot_bytes_, first_ = 0, size_ = 0;
  std::vector<Packet> slots_;        ///< [slots]
  std::vector<std::uint8_t> bytes_;  ///< [slots, slot_bytes]
  std::vector<std::uint8_t> taken_;  ///< [slot_bytes] the packet that the reader holds
};

}  // namespace tactel::hw
