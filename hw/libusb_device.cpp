// SPDX-License-Identifier: Apache-2.0
#include "hw/libusb_device.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <optional>
#include <thread>
#include <vector>

#include "hw/usb_source.h"

namespace tactel::hw {
namespace {

constexpr unsigned control_timeout = 500;  // ms

std::string id_text(const UsbDevice& device) {
  std::array<char, 16> text;
  std::snprintf(text.data(), text.size(), "%04x:%04x", device.vendor, device.product);
  return text.data();
}

[[noreturn]] void fail(const UsbDevice& device, const std::string& what) {
  throw SourceError("USB " + id_text(device) + ": " + what);
}

[[noreturn]] void fail(const UsbDevice& device, const std::string& call, int code, const std::string& advice = "") {
  fail(device, call + ": " + libusb_error_name(code) + (advice.empty() ? "" : "; " + advice));
}

bool carries_frames(const libusb_endpoint_descriptor& endpoint, const UsbDevice& device) {
  const int kind = endpoint.bmAttributes & LIBUSB_TRANSFER_TYPE_MASK;
  const bool in = endpoint.bEndpointAddress & LIBUSB_ENDPOINT_IN;
  const bool streams = kind == LIBUSB_TRANSFER_TYPE_BULK || kind == LIBUSB_TRANSFER_TYPE_INTERRUPT;
  return in && streams && (device.endpoint < 0 || device.endpoint == endpoint.bEndpointAddress);
}

/// Takes the interface's endpoints into the route if one of them carries frames.
void consider(const libusb_interface_descriptor& interface, const UsbDevice& device, UsbRoute& route) {
  if (interface.bInterfaceClass == LIBUSB_CLASS_COMM && route.control_interface < 0)
    route.control_interface = interface.bInterfaceNumber;
  const bool asked = device.interface < 0 || device.interface == interface.bInterfaceNumber;
  const bool fits = device.transport != Transport::cdc_acm || interface.bInterfaceClass == LIBUSB_CLASS_DATA;
  if (route.data_interface >= 0 || !asked || !fits) return;
  UsbRoute found = route;
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

UsbRoute find_route(libusb_device* usb, const UsbDevice& device) {
  libusb_config_descriptor* config = nullptr;
  if (const int code = libusb_get_active_config_descriptor(usb, &config); code != 0)
    fail(device, "reading its descriptor", code);
  UsbRoute route;
  for (int i = 0; i < config->bNumInterfaces; ++i)
    if (config->interface[i].num_altsetting > 0) consider(config->interface[i].altsetting[0], device, route);
  libusb_free_config_descriptor(config);
  if (route.data_interface < 0) fail(device, "no interface with the IN endpoint of its profile");
  return route;
}

libusb_device_descriptor descriptor_of(libusb_device* usb) {
  libusb_device_descriptor descriptor{};
  libusb_get_device_descriptor(usb, &descriptor);
  return descriptor;
}

/// "1-2.3"; a root hub, which has no port, is "1".
std::string port_of(libusb_device* usb) {
  std::array<std::uint8_t, 8> ports;  // USB 3.0 allows seven
  const int depth = libusb_get_port_numbers(usb, ports.data(), ports.size());
  std::string text = std::to_string(libusb_get_bus_number(usb));
  for (int i = 0; i < depth; ++i) text += (i == 0 ? "-" : ".") + std::to_string(ports[static_cast<std::size_t>(i)]);
  return text;
}

/// The devices that are plugged in, by port: all, or those of one vendor and product.
class Candidates {
 public:
  explicit Candidates(libusb_context* context, const UsbDevice* wanted = nullptr) {
    const ssize_t count = libusb_get_device_list(context, &list_);
    for (ssize_t i = 0; i < count; ++i) {
      const libusb_device_descriptor descriptor = descriptor_of(list_[i]);
      if (!wanted || (descriptor.idVendor == wanted->vendor && descriptor.idProduct == wanted->product))
        all_.emplace_back(port_of(list_[i]), list_[i]);
    }
    std::ranges::stable_sort(all_, {}, &Candidate::first);
  }
  ~Candidates() {
    if (list_ != nullptr) libusb_free_device_list(list_, 1);
  }
  Candidates(const Candidates&) = delete;
  Candidates& operator=(const Candidates&) = delete;

  using Candidate = std::pair<std::string, libusb_device*>;  // port
  const std::vector<Candidate>& all() const { return all_; }

 private:
  libusb_device** list_ = nullptr;
  std::vector<Candidate> all_;
};

std::string listed(const std::vector<UsbChoice::Other>& others) {
  std::string text;
  for (const UsbChoice::Other& other : others)
    text += (text.empty() ? "" : "; ") + place_text(other.place) + (other.refusal.empty() ? "" : ": " + other.refusal);
  return text;
}

[[noreturn]] void refuse(const UsbDevice& wanted, const std::vector<UsbChoice::Other>& others) {
  if (others.empty())
    fail(wanted, "looking for it", LIBUSB_ERROR_NO_DEVICE,
         "connect it: `lsusb -d " + id_text(wanted) + "` lists it once the system has found it");
  if (others.size() == 1 && !others.front().refusal.empty()) throw SourceError(others.front().refusal);
  const std::string asked = (wanted.serial.empty() ? "" : " with serial number " + wanted.serial) +
                            (wanted.port.empty() ? "" : " at port " + wanted.port);
  fail(wanted, (asked.empty() ? "none is free" : "no free one" + asked) + "; connected are: " + listed(others));
}

/// Opens the device if it is the wanted one; otherwise describes it in `other`.
std::unique_ptr<LibusbDevice> try_to_open(libusb_device* usb, const UsbDevice& wanted, UsbChoice::Other& other) {
  if (!wanted.port.empty() && wanted.port != other.place.port) return nullptr;
  try {
    auto device = std::make_unique<LibusbDevice>(usb, wanted);
    other.place.serial = device->serial();
    if (!wanted.serial.empty() && wanted.serial != other.place.serial) return nullptr;
    device->prepare();
    return device;
  } catch (const SourceError& error) {
    other.refusal = error.what();
    return nullptr;
  }
}

/// Whether a device of this class may send frames of a sensor: the vendor's own classes, and serial ports.
bool may_be_sensor(std::uint8_t device_class) {
  return device_class == LIBUSB_CLASS_PER_INTERFACE || device_class == LIBUSB_CLASS_COMM ||
         device_class == LIBUSB_CLASS_DATA || device_class == LIBUSB_CLASS_VENDOR_SPEC ||
         device_class == 0xEF;  // miscellaneous: several interfaces
}

/// The device as a list has it; none where no interface may send frames.
std::optional<ListedUsb> listed(libusb_device* usb, const std::string& port) {
  const libusb_device_descriptor descriptor = descriptor_of(usb);
  libusb_config_descriptor* config = nullptr;
  if (!may_be_sensor(descriptor.bDeviceClass) || libusb_get_active_config_descriptor(usb, &config) != 0) return {};
  ListedUsb device{.vendor = descriptor.idVendor, .product = descriptor.idProduct, .place = {port, ""}};
  bool sends = false;
  for (int i = 0; i < config->bNumInterfaces; ++i) {
    if (config->interface[i].num_altsetting == 0) continue;
    const libusb_interface_descriptor& interface = config->interface[i].altsetting[0];
    device.is_serial = device.is_serial || interface.bInterfaceClass == LIBUSB_CLASS_COMM;
    if (interface.bInterfaceClass != LIBUSB_CLASS_DATA && interface.bInterfaceClass != LIBUSB_CLASS_VENDOR_SPEC)
      continue;
    for (int e = 0; e < interface.bNumEndpoints; ++e) sends = sends || carries_frames(interface.endpoint[e], {});
  }
  libusb_free_config_descriptor(config);
  if (!sends) return {};
  try {
    const LibusbDevice opened(usb, {.vendor = device.vendor, .product = device.product});
    device.place.serial = opened.serial(), device.name = opened.name();
  } catch (const SourceError& error) {
    device.refusal = error.what();
  }
  return device;
}

/// The serial number of a device that is not to be used; empty where it may not be opened.
std::string serial_of(libusb_device* usb, const UsbDevice& wanted) {
  try {
    return LibusbDevice(usb, wanted).serial();
  } catch (const SourceError&) {
    return "";
  }
}

}  // namespace

std::string place_text(const UsbPlace& place) {
  return "port " + place.port + (place.serial.empty() ? "" : " (serial number " + place.serial + ")");
}

LibusbContext new_context() {
  libusb_context* context = nullptr;
  if (const int code = libusb_init(&context); code != 0)
    throw SourceError(std::string("USB: libusb_init: ") + libusb_error_name(code));
  return LibusbContext(context);
}

LibusbDevice::LibusbDevice(libusb_device* usb, const UsbDevice& wanted) : wanted_(wanted) {
  const int code = libusb_open(usb, &handle_);
  if (code == LIBUSB_ERROR_ACCESS)
    fail(wanted, "opening it", code,
         "permission denied: copy scripts/70-tactel.rules, with a line for this device, to /etc/udev/rules.d/, "
         "run `udevadm control --reload` and reconnect it");
  if (code != 0) fail(wanted, "opening it", code);
}

LibusbDevice::~LibusbDevice() {
  for (const int interface : {route_.data_interface, route_.control_interface})
    if (interface >= 0) libusb_release_interface(handle_, interface);
  libusb_close(handle_);
}

// What a terminal would take for a command does not get through.
std::string LibusbDevice::text(std::uint8_t index, char least) const {
  if (index == 0) return "";
  std::array<unsigned char, 128> bytes;
  const int length = libusb_get_string_descriptor_ascii(handle_, index, bytes.data(), static_cast<int>(bytes.size()));
  std::string text(bytes.begin(), bytes.begin() + std::clamp<int>(length, 0, static_cast<int>(bytes.size())));
  std::erase_if(text, [least](char c) { return c < least || c > '~'; });
  return text;
}

std::string LibusbDevice::serial() const { return text(descriptor_of(libusb_get_device(handle_)).iSerialNumber, '!'); }

std::string LibusbDevice::name() const {
  const libusb_device_descriptor descriptor = descriptor_of(libusb_get_device(handle_));
  const std::string maker = text(descriptor.iManufacturer, ' '), product = text(descriptor.iProduct, ' ');
  return maker.empty() || product.empty() ? maker + product : maker + " " + product;
}

void LibusbDevice::prepare() {
  route_ = find_route(libusb_get_device(handle_), wanted_);
  claim();
  if (wanted_.transport == Transport::cdc_acm && route_.control_interface >= 0) prepare_cdc();
  if (wanted_.transport == Transport::ftdi) prepare_ftdi();
  if (wanted_.start.empty()) return;
  std::this_thread::sleep_for(std::chrono::duration<double>(wanted_.wait));
  send_start();
}

void LibusbDevice::claim() {
  libusb_set_auto_detach_kernel_driver(handle_, 1);  // gives the driver back when we release
  for (const int interface : {route_.control_interface, route_.data_interface}) {
    if (interface < 0 || (interface == route_.control_interface && wanted_.transport != Transport::cdc_acm)) continue;
    if (const int code = libusb_claim_interface(handle_, interface); code != 0)
      fail(wanted_, "claiming interface " + std::to_string(interface), code, "another program may use it");
  }
}

// CDC PSTN 1.2, 6.3.10 and 6.3.12: 8 data bits, no parity, one stop bit; DTR signals a listening host.
void LibusbDevice::prepare_cdc() {
  std::array<std::uint8_t, 7> coding{};
  for (std::size_t i = 0; i < 4; ++i) coding[i] = static_cast<std::uint8_t>(wanted_.baud >> 8 * i);
  coding[6] = 8;
  constexpr std::uint8_t to_interface = 0x21;  // class request to an interface
  control(to_interface, 0x20, 0, route_.control_interface, coding.data(), coding.size(), "setting its line coding");
  control(to_interface, 0x22, 1, route_.control_interface, nullptr, 0, "raising DTR");
}

// FTDI's vendor requests: reset, baud, 8N1, DTR, and a latency timer of 1 ms in place of 16.
void LibusbDevice::prepare_ftdi() {
  constexpr std::uint8_t vendor = 0x40;  // vendor request to the device
  const int port = route_.data_interface + 1;
  const std::uint32_t divisor = ftdi_divisor(wanted_.baud);
  control(vendor, 0, 0, port, nullptr, 0, "resetting it");
  control(vendor, 3, static_cast<int>(divisor & 0xFFFF), static_cast<int>(divisor >> 16), nullptr, 0,
          "setting its baud rate");
  control(vendor, 4, 8, port, nullptr, 0, "setting 8N1");
  control(vendor, 1, 0x0101, port, nullptr, 0, "raising DTR");
  control(vendor, 9, 1, port, nullptr, 0, "setting its latency timer");
}

void LibusbDevice::send_start() {
  if (route_.out == 0) fail(wanted_, "no OUT endpoint for the start bytes");
  auto bytes = wanted_.start;
  int sent = 0;
  const int code =
      libusb_bulk_transfer(handle_, route_.out, bytes.data(), static_cast<int>(bytes.size()), &sent, control_timeout);
  if (code != 0) fail(wanted_, "sending the start bytes", code);
  if (sent != static_cast<int>(bytes.size())) fail(wanted_, "it accepted only a part of the start bytes");
}

void LibusbDevice::control(std::uint8_t type, std::uint8_t request, int value, int index, std::uint8_t* data,
                           std::size_t length, const char* what) {
  const int code = libusb_control_transfer(handle_, type, request, static_cast<std::uint16_t>(value),
                                           static_cast<std::uint16_t>(index), data, static_cast<std::uint16_t>(length),
                                           control_timeout);
  if (code < 0) fail(wanted_, what, code);
}

std::vector<ListedUsb> list_usb() {
  const LibusbContext context = new_context();
  std::vector<ListedUsb> all;
  const Candidates candidates(context.get());
  for (const auto& [port, usb] : candidates.all())
    if (auto device = listed(usb, port)) all.push_back(std::move(*device));
  return all;
}

OpenedUsb open_first_free(libusb_context* context, const UsbDevice& wanted, bool describe_others) {
  const Candidates candidates(context, &wanted);
  OpenedUsb opened;
  for (const auto& [port, usb] : candidates.all()) {
    UsbChoice::Other other{{port, ""}};
    if (opened.device == nullptr && (opened.device = try_to_open(usb, wanted, other)) != nullptr) {
      opened.choice.taken = other.place;
      continue;
    }
    if (describe_others && other.place.serial.empty() && other.refusal.empty())
      other.place.serial = serial_of(usb, wanted);
    opened.choice.others.push_back(other);
  }
  if (opened.device == nullptr) refuse(wanted, opened.choice.others);
  return opened;
}

}  // namespace tactel::hw
