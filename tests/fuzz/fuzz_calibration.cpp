// SPDX-License-Identifier: Apache-2.0

// Calibration files (TOML) for the glove.
#include <cmath>

#include "host/live/sensor_profile.h"
#include "tests/fuzz/fuzz.h"

namespace tactel::fuzz {
namespace {

const Target calibration("calibration", [](Bytes input) {
  static const host::SensorProfile glove = host::built_in_profile("glove");
  host::SensorProfile profile = glove;
  const auto path = write_file("calibration.toml", input);
  if (!accepts([&] { host::read_calibration(path, profile); })) return;
  const hw::Calibration& read = profile.map.calibration;
  const std::size_t channels = profile.format()->channels();
  check(read.offset.size() == channels && read.gain.size() == channels, "one offset and gain a channel");
  for (const double number : read.offset) check(std::isfinite(number), "offsets are finite");
  for (const double number : read.gain) check(std::isfinite(number), "gains are finite");
});

}  // namespace
}  // namespace tactel::fuzz
