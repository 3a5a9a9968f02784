// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/sets/chunk_header.h"
#include "host/sets/contact_set.h"
#include "host/sets/placed_rows.h"

namespace tactel::host {

/// The first chunks of an unfinished set, their rows where the set file will have them. Rows are written once: to
/// finish the set, HDF5 puts its headers around them. Two files in a folder: `set`, and `placed` with the headers of
/// the chunks.
class PlacedSet {
 public:
  /// Opens the files or creates them, and takes the chunks that are whole; a torn one and those behind it are cut off.
  /// `check` throws for a header that does not belong here. Throws std::system_error where a file cannot be used.
  template <class Check>
  PlacedSet(const std::filesystem::path& folder, const SetColumns& columns, const Check& check)
      : PlacedSet(folder, columns) {
    std::vector<ChunkHeader> headers = read_headers(folder);
    for (const ChunkHeader& header : headers) check(header);
    resume(std::move(headers));
  }
  ~PlacedSet();
  PlacedSet(const PlacedSet&) = delete;
  PlacedSet& operator=(const PlacedSet&) = delete;

  /// Returns the headers that a folder has, without a look at the rows.
  static std::vector<ChunkHeader> read_headers(const std::filesystem::path& folder);
  static std::vector<std::filesystem::path> files(const std::filesystem::path& folder);

  const std::vector<ChunkHeader>& chunks() const { return chunks_; }
  bool torn() const { return torn_; }
  /// Adds the next chunk. `payload`: its datasets, then its parameters. Returns false on failure, with errno; then
  /// nothing more can be added.
  bool append(const ChunkHeader& header, const std::vector<std::string_view>& payload);
  bool sync() const;
  void begin_sync() const;  ///< without waiting for the disk
  /// Calls visit(header, payload) for all chunks, their datasets and parameters one after the other. Returns false
  /// where a file cannot be read or a checksum differs.
  template <class Visit>
  bool each(const Visit& visit) const {
    Places places(columns_);
    std::string payload;
    for (const ChunkHeader& header : chunks_) {
      if (!read(places, header, payload)) return false;
      visit(header, payload);
    }
    return true;
  }
  /// Returns whether every dataset has the rows of a chunk of HDF5's or more, as HDF5 wants it.
  bool fits_hdf5() const;
  /// Makes `set` a set file with the attributes of `set`, on the disk. Returns false on failure, with errno.
  bool finish(const ContactSet& set);

 private:
  /// All rows in their places.
  struct Places {
    explicit Places(const SetColumns& columns);
    PlacedRows rows;
    std::optional<PlacedRows> parameters, tactels;
    std::uint64_t end;
  };
  PlacedSet(const std::filesystem::path& folder, const SetColumns& columns);
  void resume(std::vector<ChunkHeader> headers);
  std::size_t take(std::span<const ChunkHeader> headers);
  bool read(Places& places, const ChunkHeader& header, std::string& payload) const;

  SetColumns columns_;
  int file_ = -1, headers_ = -1;
  StagedFile staged_;  ///< `set` again, for rows
  bool torn_ = false;
  Places places_;
  std::vector<ChunkHeader> chunks_;
};

}  // namespace tactel::host
