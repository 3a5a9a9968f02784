// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "hw/bytes.h"
#include "hw/formats.h"

namespace tactel::hw {
namespace {

constexpr std::size_t values_per_frame = 20, payload = 4 * values_per_frame, length = payload + 2;
constexpr std::uint8_t line_end[] = {0x0D, 0x0A};

/// Temperatures and fields that a magnetometer can report (MLX90393: at most 50 mT). Read at a wrong offset, low bytes
/// of a mantissa become an exponent, and hardly ever all twenty values stay within.
bool plausible(double value) {
  const double size = std::abs(value);
  return size == 0 || (size >= 1e-6 && size <= 1e6);  // false for NaN
}

class AnyskinFormat final : public WireFormat {
 public:
  Verdict inspect(Bytes bytes) const override {
    if (bytes.size() < length) return {Verdict::incomplete};
    if (begins_with(bytes.subspan(payload), line_end) != Verdict::whole) return {Verdict::nothing};
    for (std::size_t i = 0; i < values_per_frame; ++i)
      if (!plausible(float_at(bytes, 4 * i))) return {Verdict::damaged, length};
    return {Verdict::whole, length};
  }

  FrameHeader read(Bytes frame, std::span<double> values) const override {
    for (std::size_t i = 0; i < values_per_frame; ++i) values[i] = float_at(frame, 4 * i);
    return {};
  }

  std::size_t channels() const override { return values_per_frame; }
  std::size_t longest_frame() const override { return length; }
  int confirmations() const override { return 4; }
};

}  // namespace

std::unique_ptr<const WireFormat> anyskin_format() { return std::make_unique<AnyskinFormat>(); }

}  // namespace tactel::hw
