// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "hw/wire_format.h"

/// Wire formats of real devices. The layouts are from public firmware and drivers, named in hw/README.md. They
/// have been tested on published and synthetic bytes only, not on a device.
namespace tactel::hw {

/// CITEC tactile glove with PIC18: 64 packets `(3C + ch) 01 hi lo 00`, channel 0 first. Values: 4095 - reading;
/// larger is more pressure. The frame has no checksum. No other offset of whole packets looks like packets, so a
/// single frame suffices for sync.
std::unique_ptr<const WireFormat> glove_format();

/// Contactile PapillArray with 1 or 2 sensors of 9 pillars. Values: for each sensor and pillar Fx, Fy, Fz in N, then
/// Dx, Dy, Dz in mm.
std::unique_ptr<const WireFormat> papillarray_format(int sensors);

/// AnySkin and ReSkin, 1 to 64 magnetometers. Values: for each t in degrees Celsius, Bx, By, Bz in microtesla.
std::unique_ptr<const WireFormat> anyskin_format(int magnetometers = 5);

/// CITEC glove on Teensy, AGNI serial protocol. Values: 64 readings by their id.
std::unique_ptr<const WireFormat> agni_format();

/// PaXini PX-6AX board with `sensors` connected sensors of `points` points each. Values: for each point Fx, Fy,
/// Fz as sent. The preceding six bytes of total force are omitted.
std::unique_ptr<const WireFormat> paxini_format(int sensors, int points);

inline constexpr double csv_latest_time = 9e9;  ///< s, of a frame: the year 2255

/// Frames that the source csv: makes of lines of numbers: values in double precision, a counter, and a clock in ns
/// where the line has a time. channels: 1 to 1024. Throws ValueError.
std::unique_ptr<const WireFormat> csv_format(int channels);

/// Appends a frame to `bytes`. time: s, 0 to csv_latest_time; none: the line has no time. values: [channels].
void append_csv_frame(std::uint64_t counter, std::optional<double> time, std::span<const double> values,
                      std::vector<std::uint8_t>& bytes);

}  // namespace tactel::hw
