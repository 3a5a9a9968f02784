// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "hw/formats.h"
#include "hw/generic_format.h"

namespace tactel::hw {
namespace {

constexpr double tick = 1e-9;             // s
constexpr std::uint64_t no_time = ~0ull;  // beyond csv_latest_time

GenericLayout layout_of(int channels) {
  return {.sync = {0xC5, 0x5F},
          .header = 14,
          .counter = {2, 4},
          .clock = {6, 8},
          .clock_tick = tick,
          .channels = channels,
          .sample = SampleType::f64,
          .checksum = Checksum::crc16,
          .trailer = {},
          .confirmations = 1};
}

/// The generic format, but for frames without a time.
class CsvFormat final : public WireFormat {
 public:
  explicit CsvFormat(int channels) : frames_(generic_format(layout_of(channels))) {}
  Verdict inspect(Bytes bytes) const override { return frames_->inspect(bytes); }
  FrameHeader read(Bytes frame, std::span<double> values) const override {
    FrameHeader header = frames_->read(frame, values);
    if (header.clock == no_time) header.clock.reset();
    return header;
  }
  std::size_t channels() const override { return frames_->channels(); }
  std::size_t longest_frame() const override { return frames_->longest_frame(); }
  int confirmations() const override { return frames_->confirmations(); }
  int counter_bits() const override { return frames_->counter_bits(); }
  int clock_bits() const override { return frames_->clock_bits(); }
  double clock_tick() const override { return frames_->clock_tick(); }

 private:
  std::unique_ptr<const WireFormat> frames_;
};

}  // namespace

std::unique_ptr<const WireFormat> csv_format(int channels) { return std::make_unique<CsvFormat>(channels); }

void append_csv_frame(std::uint64_t counter, std::optional<double> time, std::span<const double> values,
                      std::vector<std::uint8_t>& bytes) {
  const GenericLayout layout = layout_of(static_cast<int>(values.size()));
  const std::size_t at = bytes.size();
  bytes.resize(at + generic_frame_length(layout));
  const std::uint64_t clock = time ? static_cast<std::uint64_t>(std::llround(*time / tick)) : no_time;
  write_generic_frame(layout, counter, clock, values, std::span(bytes).subspan(at));
}

}  // namespace tactel::hw
