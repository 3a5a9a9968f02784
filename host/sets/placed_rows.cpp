// SPDX-License-Identifier: Apache-2.0
#include "host/sets/placed_rows.h"

#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <stdexcept>

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
    : datasets_(std::move(datasets)), stripe_rows_(rows_of_stripe) {
  for (std::size_t d = 0; d < datasets_.size(); ++d) {
    begins_.push_back(stripe_bytes_);
    stripe_bytes_ += chunk_bytes(d);
  }
  stripe_bytes_ = whole_pages(stripe_bytes_);  // no two processes write to one
}

std::uint64_t PlacedRows::chunk_bytes(std::size_t dataset) const {
  return stripe_rows_ * datasets_[dataset].row_bytes + sizeof(std::uint32_t);
}

std::vector<PlacedRows::Piece> PlacedRows::pieces(std::uint64_t& end, std::uint64_t rows) const {
  std::vector<Piece> all;
  for (std::uint64_t first = 0, take = 0; first < rows; first += take) {
    const std::uint64_t before = (rows_ + first) % stripe_rows_;
    take = std::min(rows - first, stripe_rows_ - before);
    all.push_back({before > 0 ? stripes_.back() : end, before, first, take});
    if (before == 0) end += stripe_bytes_;
  }
  return all;
}

std::vector<PlacedRows::Piece> PlacedRows::skip(std::uint64_t& end, std::uint64_t rows) {
  std::vector<Piece> all = pieces(end, rows);
  for (const Piece& piece : all)
    if (piece.before == 0) stripes_.push_back(piece.at);
  rows_ += rows;
  return all;
}

std::vector<PlacedRows::Stripe> PlacedRows::place(std::uint64_t& end, std::uint64_t rows, const Values& values) {
  for (std::size_t d = 0; d < datasets_.size(); ++d) datasets_[d].sum.add(values[d]);
  std::vector<Stripe> complete;
  for (const Piece& piece : skip(end, rows)) {
    Pages begun = piece.before > 0 ? std::move(last_) : Pages();
    if (piece.before + piece.rows == stripe_rows_) {
      complete.push_back({piece, std::move(begun)});
      continue;
    }
    last_ = piece.before > 0 ? std::move(begun) : Pages(stripe_bytes_);
    copy(last_, piece, values);
    changed_ = true;
  }
  return complete;
}

void PlacedRows::copy(const Pages& to, const Piece& piece, const Values& values) const {
  for (std::size_t d = 0; d < datasets_.size(); ++d) {
    const std::uint64_t size = datasets_[d].row_bytes;
    std::memcpy(to.data() + begins_[d] + piece.before * size, values[d].data() + piece.first * size, piece.rows * size);
  }
}

/// Writes a stripe with its checksums.
bool PlacedRows::put(DirectFile& file, std::uint64_t at, const Pages& stripe) const {
  for (std::size_t d = 0; d < datasets_.size(); ++d) {
    const std::uint64_t size = stripe_rows_ * datasets_[d].row_bytes;
    const std::uint32_t sum = fletcher32({stripe.data() + begins_[d], size});
    std::memcpy(stripe.data() + begins_[d] + size, &sum, sizeof sum);
  }
  return file.write(at, stripe);
}

bool PlacedRows::write(DirectFile& file, Stripe stripe, const Values& values) const {
  if (stripe.begun.size() == 0) stripe.begun = Pages(stripe_bytes_);
  copy(stripe.begun, stripe.piece, values);
  return put(file, stripe.piece.at, stripe.begun);
}

bool PlacedRows::flush(DirectFile& file) {
  if (!changed_ || rows_ % stripe_rows_ == 0) return true;
  for (std::size_t d = 0; d < datasets_.size(); ++d) {
    const std::uint64_t size = datasets_[d].row_bytes, filled = rows_ % stripe_rows_;
    std::memset(last_.data() + begins_[d] + filled * size, 0, (stripe_rows_ - filled) * size);
  }
  changed_ = false;
  return put(file, stripes_.back(), last_);
}

bool PlacedRows::read(int file, std::uint64_t& end, std::uint64_t rows, std::vector<std::string>& values) const {
  values.resize(datasets_.size());
  for (std::size_t d = 0; d < datasets_.size(); ++d) values[d].resize(rows * datasets_[d].row_bytes);
  for (const Piece& piece : pieces(end, rows))
    for (std::size_t d = 0; d < datasets_.size(); ++d) {
      const std::uint64_t size = datasets_[d].row_bytes;
      if (!read_at(file, piece.at + begins_[d] + piece.before * size, values[d].data() + piece.first * size,
                   piece.rows * size))
        return false;
    }
  return true;
}

std::string PlacedRows::tail() const {
  std::string bytes;
  for (const Dataset& dataset : datasets_) bytes += dataset.sum.state();
  if (rows_ % stripe_rows_ > 0) bytes.append(last_.data(), last_.size());
  return bytes;
}

void PlacedRows::take_tail(std::string_view& bytes) {
  for (Dataset& dataset : datasets_) dataset.sum.go_on(bytes);
  if (rows_ % stripe_rows_ == 0) return;
  if (bytes.size() < stripe_bytes_) throw std::length_error("tail of rows");
  last_ = Pages(stripe_bytes_);
  std::memcpy(last_.data(), bytes.data(), last_.size());
  bytes.remove_prefix(last_.size());
  changed_ = true;
}

}  // namespace tactel::host
