// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host/sets/contact_set.h"
#include "host/sets/staged_file.h"
#include "host/support/checksum.h"

namespace tactel::host {

/// Returns Fletcher's checksum of a chunk, 32 bit, as HDF5's filter appends it.
std::uint32_t fletcher32(std::string_view bytes);

/// Datasets with rows in common, in chunks of equal numbers of rows. The chunks of all datasets with the same rows lie
/// side by side in a file, each with its Fletcher checksum: a stripe. Rows are written once, where they stay.
class PlacedRows {
 public:
  struct Dataset {
    std::string name;
    std::uint64_t row_bytes = 0;
    RunningChecksum sum{};  ///< of all rows so far
  };
  PlacedRows(std::vector<Dataset> datasets, std::uint64_t rows_of_stripe);

  /// Adds rows, `values`: [datasets] their bytes. New stripes begin at `end` of the file, which grows. Returns false
  /// where the file cannot be written, with errno.
  bool append(StagedFile& file, std::uint64_t& end, std::uint64_t rows, const std::vector<std::string_view>& values);
  /// The same for rows that the file has: reads them. `values`: [datasets].
  bool read(int file, std::uint64_t& end, std::uint64_t rows, std::vector<std::string>& values);
  /// Completes the last stripe with zeros.
  bool finish(StagedFile& file);

  std::uint64_t rows() const { return rows_; }
  std::uint64_t rows_of_stripe() const { return stripe_rows_; }
  const std::vector<Dataset>& datasets() const { return datasets_; }
  const std::vector<std::uint64_t>& stripes() const { return stripes_; }  ///< offsets in the file
  /// Returns where the chunk of a dataset begins in its stripe, and its bytes with checksum.
  std::uint64_t chunk_begin(std::size_t dataset) const { return begins_[dataset]; }
  std::uint64_t chunk_bytes(std::size_t dataset) const;

 private:
  void keep(std::uint64_t first, std::uint64_t rows, const std::vector<std::string_view>& values);

  std::vector<Dataset> datasets_;
  std::vector<std::uint64_t> begins_;  ///< [datasets] within a stripe
  std::uint64_t stripe_rows_, stripe_bytes_ = 0, rows_ = 0;
  std::vector<std::uint64_t> stripes_;
  std::vector<std::string> last_;  ///< [datasets] rows of a stripe that more than one append fills
};

}  // namespace tactel::host
