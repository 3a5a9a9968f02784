// SPDX-License-Identifier: Apache-2.0

// Lines of numbers, read to their end as `tactel record --source csv:FILE` does. The first byte counts the channels.
#include <cmath>

#include "host/live/csv_source.h"
#include "hw/decoder.h"
#include "hw/formats.h"
#include "tests/fuzz/fuzz.h"

namespace tactel::fuzz {
namespace {

const Target csv_frames("csv_frames", [](Bytes input) {
  if (input.empty()) return;
  const int channels = 1 + input[0] % 8;
  const auto path = write_file("frames.csv", input.subspan(1));
  accepts<hw::RecordingError>([&] {
    host::CsvSource source(path.string(), static_cast<std::size_t>(channels), false);
    hw::Decoder decoder(hw::csv_format(channels));
    double last = 0;
    while (!source.finished()) {
      const auto packet = source.wait(0);
      if (!packet) continue;
      check(packet->arrival >= last, "arrivals do not fall");
      last = packet->arrival;
      decoder.feed(packet->bytes, [&](const hw::DecodedFrame& frame) {
        for (const double value : frame.values) check(std::isfinite(value), "numbers are finite");
      });
    }
    check(decoder.counts() == hw::DecoderCounts{.frames = source.counts().packets}, "a packet is a frame");
  });
});

}  // namespace
}  // namespace tactel::fuzz
