// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "host/sets/contact_set.h"
#include "host/support/checksum.h"
#include "host/support/durable_file.h"

namespace tactel::host {

/// Header of the rows of a chunk. The byte order is that of the machine; the folder cannot be moved to another
/// kind.
struct ChunkHeader {
  static constexpr std::uint64_t right_magic = 0x396c6f6f70736c74;  // "tlspool9"

  std::uint64_t magic = 0, plan_sum = 0, chunk = 0, rows = 0, contacts = 0, inputs = 0, bytes = 0;
  SetCounts counts{};
  std::uint64_t payload_sum = 0;  ///< checksum of the rows that follow
  std::uint64_t header_sum = 0;   ///< checksum of the preceding members

  std::uint64_t sum() const {
    return checksum({reinterpret_cast<const char*>(this), offsetof(ChunkHeader, header_sum)});
  }
  bool whole() const { return magic == right_magic && header_sum == sum(); }
};

/// Chunks of an unfinished set: a folder SET.h5.parts beside the set. Each process appends the chunks that it makes to
/// a file of its own, `NNNN.chunks`, in any order. A header before each has a checksum of its rows and one of the plan.
/// A kill or a power cut leaves whole chunks and a torn one, which the next run detects. The first process opens the
/// folder before the others join it, and makes the set of the chunks of all.
class SetSpool {
 public:
  enum class Open { fresh, resume, join };  ///< join: the first process of the same run has opened it
  /// `plan` is all inputs of the rows, as text; `columns` the datasets of the set; `count` its chunks; `process` counts
  /// from 0. Throws ConfigError where another run uses the folder, or where `fresh` finds chunks to resume. Throws it
  /// also where the folder or a chunk belongs to another plan, chunks exist without a plan, or the folder cannot be
  /// written.
  SetSpool(const std::filesystem::path& output, const std::string& plan, const SetColumns& columns, std::uint64_t count,
           Open how, int process = 0);
  SetSpool(const SetSpool&) = delete;
  SetSpool& operator=(const SetSpool&) = delete;

  /// Returns 1 for every chunk that the first process found, else 0: [count], for Ranks::sum.
  std::vector<double> found() const;
  bool torn() const { return torn_; }  ///< whether it also found some that were not whole
  /// Writes a chunk; threads may do so at once. It then survives a kill, and a power cut after a flush. Throws
  /// ConfigError where the disk is full; other chunks stay whole.
  void append(std::uint64_t chunk, const ContactSet& rows);
  /// Brings what was appended to the disk, unless that was done within the time `apart`.
  void flush(std::chrono::seconds apart = {});
  /// Asks all processes of the run to stop.
  void stop() const;
  bool stopped() const;  ///< whether any process has asked

  /// Writes the set file from the chunks of all processes, compressed or not, in the first one. `set` holds the
  /// attributes; the counts of contacts that fell back, stayed unsolved, have no rows or are too deep, slid too far or
  /// never slid are added to it. Removes the folder after the set has reached the disk. Throws ConfigError where a
  /// chunk is missing.
  void assemble(ContactSet& set, bool compress = false);
  std::uint64_t rows() const;                     ///< of the chunks that this process knows: after assemble(), of all
  std::uint64_t bytes() const { return bytes_; }  ///< written by this object
  double seconds() const { return seconds_; }     ///< that it took

  static std::filesystem::path folder(const std::filesystem::path& output);
  /// Returns the bytes of the chunks that an earlier run left.
  static double bytes_left(const std::filesystem::path& output);
  /// Removes an earlier run's folder. Throws ConfigError while that run is still active.
  static void discard(const std::filesystem::path& output);

 private:
  struct Chunk {
    ChunkHeader header;
    const std::filesystem::path* file;
    std::uint64_t at;  ///< of its rows in the file
  };
  class Rows;
  [[noreturn]] void fail(int error) const;
  void check_plan(const std::string& plan, Open how) const;
  void check(const ChunkHeader& header) const;
  void find_chunks(bool checked, bool of_another_run);

  std::filesystem::path output_, folder_;
  std::uint64_t plan_sum_, count_;
  SetColumns columns_;
  FileLock lock_, file_lock_;  ///< of the folder, which the first process has; of the file of this one
  std::map<std::filesystem::path, std::uint64_t> files_;  ///< with their bytes that were looked at
  std::map<std::uint64_t, Chunk> chunks_;
  bool torn_ = false;
  std::mutex mutex_;
  hw::Descriptor file_;  ///< of this process
  std::uint64_t end_ = 0, bytes_ = 0;
  double seconds_ = 0;
  std::chrono::steady_clock::time_point synced_{};
};

/// Returns the chunks that a process makes: every n-th of those that were not found, of `processes` = n.
std::vector<std::uint64_t> missing_chunks(const std::vector<double>& found, int process = 0, int processes = 1);

}  // namespace tactel::host
