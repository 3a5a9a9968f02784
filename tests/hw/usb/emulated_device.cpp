// SPDX-License-Identifier: Apache-2.0
#include "tests/hw/usb/emulated_device.h"

#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <stdexcept>
#include <string>

namespace tactel::hw::tests {
namespace {

constexpr std::size_t setup_bytes = 8;
constexpr std::uint8_t get_descriptor = 6, string_descriptor = 3, serial_index = 3;

/// umockdev has one tree of devices at a time: those that live together share it.
std::shared_ptr<UMockdevTestbed> shared_testbed() {
  static std::weak_ptr<UMockdevTestbed> alive;
  if (auto testbed = alive.lock()) return testbed;
  std::shared_ptr<UMockdevTestbed> fresh(umockdev_testbed_new(), g_object_unref);
  alive = fresh;
  return fresh;
}

template <class T>
T& as(UMockdevIoctlData* data) {
  return *reinterpret_cast<T*>(data->data);
}

UMockdevIoctlData* argument(UMockdevIoctlClient* client, std::size_t bytes) {
  return umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, bytes, nullptr);
}

}  // namespace

/// A request of libusb's that has not been handed back.
struct EmulatedDevice::Urb {
  UMockdevIoctlData* request;  ///< the caller's usbdevfs_urb
  UMockdevIoctlData* buffer;   ///< and its data
  bool done = false;

  usbdevfs_urb& fields() const { return as<usbdevfs_urb>(request); }
  bool end_with(int status, std::size_t length) {
    fields().status = status;
    fields().actual_length = static_cast<int>(length);
    return done = true;
  }
};

// Each emulated ioctl ends in usleep(0): with the usual slack of timers that is 50 us. Threads inherit the slack.
EmulatedDevice::EmulatedDevice(const DeviceKind& kind, int port, std::string serial)
    : kind_(kind), port_(port), serial_(std::move(serial)) {
  prctl(PR_SET_TIMERSLACK, 1);
  testbed_ = shared_testbed();
  handler_ = umockdev_ioctl_base_new();
  g_signal_connect(handler_, "handle-ioctl", G_CALLBACK(on_ioctl), this);
  plug_in();
}

EmulatedDevice::~EmulatedDevice() {
  stop_clock();
  if (!away_) unplug();
  testbed_.reset();
  g_object_unref(handler_);
}

std::string EmulatedDevice::node() const { return "/dev/bus/usb/001/00" + std::to_string(port_ + 1); }
std::string EmulatedDevice::in_sysfs() const { return "/sys/devices/usb1/1-" + std::to_string(port_); }

std::string EmulatedDevice::description() const {
  std::string descriptors = kind_.descriptors;
  std::erase(descriptors, ' ');
  if (!serial_.empty()) descriptors.replace(2 * 16, 2, "03");  // iSerialNumber
  const std::string number = std::to_string(port_ + 1);
  return "P: /devices/usb1/1-" + std::to_string(port_) + "\nN: bus/usb/001/00" + number +
         "\nE: SUBSYSTEM=usb\nE: DRIVER=usb\nE: BUSNUM=001\nE: DEVNUM=00" + number + "\nE: DEVNAME=" + node() +
         "\nE: DEVTYPE=usb_device\nA: bConfigurationValue=1\\n\nA: busnum=1\\n\n"
         "A: devnum=" +
         number + "\\n\nA: speed=" + std::to_string(kind_.megabits) + "\\n\nH: descriptors=" + descriptors + "\n";
}

void EmulatedDevice::plug_in_at(int port) {
  port_ = port;
  plug_in();
}

void EmulatedDevice::plug_in() {
  GError* error = nullptr;
  const std::lock_guard lock(mutex_);
  away_ = halted_ = false;
  if (!umockdev_testbed_add_from_string(testbed_.get(), description().c_str(), &error))
    throw std::runtime_error(error->message);
  gchar* root = umockdev_testbed_get_root_dir(testbed_.get());
  node_ = std::make_unique<TerminalNode>(std::string(root) + node());
  g_free(root);
  if (attached_.contains(port_)) return;
  if (!umockdev_testbed_attach_ioctl(testbed_.get(), node().c_str(), handler_, &error))
    throw std::runtime_error(error->message);
  attached_.insert(port_);
}

// What is in flight comes back with the status of a device that went; then there is nothing to open.
void EmulatedDevice::unplug() {
  {
    const std::lock_guard lock(mutex_);
    away_ = true;
    serve();
    node_.reset();
  }
  umockdev_testbed_uevent(testbed_.get(), in_sysfs().c_str(), "remove");
  umockdev_testbed_remove_device(testbed_.get(), in_sysfs().c_str());
}

void EmulatedDevice::send(const ByteVector& stream) {
  const std::size_t room = kind_.packet - kind_.before_each.size();
  std::vector<ByteVector> packets;
  for (std::size_t at = 0; at < stream.size(); at += room) {
    packets.push_back(kind_.before_each);
    const auto from = stream.begin() + static_cast<std::ptrdiff_t>(at);
    packets.back().insert(packets.back().end(), from,
                          from + static_cast<std::ptrdiff_t>(std::min(room, stream.size() - at)));
  }
  send_packets(packets);
}

void EmulatedDevice::send_packets(const std::vector<ByteVector>& packets) {
  const std::lock_guard lock(mutex_);
  packets_.assign(packets.begin(), packets.end());
  fetched_ = 0;
  serve();
}

void EmulatedDevice::send_by_clock(std::chrono::nanoseconds period, std::size_t queue,
                                   std::function<void(std::size_t i, ByteVector& packet)> make) {
  clock_ = std::thread([=, this] { tick(period, queue, make); });
}

void EmulatedDevice::stop_clock() {
  stopping_ = true;
  if (clock_.joinable()) clock_.join();
}

void EmulatedDevice::tick(std::chrono::nanoseconds period, std::size_t queue,
                          const std::function<void(std::size_t, ByteVector&)>& make) {
  const auto start = std::chrono::steady_clock::now();
  ByteVector packet;
  for (std::size_t i = 0; !stopping_; ++i) {
    std::this_thread::sleep_until(start + (i + 1) * period);
    packet = kind_.before_each;
    make(i, packet);
    const std::lock_guard lock(mutex_);
    if (packets_.size() < queue) {
      packets_.push_back(packet);
    } else {
      ++lost_;
    }
    serve();
  }
}

void EmulatedDevice::fault_at(std::size_t packet, Fault fault) {
  const std::lock_guard lock(mutex_);
  faults_.emplace_back(packet, fault);
}

std::vector<ControlRequest> EmulatedDevice::control_requests() {
  const std::lock_guard lock(mutex_);
  return control_;
}

ByteVector EmulatedDevice::received() {
  const std::lock_guard lock(mutex_);
  return received_;
}

std::size_t EmulatedDevice::waiting() {
  const std::lock_guard lock(mutex_);
  return packets_.size();
}

std::size_t EmulatedDevice::in_flight() {
  const std::lock_guard lock(mutex_);
  return urbs_.size();
}

gboolean EmulatedDevice::on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
  static_cast<EmulatedDevice*>(self)->answer(client);
  return true;
}

void EmulatedDevice::answer(UMockdevIoctlClient* client) {
  const std::lock_guard lock(mutex_);
  ++ioctls_;
  switch (static_cast<unsigned>(umockdev_ioctl_client_get_request(client))) {
    case USBDEVFS_SUBMITURB:
      return submit(client);
    case USBDEVFS_REAPURBNDELAY:
      return reap(client);
    case USBDEVFS_DISCARDURB:
      return discard(client);
    case USBDEVFS_GET_CAPABILITIES:
      as<std::uint32_t>(argument(client, 4)) = USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
      break;
    case USBDEVFS_DISCONNECT_CLAIM:
    case USBDEVFS_CLAIMINTERFACE:
      if (busy_) return umockdev_ioctl_client_complete(client, -1, EBUSY);
      ++claimed_;
      break;
    case USBDEVFS_RELEASEINTERFACE:
      --claimed_;
      break;
    case USBDEVFS_CLEAR_HALT:
      ++halts_cleared_, halted_ = stuck_;
      serve();
      break;
    case USBDEVFS_SETINTERFACE:
    case USBDEVFS_RESET:
      break;
    case USBDEVFS_GETDRIVER:
      return umockdev_ioctl_client_complete(client, -1, ENODATA);
    default:
      return umockdev_ioctl_client_complete(client, -1, ENOTTY);
  }
  umockdev_ioctl_client_complete(client, 0, 0);
}

void EmulatedDevice::submit(UMockdevIoctlClient* client) {
  if (away_) return umockdev_ioctl_client_complete(client, -1, ENODEV);
  UMockdevIoctlData* request = argument(client, sizeof(usbdevfs_urb));
  const auto& fields = as<const usbdevfs_urb>(request);
  UMockdevIoctlData* buffer =
      umockdev_ioctl_data_resolve(request, offsetof(usbdevfs_urb, buffer), fields.buffer_length, nullptr);
  urbs_.push_back({UMOCKDEV_IOCTL_DATA(g_object_ref(request)), UMOCKDEV_IOCTL_DATA(g_object_ref(buffer))});
  most_in_flight_ = std::max<std::size_t>(most_in_flight_, urbs_.size());
  interrupt_requests_ += fields.type == USBDEVFS_URB_TYPE_INTERRUPT;
  serve();
  umockdev_ioctl_client_complete(client, 0, 0);
}

void EmulatedDevice::reap(UMockdevIoctlClient* client) {
  const auto urb = std::ranges::find_if(urbs_, &Urb::done);
  if (urb == urbs_.end()) return umockdev_ioctl_client_complete(client, -1, away_ ? ENODEV : EAGAIN);
  umockdev_ioctl_data_set_ptr(argument(client, sizeof(gpointer)), 0, urb->request);
  umockdev_ioctl_client_complete(client, 0, 0);
  g_object_unref(urb->request);
  g_object_unref(urb->buffer);
  urbs_.erase(urb);
  serve();
}

void EmulatedDevice::discard(UMockdevIoctlClient* client) {
  const auto address = as<gulong>(umockdev_ioctl_client_get_arg(client));
  const auto urb =
      std::ranges::find_if(urbs_, [&](const Urb& u) { return !u.done && u.request->client_addr == address; });
  if (urb == urbs_.end()) return umockdev_ioctl_client_complete(client, -1, EINVAL);
  urb->end_with(-ENOENT, 0);
  serve();
  umockdev_ioctl_client_complete(client, 0, 0);
}

/// Completes what can be completed, in order, and says so on the node.
void EmulatedDevice::serve() {
  for (Urb& urb : urbs_)
    if (!urb.done) complete(urb);
  if (node_) node_->set_ready(std::ranges::any_of(urbs_, &Urb::done));
}

bool EmulatedDevice::complete(Urb& urb) {
  const usbdevfs_urb& fields = urb.fields();
  if (away_) return urb.end_with(-ESHUTDOWN, 0);
  if (fields.type == USBDEVFS_URB_TYPE_CONTROL) return complete_control(urb);
  if (fields.endpoint & 0x80) return complete_in(urb);
  received_.insert(received_.end(), urb.buffer->data, urb.buffer->data + fields.buffer_length);
  return urb.end_with(0, static_cast<std::size_t>(fields.buffer_length));
}

bool EmulatedDevice::complete_control(Urb& urb) {
  const std::uint8_t* setup = urb.buffer->data;
  const auto length = static_cast<std::size_t>(urb.fields().buffer_length);
  const auto number = [&](int at) { return static_cast<std::uint16_t>(setup[at] | setup[at + 1] << 8); };
  if (setup[0] == 0x80 && setup[1] == get_descriptor && setup[3] == string_descriptor)
    return complete_string(urb, setup[2]);
  control_.push_back({setup[0], setup[1], number(2), number(4), ByteVector(setup + setup_bytes, setup + length)});
  return urb.end_with(0, length - setup_bytes);
}

/// USB 2.0, 9.6.7: index 0 lists the languages, the others are UTF-16.
bool EmulatedDevice::complete_string(Urb& urb, int index) {
  ByteVector text{0, string_descriptor};
  if (index == 0) append(text, {0x09, 0x04});
  if (index == serial_index)
    for (const char c : serial_) append(text, {static_cast<std::uint8_t>(c), 0});
  text[0] = static_cast<std::uint8_t>(text.size());
  const auto room = static_cast<std::size_t>(urb.fields().buffer_length) - setup_bytes;
  const std::size_t length = std::min(room, text.size());
  std::copy_n(text.begin(), length, urb.buffer->data + setup_bytes);
  return urb.end_with(0, length);
}

bool EmulatedDevice::complete_in(Urb& urb) {
  if (halted_) return urb.end_with(-EPIPE, 0);
  const auto fault = std::ranges::find(faults_, fetched_, &std::pair<std::size_t, Fault>::first);
  if (fault != faults_.end() && !packets_.empty()) {
    const Fault what = fault->second;
    faults_.erase(fault);
    if (what != Fault::drop) {
      halted_ = what == Fault::stall;
      return urb.end_with(what == Fault::stall ? -EPIPE : what == Fault::babble ? -EOVERFLOW : -EPROTO, 0);
    }
    packets_.pop_front();
    ++fetched_;
  }
  if (packets_.empty()) return false;
  const ByteVector packet = std::move(packets_.front());
  packets_.pop_front();
  ++fetched_;
  const auto room = static_cast<std::size_t>(urb.fields().buffer_length);
  if (packet.size() > room) return urb.end_with(-EOVERFLOW, 0);
  std::ranges::copy(packet, urb.buffer->data);
  return urb.end_with(0, packet.size());
}

}  // namespace tactel::hw::tests
