// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host/sets/contact_set.h"
#include "host/sets/placed_set.h"
#include "host/support/durable_file.h"

namespace tactel::host {

/// Chunks of an unfinished set: a folder SET.h5.parts beside the set. The chunk that follows the first ones goes where
/// the set file will have it (PlacedSet). A chunk whose predecessors are missing waits in memory, one at a time, or
/// is appended to a spool file. Every chunk has a checksum of its rows and one of the plan; a kill or a power cut
/// leaves whole chunks and at most one torn chunk of a file, which the next run detects and removes. Any number of
/// processes may add chunks, each to a spool file of its own (`writer`); the one that does not join places them.
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
  /// Adds a chunk, which survives a kill once its predecessors are there, and a power cut a second later; threads may
  /// append at once. Throws ConfigError where the disk is full; earlier chunks stay whole.
  void append(std::uint64_t chunk, ContactSet rows);
  /// Brings chunks that wait to the disk.
  void flush();
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
    std::filesystem::path file;  ///< a spool file; empty: in its place
    std::uint64_t offset = 0;
    ChunkHeader header;
  };
  [[noreturn]] void fail(int error) const;
  ChunkHeader header_of(std::uint64_t chunk, const ContactSet& rows,
                        const std::vector<std::string_view>& payload) const;
  void spool(const ChunkHeader& header, const ContactSet& rows);
  bool sync_sometimes();
  void place_spooled(std::uint64_t count);
  void place_waiting(std::unique_lock<std::mutex>& lock);
  void check_plan(const std::string& plan, Open how) const;
  std::vector<std::filesystem::path> files() const;
  void scan(const std::filesystem::path& file, bool cut);
  void check_version(const std::filesystem::path& file) const;
  void check(const ChunkHeader& header, const std::filesystem::path& file) const;
  void open_own_file(int writer);
  ContactSet load(const Place& place) const;
  void copy_rows(ContactSetWriter& writer) const;
  void finish_copy(const ContactSet& set, std::uint64_t contacts, bool compress) const;

  std::filesystem::path output_, folder_, own_;
  std::uint64_t plan_sum_;
  SetColumns columns_;
  std::map<std::uint64_t, Place> chunks_;
  std::size_t torn_ = 0;
  std::uint64_t bytes_ = 0;
  std::mutex appending_;
  std::optional<PlacedSet> placed_;  ///< of the process that did not join
  bool placing_ = false;             ///< by a thread, without the mutex
  struct Waiting {
    ChunkHeader header;
    ContactSet rows;
  };
  std::map<std::uint64_t, Waiting> waiting_;  ///< for their predecessors
  std::condition_variable placed_some_;
  std::chrono::steady_clock::time_point synced_{};
  FileLock lock_;
  int file_ = -1;
};

}  // namespace tactel::host
