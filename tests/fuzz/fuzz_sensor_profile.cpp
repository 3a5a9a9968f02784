// SPDX-License-Identifier: Apache-2.0

// Profiles of sensors (TOML), and the decoder and channel map that they describe.
#include <vector>

#include "host/live/sensor_profile.h"
#include "hw/decoder.h"
#include "tests/fuzz/fuzz.h"

namespace tactel::fuzz {
namespace {

const Target sensor_profile("sensor_profile", [](Bytes input) {
  const std::string text(input.begin(), input.end());
  host::SensorProfile profile;
  if (!accepts([&] { profile = host::parse_profile(text, "profile.toml"); })) return;
  hw::Decoder decoder(profile.format());
  std::vector<float> frame(profile.map.places());
  // The profile's own text stands for a stream of bytes: some sync marks occur in it.
  decoder.feed(input, [&](const hw::DecodedFrame& decoded) { profile.map.apply(decoded.values, frame); });
});

}  // namespace
}  // namespace tactel::fuzz
