// SPDX-License-Identifier: Apache-2.0
#include "tests/hw/usb/device_kinds.h"

namespace tactel::hw::tests {

const DeviceKind& glove_kind() {
  static const DeviceKind kind = {
      "12 01 0002 02 00 00 40 D804 0A00 0001 00 00 00 01"
      "09 02 4300 02 01 00 80 32"
      "09 04 00 00 01 02 02 01 00"
      "05 24 00 1001"
      "05 24 01 01 01"
      "04 24 02 02"
      "05 24 06 00 01"
      "07 05 82 03 0800 02"
      "09 04 01 00 02 0A 00 00 00"
      "07 05 03 02 4000 00"
      "07 05 83 02 4000 00"};
  return kind;
}

const DeviceKind& interrupt_kind() {
  static const DeviceKind kind = {
      "12 01 0002 00 00 00 40 0912 0100 0001 00 00 00 01"
      "09 02 1900 01 01 00 80 32"
      "09 04 00 00 01 FF 00 00 00"
      "07 05 81 03 4000 01"};
  return kind;
}

const DeviceKind& ftdi_kind() {
  static const DeviceKind kind = {
      "12 01 0002 00 00 00 08 0304 0160 0006 00 00 00 01"
      "09 02 2000 01 01 00 80 2D"
      "09 04 00 00 02 FF FF FF 00"
      "07 05 81 02 4000 00"
      "07 05 02 02 4000 00",
      12,
      64,
      {0x01, 0x60}};
  return kind;
}

const DeviceKind& fast_kind() {
  static const DeviceKind kind = {
      "12 01 0002 00 00 00 40 0912 0200 0001 00 00 00 01"
      "09 02 2000 01 01 00 80 32"
      "09 04 00 00 02 FF 00 00 00"
      "07 05 01 02 0002 00"
      "07 05 81 02 0002 00",
      480, 512};
  return kind;
}

}  // namespace tactel::hw::tests
