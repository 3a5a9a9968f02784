// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "hw/wire_format.h"

namespace tactel::hw {

inline constexpr double csv_latest_time = 9e9;  ///< s, of a frame: the year 2255

/// Frames that the source csv: makes of lines of numbers: values in double precision, a counter, and a clock in ns
/// where the line has a time. channels: 1 to 1024. Throws ValueError.
std::unique_ptr<const WireFormat> csv_format(int channels);

/// Appends a frame to `bytes`. time: s, 0 to csv_latest_time; none: the line has no time. values: [channels].
void append_csv_frame(std::uint64_t counter, std::optional<double> time, std::span<const double> values,
                      std::vector<std::uint8_t>& bytes);

}  // namespace tactel::hw
