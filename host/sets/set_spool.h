// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "host/sets/contact_set.h"
#include "host/support/durable_file.h"

namespace tactel::host {

/// Header of the rows of a chunk. The byte order is that of the machine; the folder cannot be moved to another
/// kind.
struct ChunkHeader {
  std::uint64_t magic = 0, plan_sum = 0, chunk = 0, rows = 0, contacts = 0, inputs = 0, bytes = 0;
  std::uint64_t fell_back = 0, unsolved = 0, too_deep = 0, without_rows = 0, far_slip = 0, never_slid = 0;
  std::uint64_t payload_sum = 0;  ///< checksum of the rows that follow
  std::uint64_t header_sum = 0;   ///< checksum of the preceding members
};

/// Chunks of an unfinished set: a folder SET.h5.parts beside the set. A chunk is appended to a file with a
/// checksum of its rows and one of the plan, and is on the disk when append() returns. A kill or a power cut
/// therefore leaves whole chunks and at most one torn chunk, which the next run detects and removes. Any number
/// of processes may add chunks, each to a file of its own (`writer`).
class SetSpool {
 public:
  enum class Open { fresh, resume, join };  ///< join: another process of the same run has opened it
  /// `plan` is all inputs of the rows, as text; `columns` the datasets of the set. Throws ConfigError where another
  /// run uses the folder, or where `fresh` finds chunks to resume. Throws it also where the folder or a chunk
  /// belongs to another plan, chunks exist without a plan, or the folder cannot be written.
  SetSpool(const std::filesystem::path& output, const std::string& plan, const SetColumns& columns, int writer,
           Open how);
  ~SetSpool();
  SetSpool(const SetSpool&) = delete;
  SetSpool& operator=(const SetSpool&) = delete;

  /// Returns the complete chunks of every writer.
  std::set<std::uint64_t> chunks() const;
  /// Appends a chunk; threads may append at once. Throws ConfigError where the disk is full; earlier chunks stay whole.
  void append(std::uint64_t chunk, const ContactSet& rows);
  /// Writes the set file from chunks 0 ... count - 1, which must all exist, compressed or not. `set` holds the
  /// attributes; the counts of contacts that fell back, stayed unsolved, have no rows or are too deep, slid too far or
  /// never slid are added to it. Removes the folder after the set has reached the disk.
  void assemble(std::uint64_t count, ContactSet& set, bool compress = false);
  std::uint64_t rows() const;   ///< of all chunks
  std::size_t torn() const;     ///< places where a file was cut off on opening
  std::uint64_t bytes() const;  ///< appended by this object

  static std::filesystem::path folder(const std::filesystem::path& output);
  /// Removes an earlier run's folder. Throws ConfigError while that run is still active.
  static void discard(const std::filesystem::path& output);

 private:
  struct Place {
    std::filesystem::path file;
    std::uint64_t offset = 0;
    ChunkHeader header;
  };
  void check_plan(const std::string& plan, Open how) const;
  std::vector<std::filesystem::path> files() const;
  void scan(const std::filesystem::path& file, bool cut);
  void check_version(const std::filesystem::path& file) const;
  void check(const ChunkHeader& header, const std::filesystem::path& file) const;
  void open_own_file(int writer);
  ContactSet load(const Place& place) const;
  void copy_rows(ContactSetWriter& writer) const;

  std::filesystem::path output_, folder_, own_;
  std::uint64_t plan_sum_;
  SetColumns columns_;
  std::map<std::uint64_t, Place> chunks_;
  std::size_t torn_ = 0;
  std::uint64_t bytes_ = 0;
  std::mutex appending_;
  FileLock lock_;
  int file_ = -1;
};

}  // namespace tactel::host
