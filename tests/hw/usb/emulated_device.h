// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <umockdev.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/hw/usb/device_kinds.h"
#include "tests/hw/usb/terminal_node.h"

namespace tactel::hw::tests {

/// What the device does with one of its packets instead of sending it.
enum class Fault { none, drop, stall, babble, protocol_error };

struct ControlRequest {
  std::uint8_t type = 0, request = 0;
  std::uint16_t value = 0, index = 0;
  ByteVector data{};
  bool operator==(const ControlRequest&) const = default;
};

/// A device on a bus that is not there: umockdev shows it to an unmodified libusb, and this answers the kernel's
/// ioctls. Its packets wait in a queue until they are fetched. Several may live at once, each at a port of its own.
class EmulatedDevice {
 public:
  /// port: of the root hub, from 1; serial: a number of at most 30 characters, empty for none.
  explicit EmulatedDevice(const DeviceKind& kind, int port = 1, std::string serial = "");
  ~EmulatedDevice();
  EmulatedDevice(const EmulatedDevice&) = delete;
  EmulatedDevice& operator=(const EmulatedDevice&) = delete;

  /// A stream, split into full packets; the last one may be short.
  void send(const ByteVector& stream);
  /// Packets as they are: short, empty, longer than the endpoint's.
  void send_packets(const std::vector<ByteVector>& packets);
  /// From now on a packet every `period`: `make` writes packet i (from 0). Once `queue` packets wait the next is lost,
  /// as in a device whose memory is full.
  void send_by_clock(std::chrono::nanoseconds period, std::size_t queue,
                     std::function<void(std::size_t i, ByteVector& packet)> make);
  void stop_clock();

  /// Before packet number `packet` (from 0, since the last `send`) the fault happens; `drop` swallows the packet, the
  /// others come before it.
  void fault_at(std::size_t packet, Fault fault);
  void unplug();
  void plug_in();
  void plug_in_at(int port);
  void set_busy(bool busy) { busy_ = busy; }      ///< another program has claimed its interfaces
  void set_stuck(bool stuck) { stuck_ = stuck; }  ///< a halt is not cleared, though the request succeeds

  std::vector<ControlRequest> control_requests();
  ByteVector received();  ///< by the OUT endpoint
  std::size_t waiting();  ///< packets that nobody has fetched
  std::size_t in_flight();
  std::size_t claimed() const { return claimed_; }
  std::size_t halts_cleared() const { return halts_cleared_; }
  std::size_t most_in_flight() const { return most_in_flight_; }
  std::size_t interrupt_requests() const { return interrupt_requests_; }
  std::size_t ioctls() const { return ioctls_; }
  std::size_t lost() const { return lost_; }  ///< packets by the clock that found the queue full

 private:
  struct Urb;
  static gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self);
  void answer(UMockdevIoctlClient* client);
  void submit(UMockdevIoctlClient* client);
  void reap(UMockdevIoctlClient* client);
  void discard(UMockdevIoctlClient* client);
  void serve();
  bool complete(Urb& urb);
  bool complete_control(Urb& urb);
  bool complete_string(Urb& urb, int index);
  std::string description() const;
  std::string node() const;
  std::string in_sysfs() const;
  bool complete_in(Urb& urb);
  void tick(std::chrono::nanoseconds period, std::size_t queue,
            const std::function<void(std::size_t, ByteVector&)>& make);

  const DeviceKind kind_;
  int port_;
  const std::string serial_;
  std::mutex mutex_;
  std::deque<Urb> urbs_;
  std::deque<ByteVector> packets_;
  std::vector<std::pair<std::size_t, Fault>> faults_;
  std::vector<ControlRequest> control_;
  ByteVector received_;
  std::size_t fetched_ = 0;  ///< packets since the last `send`
  bool halted_ = false, away_ = false;
  std::atomic<bool> stopping_{false}, busy_{false}, stuck_{false};
  std::atomic<std::size_t> claimed_{0}, halts_cleared_{0}, most_in_flight_{0}, interrupt_requests_{0}, ioctls_{0},
      lost_{0};
  std::shared_ptr<UMockdevTestbed> testbed_;  ///< of all devices alive
  UMockdevIoctlBase* handler_;
  std::unique_ptr<TerminalNode> node_;
  std::set<int> attached_;  ///< ports whose node's ioctls come here
  std::thread clock_;
};

}  // namespace tactel::hw::tests
