// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numeric>

#include "hw/format_parts.h"
#include "hw/formats.h"

namespace tactel::hw {
namespace {

constexpr std::uint8_t head[] = {0x55, 0x66, 0x77, 0x88}, tail[] = {0xAA, 0xBB, 0xCC, 0xDD};
constexpr std::size_t marks = 4, pillars = 9, per_pillar = 6;
constexpr std::size_t longest_payload = 2000;  // 801 B for two sensors, and room for blocks of undocumented types

enum BlockType : std::uint64_t { hub = 1, pillar_data = 3, global_data = 4, pillar_slip = 5, sensor_slip = 6 };

std::uint64_t sum_of(Bytes bytes) { return std::accumulate(bytes.begin(), bytes.end(), 0u) & 0xFFFF; }

/// Walks through a payload without leaving it: what it could not read for want of bytes, or must not, it remembers.
class Walk {
 public:
  Walk(Bytes payload, std::size_t at) : payload_(payload), at_(at) {}
  std::uint64_t next(std::size_t width) {
    const std::size_t from = at_;
    skip(width);
    return from + width <= payload_.size() ? unsigned_at(payload_, from, width) : 0;
  }
  void skip(std::size_t bytes) { at_ += bytes; }
  void expect(bool met) { sound_ = sound_ && (met || at_ > payload_.size()); }
  std::size_t at() const { return at_; }
  bool short_of_bytes() const { return at_ > payload_.size(); }
  bool sound() const { return sound_; }
  bool going() const { return sound_ && !short_of_bytes(); }

 private:
  Bytes payload_;
  std::size_t at_;
  bool sound_ = true;
};

/// What the index of a payload says.
struct Contents {
  Verdict::Kind kind = Verdict::incomplete;  ///< whole: the fields below hold
  std::size_t end = 0;                       ///< first byte after every block of a known type
  bool unknown_types = false;                ///< then the payload may continue
  std::size_t hub_at = 0, pillars_at = 0;    ///< where those blocks begin; 0: not there
};

class PapillarrayFormat final : public WireFormat {
 public:
  explicit PapillarrayFormat(int sensors) : sensors_(static_cast<std::size_t>(sensors)) {}

  // The length is not sent, it follows from the blocks. Marks inside a float are not looked at, unless a block of
  // unknown length comes last; then the checksum before them decides.
  Verdict inspect(Bytes bytes) const override {
    if (const auto kind = begins_with(bytes, head); kind != Verdict::whole) return {kind};
    const Bytes payload = bytes.subspan(marks);
    const Contents contents = read_index(payload.first(std::min(payload.size(), longest_payload)));
    if (contents.kind == Verdict::incomplete && payload.size() >= longest_payload) return {Verdict::damaged};
    if (contents.kind != Verdict::whole) return {contents.kind};
    const std::size_t last = contents.unknown_types ? longest_payload : contents.end;
    for (std::size_t end = contents.end; end <= last; ++end) {
      if (payload.size() < end + 2 + marks) return {Verdict::incomplete};
      if (begins_with(payload.subspan(end + 2), tail) != Verdict::whole) continue;
      if (sum_of(payload.first(end)) == unsigned_at(payload, end, 2)) return {Verdict::whole, marks + end + 2 + marks};
      // The next frame right behind it: this was the end, with a wrong checksum.
      const auto next = begins_with(payload.subspan(end + 2 + marks), head);
      if (next == Verdict::incomplete) return {next};
      if (next == Verdict::whole) return {Verdict::damaged, marks + end + 2 + marks};
    }
    return {Verdict::damaged};
  }

  FrameHeader read(Bytes frame, std::span<double> values) const override {
    const Bytes payload = frame.subspan(marks);
    const Contents contents = read_index(payload);
    Walk walk(payload, contents.pillars_at);
    walk.skip(2 + sensors_ * payload[0]);
    for (std::size_t sensor = 0; sensor < sensors_; ++sensor) {
      walk.skip(2 + pillars * payload[0]);
      for (std::size_t pillar = 0; pillar < pillars; ++pillar) {
        walk.skip(2);
        for (std::size_t k = 0; k < per_pillar; ++k, walk.skip(4))
          values[(sensor * pillars + pillar) * per_pillar + k] = float_at(payload, walk.at());
      }
    }
    if (contents.hub_at == 0) return {};
    return {unsigned_at(payload, contents.hub_at, 4), unsigned_at(payload, contents.hub_at + 4, 8)};
  }

  std::size_t channels() const override { return sensors_ * pillars * per_pillar; }
  std::size_t longest_frame() const override { return marks + longest_payload + 2 + marks + marks; }
  int confirmations() const override { return 1; }  // four marks each side and a sum of 16 bits
  int counter_bits() const override { return 32; }
  int clock_bits() const override { return 64; }
  double clock_tick() const override { return 1e-6; }

 private:
  // The index ends where the first block begins.
  Contents read_index(Bytes payload) const {
    if (payload.empty()) return {Verdict::incomplete};
    const std::size_t width = payload[0];
    if (width != 1 && width != 2 && width != 4) return {Verdict::damaged};
    Contents contents;
    std::size_t first_block = longest_payload;
    for (Walk index(payload, 1); index.at() < first_block;) {
      const std::uint64_t type = index.next(2), block = index.next(width);
      if (index.short_of_bytes()) return {Verdict::incomplete};
      if (block < index.at() || block >= longest_payload || index.at() > first_block) return {Verdict::damaged};
      first_block = std::min<std::size_t>(first_block, block);
      if (const auto kind = read_block(payload, type, block, contents); kind != Verdict::whole) return {kind};
    }
    contents.kind = contents.pillars_at > 0 ? Verdict::whole : Verdict::damaged;
    return contents;
  }

  Verdict::Kind read_block(Bytes payload, std::uint64_t type, std::size_t at, Contents& contents) const {
    Walk walk(payload, at);
    const std::size_t width = payload[0];
    switch (type) {
      case hub:
        contents.hub_at = at, walk.skip(12);
        break;
      case pillar_data:
        contents.pillars_at = at, walk_pillars(walk, width, 2, 24);
        break;
      case global_data:
        walk_sensors(walk, width, 2, 24);
        break;
      case pillar_slip:
        walk_pillars(walk, width, 1, 5);
        break;
      case sensor_slip:
        walk_sensors(walk, width, 1, 9);
        break;
      default:
        contents.unknown_types = true;
    }
    if (!walk.sound()) return Verdict::damaged;
    if (walk.short_of_bytes()) return Verdict::incomplete;
    contents.end = std::max(contents.end, walk.at());
    return Verdict::whole;
  }

  void walk_sensors(Walk& walk, std::size_t width, std::uint64_t kind, std::size_t size) const {
    walk.expect(walk.next(2) == sensors_);
    walk.skip(sensors_ * width);
    walk_items(walk, sensors_, kind, size);
  }

  void walk_pillars(Walk& walk, std::size_t width, std::uint64_t kind, std::size_t size) const {
    walk.expect(walk.next(2) == sensors_);
    walk.skip(sensors_ * width);
    for (std::size_t sensor = 0; sensor < sensors_ && walk.going(); ++sensor) {
      walk.expect(walk.next(2) == pillars);
      walk.skip(pillars * width);
      walk_items(walk, pillars, kind, size);
    }
  }

  static void walk_items(Walk& walk, std::size_t items, std::uint64_t kind, std::size_t size) {
    for (std::size_t i = 0; i < items && walk.going(); ++i) {
      walk.expect(walk.next(2) == kind);
      walk.skip(size);
    }
  }

  std::size_t sensors_;
};

}  // namespace

std::unique_ptr<const WireFormat> papillarray_format(int sensors) {
  require_within("format.sensors", sensors, 1, 2);
  return std::make_unique<PapillarrayFormat>(sensors);
}

}  // namespace tactel::hw
