// SPDX-License-Identifier: Apache-2.0
#include "hw/format_parts.h"
#include "hw/formats.h"

namespace tactel::hw {
namespace {

constexpr std::size_t cells = 64, packet = 5;
constexpr std::uint8_t first_id = 0x3C;

class GloveFormat final : public WireFormat {
 public:
  Verdict inspect(Bytes bytes) const override {
    for (std::size_t i = 0; i < cells * packet; ++i) {
      if (i == bytes.size()) return {Verdict::incomplete};
      if (!fits(bytes[i], i)) return {i < packet ? Verdict::nothing : Verdict::damaged};
    }
    return {Verdict::whole, cells * packet};
  }

  FrameHeader read(Bytes frame, std::span<double> values) const override {
    for (std::size_t cell = 0; cell < cells; ++cell) {
      const auto reading = unsigned_at(frame, packet * cell + 2, 2, true) & 0x0FFF;
      values[cell] = 4095.0 - static_cast<double>(reading);
    }
    return {};
  }

  std::size_t channels() const override { return cells; }
  std::size_t longest_frame() const override { return cells * packet; }
  int confirmations() const override { return 1; }

 private:
  /// Whether byte i of a frame may hold this.
  static bool fits(std::uint8_t byte, std::size_t i) {
    const std::size_t at = i % packet;
    return at == 0 ? byte == first_id + i / packet : at == 1 ? byte == 0x01 : at != 4 || byte == 0x00;
  }
};

}  // namespace

std::unique_ptr<const WireFormat> glove_format() { return std::make_unique<GloveFormat>(); }

}  // namespace tactel::hw
