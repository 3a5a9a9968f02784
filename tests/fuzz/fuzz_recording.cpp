// SPDX-License-Identifier: Apache-2.0

// Recordings: replayed to their end as `tactel monitor --source replay:FILE` does, without the network. The input is
// read as it is, then with every record's checksum made right, so that what stands behind the checksums is reached.
#include <cmath>
#include <vector>

#include "host/live/live_frames.h"
#include "host/live/sensor_profile.h"
#include "hw/decoder.h"
#include "hw/recording.h"
#include "tests/fuzz/fuzz.h"

namespace tactel::fuzz {
namespace {

constexpr std::size_t magic_size = 8, record_head = 5, record_tail = 4;

/// The same recording, the CRC of each whole record set to that of its bytes.
std::vector<std::uint8_t> with_right_checksums(Bytes input) {
  std::vector<std::uint8_t> bytes(input.begin(), input.end());
  for (std::size_t at = magic_size; at + record_head <= bytes.size();) {
    std::size_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) length |= static_cast<std::size_t>(bytes[at + 1 + i]) << 8 * i;
    const std::size_t whole = record_head + length;
    if (whole + record_tail > bytes.size() - at) break;
    const std::uint32_t sum = hw::crc32(Bytes(bytes).subspan(at, whole));
    for (std::size_t i = 0; i < record_tail; ++i) bytes[at + whole + i] = static_cast<std::uint8_t>(sum >> 8 * i);
    at += whole + record_tail;
  }
  return bytes;
}

void replay(hw::FrameSource& source, const host::SensorProfile& profile, std::size_t size) {
  hw::Decoder decoder(profile.format());
  std::vector<float> frame(profile.map.places());
  host::LatencyHistogram latency;
  std::size_t bytes = 0;
  while (!source.finished()) {
    const auto packet = source.wait(0);
    if (!packet) continue;
    if (packet->after_gap) decoder.interrupt();
    bytes += packet->bytes.size();
    check(std::isfinite(packet->arrival), "a packet's arrival is finite");
    decoder.feed(packet->bytes, [&](const hw::DecodedFrame& decoded) {
      profile.map.apply(decoded.values, frame);
      latency.add(1e6 * (source.now() - packet->arrival));
    });
  }
  check(bytes <= size, "a recording holds no more bytes than its file");
  check(source.counts().bytes == bytes, "the source counts the bytes that it hands out");
}

void read(Bytes bytes) {
  const auto path = write_file("recording", bytes);
  accepts<hw::RecordingError>([&] {
    hw::ReplaySource source(path);
    host::SensorProfile profile;
    if (!accepts([&] { profile = host::parse_profile(source.description(), path.string()); })) return;
    replay(source, profile, bytes.size());
  });
}

const Target recording("recording", [](Bytes input) {
  read(input);
  const std::vector<std::uint8_t> repaired = with_right_checksums(input);
  if (!std::ranges::equal(repaired, input)) read(repaired);
});

}  // namespace
}  // namespace tactel::fuzz
