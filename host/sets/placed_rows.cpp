// SPDX-License-Identifier: Apache-2.0
#include "host/sets/placed_rows.h"

#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>

namespace tactel::host {
namespace {

bool read_at(int file, std::uint64_t at, char* to, std::size_t bytes) {
  while (bytes > 0) {
    const ssize_t count = ::pread(file, to, bytes, static_cast<off_t>(at));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    to += count, at += static_cast<std::uint64_t>(count), bytes -= static_cast<std::size_t>(count);
  }
  return true;
}

}  // namespace

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

PlacedRows::PlacedRows(std::vector<Dataset> datasets, std::uint64_t rows_of_stripe)
    : datasets_(std::move(datasets)), stripe_rows_(rows_of_stripe), last_(datasets_.size()) {
  for (std::size_t d = 0; d < datasets_.size(); ++d) {
    begins_.push_back(stripe_bytes_);
    stripe_bytes_ += chunk_bytes(d);
  }
}

std::uint64_t PlacedRows::chunk_bytes(std::size_t dataset) const {
  return stripe_rows_ * datasets_[dataset].row_bytes + sizeof(std::uint32_t);
}

/// Keeps rows of the last stripe, which they do not fill.
void PlacedRows::keep(std::uint64_t first, std::uint64_t rows, const std::vector<std::string_view>& values) {
  for (std::size_t d = 0; d < datasets_.size(); ++d) {
    const std::uint64_t size = datasets_[d].row_bytes;
    last_[d].resize(stripe_rows_ * size + sizeof(std::uint32_t));
    std::memcpy(last_[d].data() + rows_ % stripe_rows_ * size, values[d].data() + first * size, rows * size);
  }
}

bool PlacedRows::append(StagedFile& file, std::uint64_t& end, std::uint64_t rows,
                        const std::vector<std::string_view>& values) {
  for (std::size_t d = 0; d < datasets_.size(); ++d) datasets_[d].sum.add(values[d]);
  for (std::uint64_t first = 0, take = 0; first < rows; first += take) {
    const std::uint64_t filled = rows_ % stripe_rows_;
    take = std::min(rows - first, stripe_rows_ - filled);
    if (filled == 0) stripes_.push_back(end), end += stripe_bytes_;
    const bool alone = take == stripe_rows_, complete = filled + take == stripe_rows_;
    if (!alone) keep(first, take, values);
    for (std::size_t d = 0; d < datasets_.size(); ++d) {
      const std::uint64_t size = datasets_[d].row_bytes, at = stripes_.back() + begins_[d];
      const std::string_view own = values[d].substr(first * size, take * size);
      if (!file.write(at + filled * size, own)) return false;
      if (!complete) continue;
      const std::uint32_t sum = fletcher32(alone ? own : std::string_view(last_[d]).substr(0, stripe_rows_ * size));
      if (!file.write(at + stripe_rows_ * size, {reinterpret_cast<const char*>(&sum), sizeof sum})) return false;
    }
    rows_ += take;
  }
  return true;
}

bool PlacedRows::read(int file, std::uint64_t& end, std::uint64_t rows, std::vector<std::string>& values) {
  values.resize(datasets_.size());
  for (std::size_t d = 0; d < datasets_.size(); ++d) values[d].resize(rows * datasets_[d].row_bytes);
  for (std::uint64_t first = 0, take = 0; first < rows; first += take) {
    const std::uint64_t filled = rows_ % stripe_rows_;
    take = std::min(rows - first, stripe_rows_ - filled);
    if (filled == 0) stripes_.push_back(end), end += stripe_bytes_;
    for (std::size_t d = 0; d < datasets_.size(); ++d) {
      const std::uint64_t size = datasets_[d].row_bytes;
      if (!read_at(file, stripes_.back() + begins_[d] + filled * size, values[d].data() + first * size, take * size))
        return false;
    }
    if (take < stripe_rows_) keep(first, take, {values.begin(), values.end()});
    rows_ += take;
  }
  for (std::size_t d = 0; d < datasets_.size(); ++d) datasets_[d].sum.add(values[d]);
  return true;
}

bool PlacedRows::finish(StagedFile& file) {
  const std::uint64_t filled = rows_ % stripe_rows_;
  if (filled == 0) return true;
  for (std::size_t d = 0; d < datasets_.size(); ++d) {
    const std::uint64_t size = datasets_[d].row_bytes;
    std::memset(last_[d].data() + filled * size, 0, (stripe_rows_ - filled) * size);
    const std::uint32_t sum = fletcher32(std::string_view(last_[d]).substr(0, stripe_rows_ * size));
    std::memcpy(last_[d].data() + stripe_rows_ * size, &sum, sizeof sum);
    const std::string_view rest = std::string_view(last_[d]).substr(filled * size);
    if (!file.write(stripes_.back() + begins_[d] + filled * size, rest)) return false;
  }
  return true;
}

}  // namespace tactel::host
