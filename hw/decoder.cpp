// SPDX-License-Identifier: Apache-2.0
#include "hw/decoder.h"

#include <algorithm>
#include <cstring>

namespace tactel::hw {
namespace {

std::uint64_t mask(int bits) { return bits >= 64 ? ~0ull : (1ull << bits) - 1; }

}  // namespace

// Room for all that can be waited for, and as much again so that bytes are seldom moved.
Decoder::Decoder(std::unique_ptr<const WireFormat> format)
    : format_(std::move(format)),
      buffer_(2 * format_->longest_frame() * static_cast<std::size_t>(format_->confirmations()) + 4096),
      values_(format_->channels()) {}

void Decoder::feed(Bytes bytes, const FrameSink& sink) {
  while (!bytes.empty()) {
    if (end_ == buffer_.size()) {
      std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
      end_ -= begin_;
      begin_ = 0;
    }
    const std::size_t count = std::min(bytes.size(), buffer_.size() - end_);
    std::memcpy(buffer_.data() + end_, bytes.data(), count);
    end_ += count;
    bytes = bytes.subspan(count);
    while (step(sink)) {
    }
    if (begin_ == end_) begin_ = end_ = 0;
  }
}

void Decoder::interrupt() {
  discard(end_ - begin_);
  begin_ = end_ = 0;
  in_sync_ = false;
  damaged_length_ = 0;
}

bool Decoder::step(const FrameSink& sink) {
  if (begin_ == end_) return false;
  return in_sync_ ? step_in_sync(sink) : step_searching();
}

bool Decoder::step_in_sync(const FrameSink& sink) {
  const Verdict verdict = format_->inspect(pending());
  if (verdict.kind == Verdict::incomplete) return false;
  if (verdict.kind == Verdict::whole) {
    take(pending().first(verdict.length), sink);
    begin_ += verdict.length;
    return true;
  }
  if (verdict.kind == Verdict::damaged) ++counts_.bad;
  damaged_length_ = verdict.kind == Verdict::damaged ? verdict.length : 0;
  in_sync_ = false;
  discard(1);  // only one: the next frame may begin anywhere in what looked like this one
  return true;
}

bool Decoder::step_searching() {
  const Verdict::Kind found = confirm(pending());
  if (found == Verdict::incomplete) return false;
  if (found != Verdict::whole) {
    discard(1);
    return true;
  }
  // A bad frame with the next one right behind it never lost the beat.
  if (was_in_sync_ && discarded_since_sync_ != damaged_length_) ++counts_.resynchronised;
  in_sync_ = was_in_sync_ = true;
  discarded_since_sync_ = damaged_length_ = 0;
  return true;
}

/// Returns true where as many consecutive frames as the format requires begin here.
Verdict::Kind Decoder::confirm(Bytes bytes) const {
  for (int i = 0; i < format_->confirmations(); ++i) {
    const Verdict verdict = format_->inspect(bytes);
    if (verdict.kind != Verdict::whole) return verdict.kind;
    bytes = bytes.subspan(verdict.length);
  }
  return Verdict::whole;
}

void Decoder::take(Bytes frame, const FrameSink& sink) {
  const FrameHeader header = format_->read(frame, values_);
  if (!is_new(header)) return;
  ++counts_.frames;
  sink({values_, unwrap(header)});
}

// A counter that runs backwards belongs to a device that began anew: nothing is lost then.
bool Decoder::is_new(const FrameHeader& header) {
  if (!header.counter) return true;
  const std::uint64_t all = mask(format_->counter_bits());
  const std::uint64_t ahead = last_counter_ ? (*header.counter - *last_counter_) & all : 1;
  last_counter_ = header.counter;
  if (ahead == 0) {
    ++counts_.duplicated;
    return false;
  }
  if (ahead <= all / 2) counts_.lost += ahead - 1;
  return true;
}

std::optional<double> Decoder::unwrap(const FrameHeader& header) {
  if (!header.clock) return std::nullopt;
  const int bits = format_->clock_bits();
  // A small step back is jitter or a restart; only a fall by more than half the range is a wrap.
  if (bits < 64 && last_clock_ && *last_clock_ > *header.clock && *last_clock_ - *header.clock > mask(bits) / 2)
    ++clock_wraps_;
  last_clock_ = header.clock;
  const double wraps = bits < 64 ? static_cast<double>(clock_wraps_) * static_cast<double>(1ull << bits) : 0.0;
  return (wraps + static_cast<double>(*header.clock)) * format_->clock_tick();
}

void Decoder::discard(std::size_t bytes) {
  begin_ += bytes;
  counts_.discarded += bytes;
  discarded_since_sync_ += bytes;
}

}  // namespace tactel::hw
