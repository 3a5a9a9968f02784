// The only file that knows libusb.
#include "hw/usb_source.h"

#include <libusb.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <semaphore>
#include <thread>

#include "hw/ftdi.h"
#include "hw/packet_ring.h"

namespace tactel::hw {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int in_flight = 16;              // transfers of one packet: 16 ms at 1 kHz
constexpr std::size_t ring_slots = 4096;   // 4 s at 1 kHz
constexpr unsigned control_timeout = 500;  // ms
constexpr int poll_ms = 50;                // how soon a stop is noticed when nothing comes
constexpr auto reopen_every = std::chrono::milliseconds(500);
constexpr auto patience_at_stop = std::chrono::seconds(2);
constexpr int most_errors_in_a_row = 2 * in_flight;

std::string id_text(const UsbDevice& device) {
  std::array<char, 16> text;
  std::snprintf(text.data(), text.size(), "%04x:%04x", device.vendor, device.product);
  return text.data();
}

[[noreturn]] void fail(const UsbDevice& device, const std::string& call, int code, const std::string& advice = "") {
  throw SourceError("USB " + id_text(device) + ": " + call + ": " + libusb_error_name(code) +
                    (advice.empty() ? "" : "; " + advice));
}

/// Where the frames come from, by descriptor.
struct Route {
  int data_interface = -1, control_interface = -1;
  std::uint8_t in = 0, out = 0;  ///< endpoint addresses; out 0: none
  bool in_is_interrupt = false;
  int packet = 0;  ///< bytes
};

bool carries_frames(const libusb_endpoint_descriptor& endpoint, const UsbDevice& device) {
  const int kind = endpoint.bmAttributes & LIBUSB_TRANSFER_TYPE_MASK;
  const bool in = endpoint.bEndpointAddress & LIBUSB_ENDPOINT_IN;
  const bool streams = kind == LIBUSB_TRANSFER_TYPE_BULK || kind == LIBUSB_TRANSFER_TYPE_INTERRUPT;
  return in && streams && (device.endpoint < 0 || device.endpoint == endpoint.bEndpointAddress);
}

/// Takes the interface's endpoints into the route if one of them carries frames.
void consider(const libusb_interface_descriptor& interface, const UsbDevice& device, Route& route) {
  if (interface.bInterfaceClass == LIBUSB_CLASS_COMM && route.control_interface < 0)
    route.control_interface = interface.bInterfaceNumber;
  const bool asked = device.interface < 0 || device.interface == interface.bInterfaceNumber;
  const bool fits = device.transport != Transport::cdc_acm || interface.bInterfaceClass == LIBUSB_CLASS_DATA;
  if (route.data_interface >= 0 || !asked || !fits) return;
  Route found = route;
  for (int i = 0; i < interface.bNumEndpoints; ++i) {
    const libusb_endpoint_descriptor& endpoint = interface.endpoint[i];
    const int kind = endpoint.bmAttributes & LIBUSB_TRANSFER_TYPE_MASK;
    if (found.in == 0 && carries_frames(endpoint, device)) {
      found.data_interface = interface.bInterfaceNumber;
      found.in = endpoint.bEndpointAddress;
      found.in_is_interrupt = kind == LIBUSB_TRANSFER_TYPE_INTERRUPT;
      found.packet = endpoint.wMaxPacketSize & 0x7FF;
    } else if (found.out == 0 && !(endpoint.bEndpointAddress & LIBUSB_ENDPOINT_IN) &&
               kind == LIBUSB_TRANSFER_TYPE_BULK) {
      found.out = endpoint.bEndpointAddress;
    }
  }
  if (found.in != 0 && found.packet > 0) route = found;
}

Route find_route(libusb_device* usb, const UsbDevice& device) {
  libusb_config_descriptor* config = nullptr;
  if (const int code = libusb_get_active_config_descriptor(usb, &config); code != 0)
    fail(device, "reading its descriptor", code);
  Route route;
  for (int i = 0; i < config->bNumInterfaces; ++i)
    if (config->interface[i].num_altsetting > 0) consider(config->interface[i].altsetting[0], device, route);
  libusb_free_config_descriptor(config);
  if (route.data_interface < 0)
    throw SourceError("USB " + id_text(device) + ": no interface with an IN endpoint as its profile says");
  return route;
}

/// An open, claimed and prepared device.
class OpenDevice {
 public:
  OpenDevice(libusb_context* context, const UsbDevice& device) : device_(device) {
    open(context);
    try {
      route_ = find_route(libusb_get_device(handle_), device);
      claim();
      prepare();
    } catch (...) {
      close();
      throw;
    }
  }
  ~OpenDevice() { close(); }
  OpenDevice(const OpenDevice&) = delete;
  OpenDevice& operator=(const OpenDevice&) = delete;

  libusb_device_handle* handle() const { return handle_; }
  const Route& route() const { return route_; }

 private:
  void open(libusb_context* context) {
    libusb_device** list = nullptr;
    const ssize_t count = libusb_get_device_list(context, &list);
    int code = LIBUSB_ERROR_NO_DEVICE;
    for (ssize_t i = 0; i < count && handle_ == nullptr; ++i) {
      libusb_device_descriptor descriptor{};
      if (libusb_get_device_descriptor(list[i], &descriptor) != 0) continue;
      if (descriptor.idVendor == device_.vendor && descriptor.idProduct == device_.product)
        code = libusb_open(list[i], &handle_);
    }
    if (count >= 0) libusb_free_device_list(list, 1);
    if (handle_ != nullptr) return;
    if (code == LIBUSB_ERROR_ACCESS)
      fail(device_, "opening it", code,
           "this user may not: copy scripts/70-tactel.rules to /etc/udev/rules.d/, `udevadm control --reload`, plug it "
           "in again");
    fail(device_, "looking for it", code,
         "is it plugged in? `lsusb -d " + id_text(device_) + "` shows whether the system sees it");
  }

  void claim() {
    libusb_set_auto_detach_kernel_driver(handle_, 1);  // gives the driver back when we release
    for (const int interface : {route_.control_interface, route_.data_interface}) {
      if (interface < 0 || (interface == route_.control_interface && device_.transport != Transport::cdc_acm)) continue;
      if (const int code = libusb_claim_interface(handle_, interface); code != 0)
        fail(device_, "claiming interface " + std::to_string(interface), code, "does another program use it?");
    }
  }

  void prepare() {
    if (device_.transport == Transport::cdc_acm && route_.control_interface >= 0) prepare_cdc();
    if (device_.transport == Transport::ftdi) prepare_ftdi();
    if (device_.start.empty()) return;
    if (route_.out == 0) throw SourceError("USB " + id_text(device_) + ": no OUT endpoint for the bytes that start it");
    auto bytes = device_.start;
    int sent = 0;
    const int code =
        libusb_bulk_transfer(handle_, route_.out, bytes.data(), static_cast<int>(bytes.size()), &sent, control_timeout);
    if (code != 0) fail(device_, "sending the bytes that start it", code);
  }

  // CDC PSTN 1.2, 6.3.10 and 6.3.12: 8 data bits, no parity, one stop bit; DTR says that somebody listens.
  void prepare_cdc() {
    std::array<std::uint8_t, 7> coding{};
    for (std::size_t i = 0; i < 4; ++i) coding[i] = static_cast<std::uint8_t>(device_.baud >> 8 * i);
    coding[6] = 8;
    constexpr std::uint8_t to_interface = 0x21;  // class request to an interface
    control(to_interface, 0x20, 0, route_.control_interface, coding.data(), coding.size(), "setting its line coding");
    control(to_interface, 0x22, 1, route_.control_interface, nullptr, 0, "raising DTR");
  }

  // FTDI's vendor requests: reset, baud, 8N1, DTR, and a latency timer of 1 ms in place of 16.
  void prepare_ftdi() {
    constexpr std::uint8_t vendor = 0x40;  // vendor request to the device
    const int port = route_.data_interface + 1;
    const std::uint32_t divisor = ftdi_divisor(device_.baud);
    control(vendor, 0, 0, port, nullptr, 0, "resetting it");
    control(vendor, 3, static_cast<int>(divisor & 0xFFFF), static_cast<int>(divisor >> 16), nullptr, 0,
            "setting its baud rate");
    control(vendor, 4, 8, port, nullptr, 0, "setting 8N1");
    control(vendor, 1, 0x0101, port, nullptr, 0, "raising DTR");
    control(vendor, 9, 1, port, nullptr, 0, "setting its latency timer");
  }

  void control(std::uint8_t type, std::uint8_t request, int value, int index, std::uint8_t* data, std::size_t length,
               const char* what) {
    const int code = libusb_control_transfer(handle_, type, request, static_cast<std::uint16_t>(value),
                                             static_cast<std::uint16_t>(index), data,
                                             static_cast<std::uint16_t>(length), control_timeout);
    if (code < 0) fail(device_, what, code);
  }

  void close() {
    if (handle_ == nullptr) return;
    for (const int interface : {route_.data_interface, route_.control_interface})
      if (interface >= 0) libusb_release_interface(handle_, interface);
    libusb_close(handle_);
    handle_ = nullptr;
  }

  UsbDevice device_;
  libusb_device_handle* handle_ = nullptr;
  Route route_;
};

class Context {
 public:
  Context() {
    if (const int code = libusb_init(&context_); code != 0)
      throw SourceError(std::string("USB: libusb_init: ") + libusb_error_name(code));
  }
  ~Context() { libusb_exit(context_); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  libusb_context* get() const { return context_; }

 private:
  libusb_context* context_ = nullptr;
};

/// Keeps transfers in flight. All libusb calls after construction are made by one thread; the reader only takes packets
/// from the ring.
class UsbSource final : public FrameSource {
 public:
  explicit UsbSource(const UsbDevice& device)
      : device_(device), opened_(std::make_unique<OpenDevice>(context_->get(), device)), ring_(ring_slots, 1024) {
    make_transfers();
    listen_for_arrival();
    thread_ = std::thread([this] { pump(); });
  }
  ~UsbSource() override {
    stopping_ = true;
    thread_.join();
    free_transfers();
  }

  std::optional<Packet> wait(double timeout) override {
    if (!ready_.try_acquire_for(std::chrono::duration<double>(timeout))) return std::nullopt;
    return ring_.take();
  }
  bool finished() const override { return false; }
  bool live() const override { return true; }
  double now() const override { return std::chrono::duration<double>(Clock::now() - zero_).count(); }
  TransportCounts counts() const override {
    return {packets_.load(), bytes_.load(), overruns_.load(), stalls_.load(), errors_.load(), reconnects_.load()};
  }

 private:
  struct Slot {
    UsbSource* source = nullptr;
    libusb_transfer* transfer = nullptr;
    bool busy = false;
    std::array<std::uint8_t, 1024> bytes{};
  };

  void make_transfers() {
    for (Slot& slot : slots_) {
      slot.source = this;
      slot.transfer = libusb_alloc_transfer(0);
      if (slot.transfer == nullptr) throw SourceError("USB: no memory for transfers");
    }
  }

  void free_transfers() {
    for (Slot& slot : slots_)
      if (!slot.busy) libusb_free_transfer(slot.transfer);  // one that never came back still belongs to libusb
  }

  // Only a hint that makes reopening quicker: libusb may report an arrival twice, or not at all without udev.
  void listen_for_arrival() {
    if (!libusb_has_capability(LIBUSB_CAP_HAS_HOTPLUG)) return;
    const auto arrived = [](libusb_context*, libusb_device*, libusb_hotplug_event, void* self) {
      static_cast<UsbSource*>(self)->arrived_ = true;
      return 0;
    };
    libusb_hotplug_register_callback(context_->get(), LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED, LIBUSB_HOTPLUG_NO_FLAGS,
                                     device_.vendor, device_.product, LIBUSB_HOTPLUG_MATCH_ANY, arrived, this, nullptr);
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
    stop();
  }

  void handle_events() {
    timeval limit{0, 1000 * poll_ms};
    libusb_handle_events_timeout_completed(context_->get(), &limit, nullptr);
  }

  void submit_all() {
    cancelling_ = false;
    for (Slot& slot : slots_) {
      if (gone_ || slot.busy) continue;
      const Route& route = opened_->route();
      const int length = std::min<int>(route.packet, static_cast<int>(slot.bytes.size()));
      const auto fill = route.in_is_interrupt ? libusb_fill_interrupt_transfer : libusb_fill_bulk_transfer;
      fill(slot.transfer, opened_->handle(), route.in, slot.bytes.data(), length, completed, &slot, 0);
      submit(slot);
    }
  }

  void submit(Slot& slot) {
    const int code = libusb_submit_transfer(slot.transfer);
    slot.busy = code == 0;
    if (code == 0) {
      ++busy_;
    } else if (code != LIBUSB_ERROR_NO_MEM && code != LIBUSB_ERROR_BUSY) {
      gone_ = true;  // with NO_MEM fewer are in flight, and the rest go on
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
        errors_in_a_row_ = 0, take(slot);
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
    // A dropped packet's permit stands for the new one: there are as many permits as packets.
    if (ring_.push({bytes, now(), gap_})) {
      ++overruns_;
    } else {
      ready_.release();
    }
    gap_ = false;
  }

  void cancel_all() {
    if (cancelling_) return;
    cancelling_ = true;
    for (Slot& slot : slots_)
      if (slot.busy) libusb_cancel_transfer(slot.transfer);
  }

  void clear_halt() {
    halted_ = false;
    ++stalls_;
    gap_ = true;
    gone_ = libusb_clear_halt(opened_->handle(), opened_->route().in) == LIBUSB_ERROR_NO_DEVICE;
  }

  // While the device is away: at each arrival, and every half second.
  void reopen() {
    const auto now = Clock::now();
    const bool arrived = arrived_.exchange(false);
    if (!arrived && now < next_try_) return;
    next_try_ = now + reopen_every;
    try {
      if (!arrived) look_again();
      opened_ = std::make_unique<OpenDevice>(context_->get(), device_);
    } catch (const SourceError&) {
      return;  // not there yet, or not ready
    }
    gone_ = halted_ = false;
    errors_in_a_row_ = 0;
    gap_ = true;
    ++reconnects_;
    submit_all();
  }

  // libusb learns of new devices from the udev daemon alone. Where none runs (a container), only a new context sees
  // them. A transfer keeps hold of the device it was last used for, and that of its context: no transfer may outlive
  // it.
  void look_again() {
    auto fresh = std::make_unique<Context>();
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

  std::unique_ptr<Context> context_ = std::make_unique<Context>();
  UsbDevice device_;
  std::unique_ptr<OpenDevice> opened_;  ///< null while the device is away
  PacketRing ring_;
  std::counting_semaphore<> ready_{0};
  std::array<Slot, in_flight> slots_;
  const Clock::time_point zero_ = Clock::now();
  int busy_ = 0, errors_in_a_row_ = 0;
  bool gone_ = false, halted_ = false, cancelling_ = false, gap_ = false;
  Clock::time_point next_try_{};
  std::atomic<bool> stopping_{false}, arrived_{false};
  std::atomic<std::uint64_t> packets_{0}, bytes_{0}, overruns_{0}, stalls_{0}, errors_{0}, reconnects_{0};
  std::thread thread_;
};

}  // namespace

std::unique_ptr<FrameSource> open_usb(const UsbDevice& device) { return std::make_unique<UsbSource>(device); }

}  // namespace tactel::hw
