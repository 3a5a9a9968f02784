// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "hw/format_parts.h"
#include "hw/formats.h"

namespace tactel::hw {
namespace {

constexpr std::uint8_t line_end[] = {0x0D, 0x0A};

/// Temperatures and fields that a magnetometer can report (MLX90393: at most 50 mT). Read at a wrong offset, low bytes
/// of a mantissa become an exponent, and hardly ever all values stay within.
bool plausible(double value) {
  const double size = std::abs(value);
  return size == 0 || (size >= 1e-6 && size <= 1e6);  // false for NaN
}

class AnyskinFormat final : public WireFormat {
 public:
  explicit AnyskinFormat(int magnetometers) : channels_(4 * static_cast<std::size_t>(magnetometers)) {}

  Verdict inspect(Bytes bytes) const override {
    if (bytes.size() < longest_frame()) return {Verdict::incomplete};
    if (begins_with(bytes.subspan(4 * channels_), line_end) != Verdict::whole) return {Verdict::nothing};
    for (std::size_t i = 0; i < channels_; ++i)
      if (!plausible(float_at(bytes, 4 * i))) return {Verdict::damaged, longest_frame()};
    return {Verdict::whole, longest_frame()};
  }

  FrameHeader read(Bytes frame, std::span<double> values) const override {
    for (std::size_t i = 0; i < channels_; ++i) values[i] = float_at(frame, 4 * i);
    return {};
  }

  std::size_t channels() const override { return channels_; }
  std::size_t longest_frame() const override { return 4 * channels_ + std::size(line_end); }
  int confirmations() const override { return 4; }

 private:
  std::size_t channels_;
};

}  // namespace

std::unique_ptr<const WireFormat> anyskin_format(int magnetometers) {
  require_within("format.magnetometers", magnetometers, 1, 64);
  return std::make_unique<AnyskinFormat>(magnetometers);
}

}  // namespace tactel::hw
