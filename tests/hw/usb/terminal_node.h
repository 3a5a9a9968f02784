// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace tactel::hw::tests {

/// A terminal in the place of a USB device's node. usbfs says POLLOUT when a request can be handed back, and POLLERR
/// when the device is gone; a plain file, as umockdev puts it there, is always ready, and libusb would spin on it.
/// A terminal whose output is held up is not ready, and one whose other end was closed is in error.
class TerminalNode {
 public:
  /// Replaces what is at `path`; not ready.
  explicit TerminalNode(const std::string& path);
  ~TerminalNode();  ///< gone: POLLERR for whoever has it open
  TerminalNode(const TerminalNode&) = delete;
  TerminalNode& operator=(const TerminalNode&) = delete;

  void set_ready(bool ready);

 private:
  int master_ = -1, slave_ = -1;
  bool ready_ = true;
};

}  // namespace tactel::hw::tests
