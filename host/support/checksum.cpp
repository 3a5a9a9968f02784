// SPDX-License-Identifier: Apache-2.0
#include "host/support/checksum.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <cstring>

namespace tactel::host {
namespace {

std::string digits(std::uint64_t sum) { return fmt::format("{:016x}", sum); }

struct Free {
  void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
};

}  // namespace

std::uint64_t checksum(std::string_view bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

std::string checksum_text(std::string_view bytes) { return digits(checksum(bytes)); }

// Sums of 16-bit words, and of these sums, modulo 65535. HDF5 takes words with the high byte first; turning the bytes
// of words about turns those of the sums about. A sum that is a multiple of 65535 is 0 only where all words are.
std::uint32_t fletcher32(std::string_view bytes) {
  constexpr std::size_t block = 256;  // words: 256 * 257 / 2 * 65535 < 2^32
  std::uint64_t first = 0, second = 0;
  bool any = false;
  std::uint16_t words[block];
  for (std::size_t at = 0; at < bytes.size(); at += 2 * block) {
    const std::size_t size = std::min(2 * block, bytes.size() - at), count = (size + 1) / 2;
    words[count - 1] = 0;  // an odd byte is the first of a word
    std::memcpy(words, bytes.data() + at, size);
    std::uint32_t sum = 0, weighted = 0;
    for (std::size_t k = 0; k < count; ++k) {
      sum += words[k];
      weighted += static_cast<std::uint32_t>(count - k) * words[k];
    }
    second = (second + count * first + weighted) % 65535;
    first = (first + sum) % 65535;
    any = any || sum != 0;
  }
  const auto half = [&](std::uint64_t sum) {
    const auto low = static_cast<std::uint32_t>(sum == 0 && any ? 65535 : sum);
    return std::endian::native == std::endian::little ? (low >> 8 | low << 8) & 0xffff : low;
  };
  return half(second) << 16 | half(first);
}

struct RunningChecksum::State {
  std::unique_ptr<XXH3_state_t, Free> sum{XXH3_createState()};
};

RunningChecksum::RunningChecksum() : state_(std::make_unique<State>()) { XXH3_64bits_reset(state_->sum.get()); }
RunningChecksum::~RunningChecksum() = default;
RunningChecksum::RunningChecksum(RunningChecksum&&) noexcept = default;

void RunningChecksum::add(std::string_view bytes) { XXH3_64bits_update(state_->sum.get(), bytes.data(), bytes.size()); }

std::uint64_t RunningChecksum::value() const { return XXH3_64bits_digest(state_->sum.get()); }
std::string RunningChecksum::text() const { return digits(value()); }

}  // namespace tactel::host
