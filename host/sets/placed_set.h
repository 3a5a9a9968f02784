// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/sets/chunk_header.h"
#include "host/sets/contact_set.h"
#include "host/sets/direct_file.h"
#include "host/sets/placed_rows.h"

namespace tactel::host {

/// The first chunks of an unfinished set, their rows where the set file will have them. Rows are written once: to
/// finish the set, HDF5 puts its headers around them. Files in a folder: `set`, and for each process `NNNN.placed` with
/// the headers of the chunks that it wrote. Of several processes one at a time places the next chunk, and tells the
/// process that has the chunk behind it how to go on; all write at once.
class PlacedSet {
 public:
  /// Opens the files of process `writer`, or creates them. Throws ConfigError and std::system_error where one cannot be
  /// used.
  PlacedSet(const std::filesystem::path& folder, const SetColumns& columns, int writer);
  ~PlacedSet();
  PlacedSet(const PlacedSet&) = delete;
  PlacedSet& operator=(const PlacedSet&) = delete;

  static std::filesystem::path set_file(const std::filesystem::path& folder) { return folder / "set"; }
  /// Returns the files with headers.
  static std::vector<std::filesystem::path> header_files(const std::filesystem::path& folder);

  /// Takes the first chunks of these that follow each other and are whole; the others are forgotten, with the files of
  /// other processes. Throws ConfigError and std::system_error where a file cannot be used.
  void resume(const std::vector<ChunkHeader>& headers);

  const std::vector<ChunkHeader>& chunks() const { return chunks_; }  ///< of all processes
  /// A chunk that has its place, but is not written.
  struct Unwritten {
    std::vector<PlacedRows::Stripe> rows, parameters;
  };
  /// Gives the next chunk its place. `payload`: its datasets, then its parameters. Returns none where the file cannot
  /// be written, with errno.
  std::optional<Unwritten> place(const ChunkHeader& header, const std::vector<std::string_view>& payload);
  /// Writes the last chunk that was placed. Returns false on failure, with errno.
  bool write(Unwritten chunk, const std::vector<std::string_view>& payload);
  /// Writes the rows that wait for those behind them. Returns false on failure, with errno.
  bool flush();
  bool sync() const;
  void begin_sync() const;  ///< without waiting for the disk

  /// Returns what another process needs to place the next chunk. Headers are those from chunk `from` on.
  std::string tail(std::uint64_t from) const;
  /// Goes on behind another process. `check` throws for a header that does not belong here. Throws std::length_error
  /// where the tail is too short.
  template <class Check>
  void take_tail(std::string_view tail, const Check& check) {
    for (const ChunkHeader& header : take_headers(tail)) check(header);
    take_rows(tail);
  }

  /// Calls visit(header, payload) for all chunks, their datasets and parameters one after the other. Returns false
  /// where a file cannot be read or a checksum differs.
  template <class Visit>
  bool each(const Visit& visit) const {
    Places places(columns_);
    std::string payload;
    for (const ChunkHeader& header : chunks_) {
      if (!read(places, header, payload)) return false;
      visit(header, payload);
      places.skip(header, columns_);
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
    void skip(const ChunkHeader& header, const SetColumns& columns);
    PlacedRows rows;
    std::optional<PlacedRows> parameters, tactels;
    std::uint64_t end;
  };
  bool read(const Places& places, const ChunkHeader& header, std::string& payload) const;
  std::vector<ChunkHeader> take_headers(std::string_view& tail);
  void take_rows(std::string_view tail);

  SetColumns columns_;
  std::filesystem::path folder_;
  int file_ = -1, headers_ = -1;
  DirectFile direct_;  ///< `set` again, for rows
  Places places_;
  std::vector<ChunkHeader> chunks_;
};

}  // namespace tactel::host
