#include "tests/hw/usb/emulated_glove.h"

#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <string>

namespace tactel::hw::testing {
namespace {

constexpr const char* node = "/dev/bus/usb/001/002";
constexpr std::size_t packet_bytes = 64;

// Device 04D8:000A. Interface 0: CDC, endpoint 82 interrupt IN, 8 B. Interface 1: data, 03 bulk OUT and 83 bulk IN, 64
// B.
constexpr const char* descriptors =
    "12010002020000"
    "40"
    "D8040A00000100000001"
    "0902430002010080"
    "32"
    "0904000001020201"
    "00"
    "0524001001"
    "05240101"
    "01"
    "04240202"
    "0524060001"
    "07058203080002"
    "09040100020A0000"
    "00"
    "07050302400000"
    "07058302400000";

std::string description() {
  return std::string(
             "P: /devices/usb1/1-1\nN: bus/usb/001/002\nE: SUBSYSTEM=usb\nE: DRIVER=usb\nE: BUSNUM=001\n"
             "E: DEVNUM=002\nE: DEVNAME=/dev/bus/usb/001/002\nE: DEVTYPE=usb_device\nA: bConfigurationValue=1\\n\n"
             "A: busnum=1\\n\nA: devnum=2\\n\nA: speed=12\\n\nH: descriptors=") +
         descriptors + "\n";
}

}  // namespace

/// A request of libusb's that has not been handed back.
struct EmulatedGlove::Urb {
  UMockdevIoctlData* request;  ///< the caller's usbdevfs_urb
  UMockdevIoctlData* buffer;   ///< and its data
  bool done = false;
  usbdevfs_urb* fields() const { return reinterpret_cast<usbdevfs_urb*>(request->data); }
};

EmulatedGlove::EmulatedGlove() : testbed_(umockdev_testbed_new()), handler_(umockdev_ioctl_base_new()) {
  g_signal_connect(handler_, "handle-ioctl", G_CALLBACK(on_ioctl), this);
  plug_in();
  GError* error = nullptr;
  if (!umockdev_testbed_attach_ioctl(testbed_, node, handler_, &error)) throw std::runtime_error(error->message);
}

EmulatedGlove::~EmulatedGlove() {
  g_object_unref(testbed_);
  g_object_unref(handler_);
}

void EmulatedGlove::plug_in() {
  {
    const std::lock_guard lock(mutex_);
    away_ = halted_ = false;
  }
  GError* error = nullptr;
  if (!umockdev_testbed_add_from_string(testbed_, description().c_str(), &error))
    throw std::runtime_error(error->message);
}

// What is in flight comes back with the status of a device that went; then there is nothing to open.
void EmulatedGlove::unplug() {
  {
    const std::lock_guard lock(mutex_);
    away_ = true;
  }
  umockdev_testbed_uevent(testbed_, "/sys/devices/usb1/1-1", "remove");
  umockdev_testbed_remove_device(testbed_, "/sys/devices/usb1/1-1");
}

void EmulatedGlove::send(std::vector<std::uint8_t> stream) {
  const std::lock_guard lock(mutex_);
  stream_ = std::move(stream);
  sent_ = packet_ = 0;
}

void EmulatedGlove::fault_at(std::size_t packet, Fault fault) { faults_.emplace_back(packet, fault); }

std::size_t EmulatedGlove::in_flight() {
  const std::lock_guard lock(mutex_);
  return urbs_.size();
}

gboolean EmulatedGlove::on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
  return static_cast<EmulatedGlove*>(self)->answer(client);
}

bool EmulatedGlove::answer(UMockdevIoctlClient* client) {
  const std::lock_guard lock(mutex_);
  const auto request = static_cast<unsigned>(umockdev_ioctl_client_get_request(client));
  const auto complete = [&](int result, int code) { umockdev_ioctl_client_complete(client, result, code); };
  switch (request) {
    case USBDEVFS_SUBMITURB:
      submit(client);
      return true;
    case USBDEVFS_REAPURBNDELAY:
      reap(client);
      return true;
    case USBDEVFS_DISCARDURB:
      discard(client);
      return true;
    case USBDEVFS_GET_CAPABILITIES: {
      UMockdevIoctlData* data = umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, 4, nullptr);
      *reinterpret_cast<std::uint32_t*>(data->data) = 0;
      complete(0, 0);
      return true;
    }
    case USBDEVFS_DISCONNECT_CLAIM:
    case USBDEVFS_CLAIMINTERFACE:
      ++claimed_;
      complete(0, 0);
      return true;
    case USBDEVFS_RELEASEINTERFACE:
      --claimed_;
      complete(0, 0);
      return true;
    case USBDEVFS_CLEAR_HALT:
      ++halts_cleared_, halted_ = false;
      complete(0, 0);
      return true;
    case USBDEVFS_GETDRIVER:
      complete(-1, ENODATA);
      return true;
    case USBDEVFS_SETINTERFACE:
    case USBDEVFS_RESET:
      complete(0, 0);
      return true;
    default:
      complete(-1, ENOTTY);
      return true;
  }
}

void EmulatedGlove::submit(UMockdevIoctlClient* client) {
  if (away_) return umockdev_ioctl_client_complete(client, -1, ENODEV);
  UMockdevIoctlData* request =
      umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, sizeof(usbdevfs_urb), nullptr);
  const auto* fields = reinterpret_cast<const usbdevfs_urb*>(request->data);
  UMockdevIoctlData* buffer =
      umockdev_ioctl_data_resolve(request, offsetof(usbdevfs_urb, buffer), fields->buffer_length, nullptr);
  urbs_.push_back({UMOCKDEV_IOCTL_DATA(g_object_ref(request)), UMOCKDEV_IOCTL_DATA(g_object_ref(buffer))});
  most_in_flight_ = std::max<std::size_t>(most_in_flight_, urbs_.size());
  umockdev_ioctl_client_complete(client, 0, 0);
}

// The oldest that is done or can be done now.
void EmulatedGlove::reap(UMockdevIoctlClient* client) {
  auto urb = std::ranges::find_if(urbs_, [](const Urb& u) { return u.done; });
  if (urb == urbs_.end() && !urbs_.empty() && fill(urbs_.front())) urb = urbs_.begin();
  if (urb == urbs_.end()) return umockdev_ioctl_client_complete(client, -1, EAGAIN);
  UMockdevIoctlData* where =
      umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, sizeof(gpointer), nullptr);
  umockdev_ioctl_data_set_ptr(where, 0, urb->request);
  umockdev_ioctl_client_complete(client, 0, 0);
  g_object_unref(urb->request);
  g_object_unref(urb->buffer);
  urbs_.erase(urb);
}

void EmulatedGlove::discard(UMockdevIoctlClient* client) {
  const auto address = *reinterpret_cast<gulong*>(umockdev_ioctl_client_get_arg(client)->data);
  for (Urb& urb : urbs_) {
    if (urb.request->client_addr != address || urb.done) continue;
    urb.fields()->status = -ENOENT;
    urb.fields()->actual_length = 0;
    urb.done = true;
    return umockdev_ioctl_client_complete(client, 0, 0);
  }
  umockdev_ioctl_client_complete(client, -1, EINVAL);
}

/// Completes the request if the device has something to say to it.
bool EmulatedGlove::fill(Urb& urb) {
  usbdevfs_urb& fields = *urb.fields();
  const auto end_with = [&](int status, std::size_t length) {
    fields.status = status;
    fields.actual_length = static_cast<int>(length);
    return urb.done = true;
  };
  if (away_) return end_with(-ESHUTDOWN, 0);
  if (fields.type == USBDEVFS_URB_TYPE_CONTROL) {  // setup: type, request, value, index, length
    if (urb.buffer->data[1] == 0x22) dtr_ = (urb.buffer->data[2] & 1) != 0;
    return end_with(0, static_cast<std::size_t>(fields.buffer_length) - 8);
  }
  if (halted_) return end_with(-EPIPE, 0);
  for (auto fault = faults_.begin(); fault != faults_.end(); ++fault) {
    if (fault->first != packet_) continue;
    const Fault what = fault->second;
    faults_.erase(fault);
    if (what == Fault::drop) {
      sent_ += packet_bytes, ++packet_;
      break;
    }
    halted_ = what == Fault::stall;
    return end_with(what == Fault::stall ? -EPIPE : what == Fault::babble ? -EOVERFLOW : -EPROTO, 0);
  }
  if (sent_ >= stream_.size()) return false;
  const std::size_t length =
      std::min({packet_bytes, stream_.size() - sent_, static_cast<std::size_t>(fields.buffer_length)});
  std::memcpy(urb.buffer->data, stream_.data() + sent_, length);
  sent_ += length, ++packet_;
  return end_with(0, length);
}

}  // namespace tactel::hw::testing
