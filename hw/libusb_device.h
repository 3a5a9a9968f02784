// SPDX-License-Identifier: Apache-2.0

// Finds, opens and prepares a device. Only the files libusb_device and usb_source.cpp use libusb.
#pragma once
#include <libusb.h>

#include <cstdint>
#include <memory>
#include <string>

#include "hw/usb_source.h"

namespace tactel::hw {

struct ExitLibusb {
  void operator()(libusb_context* context) const { libusb_exit(context); }
};
using LibusbContext = std::unique_ptr<libusb_context, ExitLibusb>;
LibusbContext new_context();  ///< throws SourceError

/// Endpoints of the frames, by descriptor.
struct UsbRoute {
  int data_interface = -1, control_interface = -1;
  std::uint8_t in = 0, out = 0;  ///< endpoint addresses; out 0: none
  bool in_is_interrupt = false;
  int packet = 0;  ///< bytes
};

/// An open device. After prepare() its interfaces are claimed and it sends frames.
class LibusbDevice {
 public:
  /// Throws SourceError.
  LibusbDevice(libusb_device* usb, const UsbDevice& wanted);
  ~LibusbDevice();
  LibusbDevice(const LibusbDevice&) = delete;
  LibusbDevice& operator=(const LibusbDevice&) = delete;

  /// Claims the interfaces of the device and starts it. Throws SourceError.
  void prepare();
  std::string serial() const;  ///< as UsbPlace
  std::string name() const;    ///< as ListedUsb
  libusb_device_handle* handle() const { return handle_; }
  const UsbRoute& route() const { return route_; }

 private:
  std::string text(std::uint8_t index, char least) const;
  void claim();
  void prepare_cdc();
  void prepare_ftdi();
  void send_start();
  void control(std::uint8_t type, std::uint8_t request, int value, int index, std::uint8_t* data, std::size_t length,
               const char* what);

  UsbDevice wanted_;
  libusb_device_handle* handle_ = nullptr;
  UsbRoute route_;
};

/// A device that was opened and prepared, and the other devices.
struct OpenedUsb {
  std::unique_ptr<LibusbDevice> device;
  UsbChoice choice;
};

/// Opens the first free device of this vendor and product, in the order of their ports. With describe_others it
/// also opens the unwanted ones, for their serial numbers. Throws SourceError.
OpenedUsb open_first_free(libusb_context* context, const UsbDevice& wanted, bool describe_others);

}  // namespace tactel::hw
