// SPDX-License-Identifier: Apache-2.0

// Profiles of sensors (TOML), and the decoder and channel map that they describe.
#include <cmath>
#include <vector>

#include "host/live/sensor_profile.h"
#include "hw/decoder.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactel;
  const std::string text(reinterpret_cast<const char*>(data), size);
  host::SensorProfile profile;
  if (!fuzz::accepts([&] { profile = host::parse_profile(text, "profile.toml"); })) return 0;
  hw::Decoder decoder(profile.format());
  std::vector<float> frame(profile.map.places());
  // The profile's own text stands for a stream of bytes: some sync marks occur in it.
  decoder.feed({data, size}, [&](const hw::DecodedFrame& decoded) { profile.map.apply(decoded.values, frame); });
  return 0;
}
