// SPDX-License-Identifier: Apache-2.0
#include <numeric>

#include "hw/format_parts.h"
#include "hw/formats.h"

namespace tactel::hw {
namespace {

constexpr std::uint8_t mark[] = {0xAA, 0x56, 0x00};
constexpr std::size_t head = 6;         // mark, length, error byte
constexpr std::size_t total_force = 6;  // bytes before a sensor's points

class PaxiniFormat final : public WireFormat {
 public:
  PaxiniFormat(int sensors, int points)
      : sensors_(static_cast<std::size_t>(sensors)), points_(static_cast<std::size_t>(points)) {}

  Verdict inspect(Bytes bytes) const override {
    if (const auto kind = begins_with(bytes, mark); kind != Verdict::whole) return {kind};
    if (bytes.size() < head) return {Verdict::incomplete};
    if (unsigned_at(bytes, 3, 2) != 1 + data()) return {Verdict::nothing};
    if (bytes.size() < longest_frame()) return {Verdict::incomplete};
    const Bytes frame = bytes.first(longest_frame());
    // The last byte makes the sum of all vanish; the board's own error byte must be 0.
    const bool good = std::accumulate(frame.begin(), frame.end(), 0u) % 256 == 0 && frame[5] == 0;
    return {good ? Verdict::whole : Verdict::damaged, frame.size()};
  }

  FrameHeader read(Bytes frame, std::span<double> values) const override {
    for (std::size_t i = 0; i < sensors_ * points_; ++i) {
      const std::size_t at = head + i / points_ * per_sensor() + total_force + i % points_ * 3;
      values[3 * i] = static_cast<std::int8_t>(frame[at]);
      values[3 * i + 1] = static_cast<std::int8_t>(frame[at + 1]);
      values[3 * i + 2] = frame[at + 2];
    }
    return {};
  }

  std::size_t channels() const override { return sensors_ * points_ * 3; }
  std::size_t longest_frame() const override { return head + data() + 1; }
  int confirmations() const override { return 2; }

 private:
  std::size_t per_sensor() const { return total_force + 3 * points_; }
  std::size_t data() const { return sensors_ * per_sensor(); }
  std::size_t sensors_, points_;
};

}  // namespace

std::unique_ptr<const WireFormat> paxini_format(int sensors, int points) {
  require_within("format.sensors", sensors, 1, 16);
  require_within("format.points", points, 1, 1000);
  return std::make_unique<PaxiniFormat>(sensors, points);
}

}  // namespace tactel::hw
