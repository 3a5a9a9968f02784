// SPDX-License-Identifier: Apache-2.0

// Packets from a device by libusb's asynchronous transfers.

#include "hw/usb_source.h"

#include <libusb.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <system_error>
#include <thread>
#include <tuple>

#include "hw/libusb_device.h"
#include "hw/packet_ring.h"

namespace tactel::hw {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int in_flight = 16;             // transfers of one packet: 16 ms at 1 kHz
constexpr std::size_t ring_slots = 4096;  // 4 s at 1 kHz
constexpr int poll_ms = 50;               // how soon a stop is noticed when nothing comes
constexpr auto reopen_every = std::chrono::milliseconds(500);
constexpr auto patience_at_stop = std::chrono::seconds(2);
constexpr auto pause_after_error = std::chrono::milliseconds(5);
constexpr int most_errors_in_a_row = 2 * in_flight;
constexpr int most_stalls_in_a_row = 8;

struct FreeTransfer {
  void operator()(libusb_transfer* transfer) const { libusb_free_transfer(transfer); }
};

/// What to look for once the device was away: the same one. Without a serial number of its own it is known by its port
/// where another could be mistaken for it.
UsbDevice same_again(UsbDevice device, const UsbChoice& choice) {
  const bool chosen_by_port = !device.port.empty();
  if (!chosen_by_port) device.serial = choice.taken.serial;
  const auto alike = [&](const UsbChoice::Other& other) { return other.place.serial == choice.taken.serial; };
  if (std::ranges::any_of(choice.others, alike)) device.port = choice.taken.port;
  return device;
}

/// Keeps transfers in flight. All libusb calls after construction are made by one thread; the reader only takes packets
/// from the ring.
class LibusbSource final : public UsbSource {
 public:
  explicit LibusbSource(const UsbDevice& device) : device_(device), ring_(ring_slots, longest_packet) {
    OpenedUsb opened = open_first_free(context_.get(), device, true);
    opened_ = std::move(opened.device);
    choice_ = std::move(opened.choice);
    device_ = same_again(device, choice_);
    make_transfers();
    listen_for_arrival();
    try {
      thread_ = std::thread([this] { run(); });
    } catch (const std::system_error& error) {
      throw SourceError(std::string("USB: no thread to read the device: ") + error.what());
    }
  }
  ~LibusbSource() override {
    stopping_ = true;
    thread_.join();
    free_transfers();
  }

  std::optional<Packet> wait(double timeout) override { return ring_.take(timeout); }
  int fd() const override { return ring_.event(); }
  const UsbChoice& choice() const override { return choice_; }
  bool finished() const override { return false; }
  bool live() const override { return true; }
  double now() const override { return std::chrono::duration<double>(Clock::now() - zero_).count(); }
  TransportCounts counts() const override {
    return {.packets = packets_,
            .bytes = bytes_,
            .overruns = overruns_,
            .stalls = stalls_,
            .errors = errors_,
            .reconnects = reconnects_};
  }

 private:
  static constexpr std::size_t longest_packet = 1024;
  struct Slot {
    LibusbSource* source = nullptr;
    std::unique_ptr<libusb_transfer, FreeTransfer> transfer{};
    bool busy = false;
    std::array<std::uint8_t, longest_packet> bytes{};
  };

  void make_transfers() {
    for (Slot& slot : slots_) {
      slot.source = this;
      slot.transfer.reset(libusb_alloc_transfer(0));
      if (slot.transfer == nullptr) throw std::runtime_error("USB: no memory for transfers");
    }
  }

  void free_transfers() {
    for (Slot& slot : slots_) {
      if (slot.busy) std::ignore = slot.transfer.release();  // one that never came back still belongs to libusb
      slot.transfer.reset();
    }
  }

  // Only a hint that makes reopening quicker: libusb may report an arrival twice, or not at all without udev.
  void listen_for_arrival() {
    if (!libusb_has_capability(LIBUSB_CAP_HAS_HOTPLUG)) return;
    const auto arrived = [](libusb_context*, libusb_device*, libusb_hotplug_event, void* self) {
      static_cast<LibusbSource*>(self)->arrived_ = true;
      return 0;
    };
    libusb_hotplug_register_callback(context_.get(), LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED, LIBUSB_HOTPLUG_NO_FLAGS,
                                     device_.vendor, device_.product, LIBUSB_HOTPLUG_MATCH_ANY, arrived, this, nullptr);
  }

  /// Failures here reach the reader, which waits in another thread.
  void run() {
    try {
      pump();
    } catch (...) {
      ring_.fail(std::current_exception());
    }
    stop();
  }

  void pump() {
    submit_all();
    while (!stopping_) {
      handle_events();
      if (busy_ > 0 || opened_ == nullptr) {
        if (opened_ == nullptr) reopen();
        if (gone_ && busy_ > 0) cancel_all();
        continue;
      }
      if (gone_) {
        opened_.reset();
      } else {
        if (halted_) clear_halt();
        submit_all();
      }
    }
  }

  void handle_events() {
    timeval limit{0, 1000 * poll_ms};
    const int code = libusb_handle_events_timeout_completed(context_.get(), &limit, nullptr);
    if (code != 0 && code != LIBUSB_ERROR_INTERRUPTED) std::this_thread::sleep_for(pause_after_error);  // no spinning
  }

  void submit_all() {
    cancelling_ = false;
    for (Slot& slot : slots_) {
      if (gone_ || slot.busy) continue;
      const UsbRoute& route = opened_->route();
      const int length = std::min<int>(route.packet, static_cast<int>(slot.bytes.size()));
      const auto fill = route.in_is_interrupt ? libusb_fill_interrupt_transfer : libusb_fill_bulk_transfer;
      fill(slot.transfer.get(), opened_->handle(), route.in, slot.bytes.data(), length, completed, &slot, 0);
      submit(slot);
    }
  }

  void submit(Slot& slot) {
    const int code = libusb_submit_transfer(slot.transfer.get());
    slot.busy = code == 0;
    if (code == 0) {
      ++busy_;
    } else if (code == LIBUSB_ERROR_NO_MEM || code == LIBUSB_ERROR_BUSY) {
      ++errors_;  // fewer are in flight; the others continue
    } else {
      gone_ = true;
    }
  }

  static void completed(libusb_transfer* transfer) {
    Slot& slot = *static_cast<Slot*>(transfer->user_data);
    slot.source->complete(slot);
  }

  void complete(Slot& slot) {
    slot.busy = false;
    --busy_;
    switch (slot.transfer->status) {
      case LIBUSB_TRANSFER_COMPLETED:
      case LIBUSB_TRANSFER_TIMED_OUT:
        errors_in_a_row_ = stalls_in_a_row_ = 0, take(slot);
        break;
      case LIBUSB_TRANSFER_STALL:
        halted_ = true, cancel_all();
        return;
      case LIBUSB_TRANSFER_NO_DEVICE:
        gone_ = true;
        return;
      case LIBUSB_TRANSFER_CANCELLED:
        return;
      default:  // ERROR, OVERFLOW: the first sign of an unplug, too; then the next submit fails
        ++errors_;
        gone_ = ++errors_in_a_row_ > most_errors_in_a_row;
    }
    if (!stopping_ && !halted_ && !gone_ && !cancelling_) submit(slot);
  }

  void take(const Slot& slot) {
    if (stopping_ || cancelling_) return;
    Bytes bytes(slot.bytes.data(), static_cast<std::size_t>(slot.transfer->actual_length));
    if (device_.transport == Transport::ftdi) bytes = without_ftdi_status(bytes);
    if (bytes.empty()) return;
    ++packets_;
    bytes_ += bytes.size();
    if (ring_.push({bytes, now(), gap_})) ++overruns_;
    gap_ = false;
  }

  void cancel_all() {
    if (cancelling_) return;
    cancelling_ = true;
    for (Slot& slot : slots_)
      if (slot.busy) libusb_cancel_transfer(slot.transfer.get());
  }

  // An endpoint that halts again and again without a packet between, or a halt that cannot be cleared, is a device that
  // does not work: it is closed and opened anew, every half second.
  void clear_halt() {
    halted_ = false;
    ++stalls_;
    gap_ = true;
    const int code = libusb_clear_halt(opened_->handle(), opened_->route().in);
    gone_ = code != 0 || ++stalls_in_a_row_ >= most_stalls_in_a_row;
    if (gone_ && code != LIBUSB_ERROR_NO_DEVICE) ++errors_;
  }

  // While the device is away: at each arrival, and every half second.
  void reopen() {
    const auto now = Clock::now();
    const bool arrived = arrived_.exchange(false);
    if (!arrived && now < next_try_) return;
    next_try_ = now + reopen_every;
    try {
      if (!arrived) look_again();
      opened_ = open_first_free(context_.get(), device_, false).device;
    } catch (const SourceError&) {
      return;  // not there yet, or not ready
    }
    gone_ = halted_ = false;
    errors_in_a_row_ = stalls_in_a_row_ = 0;
    gap_ = true;
    ++reconnects_;
    submit_all();
  }

  // libusb learns of new devices from the udev daemon alone. Where none runs (a container), only a new context sees
  // them. A transfer keeps hold of the device it was last used for, and that of its context: no transfer may outlive
  // it.
  void look_again() {
    LibusbContext fresh = new_context();
    free_transfers();
    context_ = std::move(fresh);
    make_transfers();
    listen_for_arrival();
  }

  // Every transfer must have come back before its memory goes.
  void stop() {
    cancelling_ = false;
    cancel_all();
    for (const auto end = Clock::now() + patience_at_stop; busy_ > 0 && Clock::now() < end;) handle_events();
    opened_.reset();
  }

  LibusbContext context_ = new_context();
  UsbDevice device_;  ///< what to open; from the first opening on that same device
  UsbChoice choice_;
  std::unique_ptr<LibusbDevice> opened_;  ///< null while the device is away
  mutable PacketRing ring_;
  std::array<Slot, in_flight> slots_;
  const Clock::time_point zero_ = Clock::now();
  int busy_ = 0, errors_in_a_row_ = 0, stalls_in_a_row_ = 0;
  bool gone_ = false, halted_ = false, cancelling_ = false, gap_ = false;
  Clock::time_point next_try_{};
  std::atomic<bool> stopping_{false}, arrived_{false};
  std::atomic<std::uint64_t> packets_{0}, bytes_{0}, overruns_{0}, stalls_{0}, errors_{0}, reconnects_{0};
  std::thread thread_;
};

}  // namespace

std::unique_ptr<UsbSource> open_usb(const UsbDevice& device) { return std::make_unique<LibusbSource>(device); }

}  // namespace tactel::hw
