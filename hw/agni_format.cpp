// SPDX-License-Identifier: Apache-2.0
#include <bitset>
#include <numeric>

#include "hw/format_parts.h"
#include "hw/formats.h"

namespace tactel::hw {
namespace {

constexpr std::uint8_t mark[] = {0xF0, 0xC4};
constexpr std::size_t head = 7, cells = 64, per_cell = 3, length = head + cells * per_cell + 1;

/// Returns true where every cell occurs once.
bool has_all_cells(Bytes frame) {
  std::bitset<256> seen;
  for (std::size_t i = 0; i < cells; ++i) seen.set(frame[head + per_cell * i]);
  return (seen >> cells).none() && seen.count() == cells;
}

class AgniFormat final : public WireFormat {
 public:
  Verdict inspect(Bytes bytes) const override {
    if (const auto kind = begins_with(bytes, mark); kind != Verdict::whole) return {kind};
    if (bytes.size() < length) return {Verdict::incomplete};
    const Bytes frame = bytes.first(length);
    const int parity = std::accumulate(frame.begin(), frame.end(), 0, std::bit_xor<>());
    return {parity == 0 && has_all_cells(frame) ? Verdict::whole : Verdict::damaged, length};
  }

  // The unit of the four bytes of time is not published: they are not read.
  FrameHeader read(Bytes frame, std::span<double> values) const override {
    for (std::size_t i = 0; i < cells; ++i) {
      const std::size_t at = head + per_cell * i;
      values[frame[at]] = static_cast<double>(unsigned_at(frame, at + 1, 2));
    }
    return {};
  }

  std::size_t channels() const override { return cells; }
  std::size_t longest_frame() const override { return length; }
  int confirmations() const override { return 1; }  // 64 different ids and a parity: no other offset has them
};

}  // namespace

std::unique_ptr<const WireFormat> agni_format() { return std::make_unique<AgniFormat>(); }

}  // namespace tactel::hw
