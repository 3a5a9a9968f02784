// SPDX-License-Identifier: Apache-2.0
#include "host/live/frame_reader.h"

namespace tactel::host {

void read_frames(hw::FrameSource& source, hw::Decoder& decoder, const ReadingEvents& events) {
  double arrival = 0;
  const hw::FrameSink sink = [&](const hw::DecodedFrame& frame) {
    if (events.frame) events.frame(frame, arrival);
  };
  while (!source.finished() && !(events.stop && events.stop())) {
    if (const auto packet = source.wait(longest_wait)) {
      if (events.packet) events.packet(*packet);
      if (packet->after_gap) decoder.interrupt();
      arrival = packet->arrival;
      const std::uint64_t before = decoder.counts().frames;
      decoder.feed(packet->bytes, sink);
      if (decoder.counts().frames > before) source.answered();
    }
    if (events.turn) events.turn();
  }
}

}  // namespace tactel::host
