#pragma once
#include <algorithm>
#include <atomic>
#include <cstring>
#include <vector>

#include "hw/frame_source.h"

namespace tactel::hw {

/// Packets from one thread to another without locks or allocation. When it is full the newest is refused: what is in
/// flight to the reader is never touched.
class PacketRing {
 public:
  /// slots: a power of two; slot_bytes: the longest packet.
  PacketRing(std::size_t slots, std::size_t slot_bytes)
      : slot_bytes_(slot_bytes), slots_(slots), bytes_(slots * slot_bytes) {}

  /// Producer. False when full.
  bool push(const Packet& packet) {
    const std::size_t end = end_.load(std::memory_order_relaxed);
    if (end - begin_.load(std::memory_order_acquire) == slots_.size()) return false;
    const std::size_t at = end % slots_.size(), length = std::min(packet.bytes.size(), slot_bytes_);
    std::uint8_t* to = bytes_.data() + at * slot_bytes_;
    if (length > 0) std::memcpy(to, packet.bytes.data(), length);
    slots_[at] = {{to, length}, packet.arrival, packet.after_gap};
    end_.store(end + 1, std::memory_order_release);
    return true;
  }

  /// Consumer: the oldest packet, or null. It stays valid until pop.
  const Packet* front() const {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    return begin == end_.load(std::memory_order_acquire) ? nullptr : &slots_[begin % slots_.size()];
  }
  void pop() { begin_.store(begin_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

 private:
  std::size_t slot_bytes_;
  std::vector<Packet> slots_;
  std::vector<std::uint8_t> bytes_;  ///< [slots, slot_bytes]
  alignas(64) std::atomic<std::size_t> begin_{0};
  alignas(64) std::atomic<std::size_t> end_{0};
};

}  // namespace tactel::hw
