// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host/sets/direct_file.h"
#include "host/support/checksum.h"

namespace tactel::host {

/// Returns Fletcher's checksum of a chunk, 32 bit, as HDF5's filter appends it.
std::uint32_t fletcher32(std::string_view bytes);

/// Datasets with rows in common, in chunks of equal numbers of rows. The chunks of all datasets with the same rows lie
/// side by side in a file, each with its Fletcher checksum: a stripe, of whole pages. Rows are written once, where they
/// stay. A stripe is written at once, by the process that has its last row.
class PlacedRows {
 public:
  struct Dataset {
    std::string name;
    std::uint64_t row_bytes = 0;
    RunningChecksum sum{};  ///< of all rows so far
  };
  /// Rows first ... first + rows - 1 of those that come next, in a stripe that begins at `at` and has `before` rows.
  struct Piece {
    std::uint64_t at = 0, before = 0, first = 0, rows = 0;
  };
  /// A stripe with all its rows: those of `piece` are yet to be copied to the others in `begun`.
  struct Stripe {
    Piece piece;
    Pages begun;  ///< none where piece.before = 0
  };
  using Values = std::vector<std::string_view>;  ///< [datasets] the bytes of rows

  PlacedRows(std::vector<Dataset> datasets, std::uint64_t rows_of_stripe);

  /// Returns where the next rows will be. New stripes begin at `end` of the file, which grows.
  std::vector<Piece> pieces(std::uint64_t& end, std::uint64_t rows) const;
  /// The same, and goes on behind these rows, which are another's.
  std::vector<Piece> skip(std::uint64_t& end, std::uint64_t rows);
  /// The same, and takes the rows into the sums. Returns the stripes that they complete, for write(); the rows of one
  /// that is not complete stay here.
  std::vector<Stripe> place(std::uint64_t& end, std::uint64_t rows, const Values& values);
  /// Writes a stripe. Returns false where the file cannot be written, with errno.
  bool write(DirectFile& file, Stripe stripe, const Values& values) const;
  /// Writes the last stripe with the rows that are there, zeros and right checksums.
  bool flush(DirectFile& file);
  /// Reads the next rows from the file, which has them, without going on. `values`: [datasets].
  bool read(int file, std::uint64_t& end, std::uint64_t rows, std::vector<std::string>& values) const;

  /// Returns what the next rows need of those before: sums, and rows of the last stripe.
  std::string tail() const;
  /// Takes another's tail from the beginning of `bytes`, behind the same rows. Throws std::length_error where they are
  /// fewer.
  void take_tail(std::string_view& bytes);

  std::uint64_t rows() const { return rows_; }
  std::uint64_t rows_of_stripe() const { return stripe_rows_; }
  const std::vector<Dataset>& datasets() const { return datasets_; }
  const std::vector<std::uint64_t>& stripes() const { return stripes_; }  ///< offsets in the file
  /// Returns where the chunk of a dataset begins in its stripe, and its bytes with checksum.
  std::uint64_t chunk_begin(std::size_t dataset) const { return begins_[dataset]; }
  std::uint64_t chunk_bytes(std::size_t dataset) const;

 private:
  void copy(const Pages& to, const Piece& piece, const Values& values) const;
  bool put(DirectFile& file, std::uint64_t at, const Pages& stripe) const;

  std::vector<Dataset> datasets_;
  std::vector<std::uint64_t> begins_;  ///< [datasets] within a stripe
  std::uint64_t stripe_rows_, stripe_bytes_ = 0, rows_ = 0;
  std::vector<std::uint64_t> stripes_;
  Pages last_;            ///< rows of a stripe that is not complete
  bool changed_ = false;  ///< since it was written
};

}  // namespace tactel::host
