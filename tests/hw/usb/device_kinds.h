// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>

#include "tests/hw/byte_vectors.h"

namespace tactel::hw::tests {

/// What an emulated device is, by its descriptors.
struct DeviceKind {
  const char* descriptors;   ///< device and configuration, hexadecimal
  int megabits = 12;         ///< speed as sysfs says it
  std::size_t packet = 64;   ///< bytes of its IN endpoint
  ByteVector before_each{};  ///< what a bridge puts before the data of each packet
};

/// The CITEC glove, 04D8:000A. Interface 0: CDC, 82 interrupt IN 8 B. Interface 1: data, 03 bulk OUT, 83 bulk IN, 64 B.
const DeviceKind& glove_kind();
/// A laboratory's own board, 1209:0001: 81 interrupt IN 64 B, one packet a millisecond.
const DeviceKind& interrupt_kind();
/// A serial bridge FT232R, 0403:6001: 81 bulk IN, 02 bulk OUT, 64 B, two status bytes before each packet.
const DeviceKind& ftdi_kind();
/// A fast board, 1209:0002, high speed: 81 bulk IN, 01 bulk OUT, 512 B.
const DeviceKind& fast_kind();

}  // namespace tactel::hw::tests
