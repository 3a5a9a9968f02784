#pragma once
#include <algorithm>
#include <mutex>
#include <optional>
#include <vector>

#include "hw/frame_source.h"

namespace tactel::hw {

/// Packets from one thread to another, without allocation. When it is full the oldest goes: what is read is never older
/// than the ring is long. Packets are copied in and out under a lock that is held for those bytes alone.
class PacketRing {
 public:
  /// slot_bytes: the longest packet; what is longer is cut.
  PacketRing(std::size_t slots, std::size_t slot_bytes)
      : slot_bytes_(slot_bytes), slots_(slots), bytes_(slots * slot_bytes), taken_(slot_bytes) {}

  /// Puts a packet last. True when the oldest was dropped for it; then the oldest that is left comes after a gap.
  bool push(const Packet& packet) {
    const std::lock_guard lock(mutex_);
    const bool full = size_ == slots_.size();
    if (full) drop_oldest();
    const std::size_t at = place(size_++);
    slots_[at] = {{bytes_.data() + at * slot_bytes_, std::min(packet.bytes.size(), slot_bytes_)},
                  packet.arrival,
                  packet.after_gap};
    std::ranges::copy(packet.bytes.first(slots_[at].bytes.size()), bytes_.data() + at * slot_bytes_);
    if (full) slots_[first_].after_gap = true;
    return full;
  }

  /// The oldest packet, or none. Its bytes are valid until the next call; one thread alone takes.
  std::optional<Packet> take() {
    const std::lock_guard lock(mutex_);
    if (size_ == 0) return std::nullopt;
    const Packet packet = slots_[first_];
    std::ranges::copy(packet.bytes, taken_.data());
    drop_oldest();
    return Packet{Bytes(taken_).first(packet.bytes.size()), packet.arrival, packet.after_gap};
  }

 private:
  std::size_t place(std::size_t i) const { return (first_ + i) % slots_.size(); }
  void drop_oldest() {
    first_ = place(1);
    --size_;
  }

  std::mutex mutex_;
  std::size_t slot_bytes_, first_ = 0, size_ = 0;
  std::vector<Packet> slots_;        ///< [slots]
  std::vector<std::uint8_t> bytes_;  ///< [slots, slot_bytes]
  std::vector<std::uint8_t> taken_;  ///< [slot_bytes] the packet that the reader holds
};

}  // namespace tactel::hw
