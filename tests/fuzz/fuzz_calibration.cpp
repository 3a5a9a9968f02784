// SPDX-License-Identifier: Apache-2.0

// Calibration files (TOML) for the glove.
#include <cmath>

#include "host/live/sensor_profile.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactel;
  static const host::SensorProfile glove = host::built_in_profile("glove");
  host::SensorProfile profile = glove;
  const auto path = fuzz::write_file("calibration.toml", {data, size});
  if (!fuzz::accepts([&] { host::read_calibration(path, profile); })) return 0;
  const hw::Calibration& read = profile.map.calibration;
  const std::size_t channels = profile.format()->channels();
  fuzz::check(read.offset.size() == channels && read.gain.size() == channels, "one offset and gain a channel");
  for (const double number : read.offset) fuzz::check(std::isfinite(number), "offsets are finite");
  for (const double number : read.gain) fuzz::check(std::isfinite(number), "gains are finite");
  return 0;
}
