// SPDX-License-Identifier: Apache-2.0
#include "hw/generic_format.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "hw/format_parts.h"

namespace tactel::hw {
namespace {

std::size_t size_of(SampleType type) {
  if (type == SampleType::f64) return 8;
  return type == SampleType::i16 || type == SampleType::u16 ? 2 : 4;
}

std::size_t size_of(Checksum kind) {
  if (kind == Checksum::none) return 0;
  return kind == Checksum::sum16 || kind == Checksum::crc16 ? 2 : 1;
}

std::uint64_t checksum_of(Checksum kind, Bytes bytes) {
  if (kind == Checksum::none) return 0;
  if (kind == Checksum::crc16) return crc16(bytes);
  if (kind == Checksum::xor8) return std::accumulate(bytes.begin(), bytes.end(), 0u, std::bit_xor<>());
  return std::accumulate(bytes.begin(), bytes.end(), 0u) & (kind == Checksum::sum8 ? 0xFF : 0xFFFF);
}

/// Where the parts of a frame begin.
struct Places {
  explicit Places(const GenericLayout& layout)
      : samples(static_cast<std::size_t>(layout.header)),
        checksum(samples + static_cast<std::size_t>(layout.channels) * size_of(layout.sample)),
        trailer(checksum + size_of(layout.checksum)),
        end(trailer + layout.trailer.size()) {}
  std::size_t samples, checksum, trailer, end;
};

double sample_of(SampleType type, std::uint64_t bits) {
  if (type == SampleType::i16) return static_cast<std::int16_t>(bits);
  if (type == SampleType::i32) return static_cast<std::int32_t>(bits);
  if (type == SampleType::f32) return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
  return type == SampleType::f64 ? std::bit_cast<double>(bits) : static_cast<double>(bits);
}

std::uint64_t bits_of(SampleType type, double value) {
  const auto held = [value](double least, double most) {
    return static_cast<std::uint64_t>(std::llround(std::isnan(value) ? 0.0 : std::clamp(value, least, most)));
  };
  if (type == SampleType::i16) return held(-32768, 32767) & 0xFFFF;
  if (type == SampleType::i32) return held(-2147483648.0, 2147483647.0) & 0xFFFFFFFF;
  if (type == SampleType::f32) return std::bit_cast<std::uint32_t>(static_cast<float>(value));
  return type == SampleType::f64 ? std::bit_cast<std::uint64_t>(value) : held(0, 65535);
}

class GenericFormat final : public WireFormat {
 public:
  explicit GenericFormat(const GenericLayout& layout) : layout_(layout), places_(layout) {}

  Verdict inspect(Bytes bytes) const override {
    if (const auto kind = begins_with(bytes, layout_.sync); kind != Verdict::whole) return {kind};
    if (bytes.size() < places_.end) return {Verdict::incomplete};
    const auto from = static_cast<std::size_t>(layout_.checksum_from);
    const bool good = begins_with(bytes.subspan(places_.trailer), layout_.trailer) == Verdict::whole &&
                      checksum_of(layout_.checksum, bytes.subspan(from, places_.checksum - from)) ==
                          number(bytes, places_.checksum, size_of(layout_.checksum));
    return {good ? Verdict::whole : Verdict::damaged, places_.end};
  }

  FrameHeader read(Bytes frame, std::span<double> values) const override {
    const std::size_t size = size_of(layout_.sample);
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = sample_of(layout_.sample, number(frame, places_.samples + i * size, size));
    return {field(frame, layout_.counter), field(frame, layout_.clock)};
  }

  std::size_t channels() const override { return static_cast<std::size_t>(layout_.channels); }
  std::size_t longest_frame() const override { return places_.end; }
  int confirmations() const override { return layout_.confirmations; }
  int counter_bits() const override { return 8 * layout_.counter.width; }
  int clock_bits() const override { return 8 * layout_.clock.width; }
  double clock_tick() const override { return layout_.clock_tick; }

 private:
  std::uint64_t number(Bytes bytes, std::size_t at, std::size_t width) const {
    return unsigned_at(bytes, at, width, layout_.big_endian);
  }
  std::optional<std::uint64_t> field(Bytes frame, const HeaderField& field) const {
    if (field.width == 0) return std::nullopt;
    return number(frame, static_cast<std::size_t>(field.offset), static_cast<std::size_t>(field.width));
  }
  GenericLayout layout_;
  Places places_;
};

void validate_field(const GenericLayout& layout, const HeaderField& field, const std::string& key) {
  if (field.width == 0) return;
  require(std::has_single_bit(static_cast<unsigned>(field.width)) && field.width <= 8, key + "_width",
          std::to_string(field.width), "1, 2, 4 or 8 bytes");
  require_within(key + "_offset", field.offset, static_cast<long>(layout.sync.size()), layout.header - field.width);
}

}  // namespace

void GenericLayout::validate() const {
  require_within("format.sync", static_cast<long>(sync.size()), 1, 16);
  require_within("format.header", header, static_cast<long>(sync.size()), 256);
  require_within("format.channels", channels, 1, 1024);
  validate_field(*this, counter, "format.counter");
  validate_field(*this, clock, "format.clock");
  require(std::isfinite(clock_tick) && clock_tick > 0, "format.clock_tick", std::to_string(clock_tick),
          "a number of s above 0");
  require_within("format.checksum_from", checksum_from, 0, header);
  require_within("format.trailer", static_cast<long>(trailer.size()), 0, 16);
  require_within("format.confirmations", confirmations, 1, 16);
}

std::unique_ptr<const WireFormat> generic_format(const GenericLayout& layout) {
  layout.validate();
  return std::make_unique<GenericFormat>(layout);
}

std::size_t generic_frame_length(const GenericLayout& layout) { return Places(layout).end; }

void write_generic_frame(const GenericLayout& layout, std::uint64_t counter, std::uint64_t clock,
                         std::span<const double> samples, std::span<std::uint8_t> out) {
  const Places places(layout);
  const auto put = [&](std::size_t at, std::size_t width, std::uint64_t value) {
    for (std::size_t i = 0; i < width; ++i)
      out[at + (layout.big_endian ? width - 1 - i : i)] = static_cast<std::uint8_t>(value >> 8 * i);
  };
  const auto put_field = [&](const HeaderField& field, std::uint64_t value) {
    put(static_cast<std::size_t>(field.offset), static_cast<std::size_t>(field.width), value);
  };
  std::ranges::fill(out, std::uint8_t{0});
  std::ranges::copy(layout.sync, out.begin());
  put_field(layout.counter, counter);
  put_field(layout.clock, clock);
  const std::size_t size = size_of(layout.sample);
  for (std::size_t i = 0; i < samples.size(); ++i)
    put(places.samples + i * size, size, bits_of(layout.sample, samples[i]));
  const auto from = static_cast<std::size_t>(layout.checksum_from);
  put(places.checksum, size_of(layout.checksum),
      checksum_of(layout.checksum, Bytes(out).subspan(from, places.checksum - from)));
  std::ranges::copy(layout.trailer, out.begin() + static_cast<long>(places.trailer));
}

std::uint16_t crc16(Bytes bytes) {
  unsigned crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc ^= static_cast<unsigned>(byte) << 8;
    for (int bit = 0; bit < 8; ++bit) crc = (crc << 1 ^ (crc & 0x8000 ? 0x1021 : 0)) & 0xFFFF;
  }
  return static_cast<std::uint16_t>(crc);
}

}  // namespace tactel::hw
