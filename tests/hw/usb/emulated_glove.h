#pragma once
#include <umockdev.h>

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <vector>

namespace tactel::hw::testing {

/// What the device does with one of its packets instead of sending it.
enum class Fault { none, drop, stall, babble, protocol_error };

/// A glove on a bus that is not there: umockdev shows it to an unmodified libusb, and this answers the kernel's ioctls.
/// Sends `frames` frames, packet by packet as fast as they are fetched, then is silent.
class EmulatedGlove {
 public:
  EmulatedGlove();
  ~EmulatedGlove();
  EmulatedGlove(const EmulatedGlove&) = delete;
  EmulatedGlove& operator=(const EmulatedGlove&) = delete;

  void send(std::vector<std::uint8_t> stream);
  /// Before packet number `packet` (from 0) the fault happens; `drop` swallows the packet, the others come before it.
  void fault_at(std::size_t packet, Fault fault);
  void unplug();
  void plug_in();

  bool has_dtr() const { return dtr_; }
  std::size_t claimed() const { return claimed_; }
  std::size_t halts_cleared() const { return halts_cleared_; }
  std::size_t most_in_flight() const { return most_in_flight_; }
  std::size_t in_flight();

 private:
  struct Urb;
  static gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self);
  bool answer(UMockdevIoctlClient* client);
  void submit(UMockdevIoctlClient* client);
  void reap(UMockdevIoctlClient* client);
  void discard(UMockdevIoctlClient* client);
  bool fill(Urb& urb);

  std::mutex mutex_;
  std::deque<Urb> urbs_;
  std::vector<std::uint8_t> stream_;
  std::vector<std::pair<std::size_t, Fault>> faults_;
  std::size_t sent_ = 0, packet_ = 0;
  bool halted_ = false, away_ = false;
  std::atomic<bool> dtr_{false};
  std::atomic<std::size_t> claimed_{0}, halts_cleared_{0}, most_in_flight_{0};
  UMockdevTestbed* testbed_;
  UMockdevIoctlBase* handler_;
};

}  // namespace tactel::hw::testing
