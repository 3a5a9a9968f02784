// SPDX-License-Identifier: Apache-2.0

// Lines of numbers, read to their end as `tactel record --source csv:FILE` does. The first byte counts the channels.
#include <cmath>

#include "host/live/csv_source.h"
#include "hw/csv_format.h"
#include "hw/decoder.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactel;
  if (size < 1) return 0;
  const int channels = 1 + data[0] % 8;
  const auto path = fuzz::write_file("frames.csv", {data + 1, size - 1});
  fuzz::accepts<hw::RecordingError>([&] {
    host::CsvSource source(path.string(), static_cast<std::size_t>(channels), false);
    hw::Decoder decoder(hw::csv_format(channels));
    double last = 0;
    while (!source.finished()) {
      const auto packet = source.wait(0);
      if (!packet) continue;
      fuzz::check(packet->arrival >= last, "arrivals do not fall");
      last = packet->arrival;
      decoder.feed(packet->bytes, [&](const hw::DecodedFrame& frame) {
        for (const double value : frame.values) fuzz::check(std::isfinite(value), "numbers are finite");
      });
    }
    fuzz::check(decoder.counts() == hw::DecoderCounts{.frames = source.counts().packets}, "a packet is a frame");
  });
  return 0;
}
