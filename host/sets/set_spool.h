// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "host/sets/contact_set.h"
#include "host/sets/placed_set.h"
#include "host/support/durable_file.h"

namespace tactel::host {

/// The processes that write one set: chunk k belongs to process k mod count.
struct Ring {
  int rank = 0, count = 1;
  std::function<void(int, std::string)> send{};           ///< to another process, without waiting for it
  std::function<std::optional<std::string>()> receive{};  ///< from any other; none: nothing has come
};

/// Chunks of an unfinished set: a folder SET.h5.parts beside the set. Every chunk goes where the set file will have it
/// (PlacedSet), one after the other: a chunk waits in memory for those before it. Of several processes, the one that
/// has given a chunk its place sends the end of the set to the process with the next chunk, and then writes its rows.
/// Every chunk has a checksum of its rows and one of the plan; a kill or a power cut leaves whole chunks and torn ones,
/// which the next run detects. The first process opens the folder before the others join it.
class SetSpool {
 public:
  enum class Open { fresh, resume, join };  ///< join: the first process of the same run has opened it
  /// `plan` is all inputs of the rows, as text; `columns` the datasets of the set; `count` its chunks, of which the
  /// first `existing` exist where this process joins. Throws ConfigError where another run uses the folder, or where
  /// `fresh` finds chunks to resume. Throws it also where the folder or a chunk belongs to another plan, chunks exist
  /// without a plan, or the folder cannot be written.
  SetSpool(const std::filesystem::path& output, const std::string& plan, const SetColumns& columns, std::uint64_t count,
           Open how, Ring ring = {}, std::uint64_t existing = 0);
  ~SetSpool();
  SetSpool(const SetSpool&) = delete;
  SetSpool& operator=(const SetSpool&) = delete;

  /// Returns how many chunks exist, the first ones.
  std::uint64_t chunks() const { return placed_->chunks().size(); }
  /// Returns the chunks of this process that are not placed, in the order in which they must come.
  std::vector<std::uint64_t> missing() const;
  /// Adds a chunk of this process, for place(). Waits where too many chunks wait; threads may add at once.
  void append(std::uint64_t chunk, ContactSet rows);
  /// Brings the next chunk of this process to its place, where it has come and those before it have theirs; waits for
  /// it for `wait` at most. It then survives a kill, and a power cut a second later. One thread calls it. Returns false
  /// where nothing is left to do. Throws ConfigError where the disk is full; earlier chunks stay whole.
  bool place(std::chrono::milliseconds wait);
  /// Takes no more chunks, and makes place() end the work of all processes.
  void stop();
  /// Brings what this process has placed to the disk.
  void flush();
  bool stopped() const { return stopped_; }  ///< by this process or by another
  /// Writes the set file from all chunks, compressed or not, in the first process. `set` holds the attributes; the
  /// counts of contacts that fell back, stayed unsolved, have no rows or are too deep, slid too far or never slid are
  /// added to it. Removes the folder after the set has reached the disk. Throws ConfigError where a chunk is missing.
  void assemble(ContactSet& set, bool compress = false);
  std::uint64_t rows() const;          ///< of all chunks
  bool torn() const { return torn_; }  ///< whether chunks were found that were not whole, or behind one that was not
  std::uint64_t bytes() const { return bytes_; }  ///< written by this object
  double seconds() const { return seconds_; }     ///< that place() took, without waiting

  static std::filesystem::path folder(const std::filesystem::path& output);
  /// Removes an earlier run's folder. Throws ConfigError while that run is still active.
  static void discard(const std::filesystem::path& output);

 private:
  struct Waiting {
    ChunkHeader header;
    ContactSet rows;
  };
  [[noreturn]] void fail(int error) const;
  ChunkHeader header_of(std::uint64_t chunk, const ContactSet& rows,
                        const std::vector<std::string_view>& payload) const;
  bool sync_sometimes();
  void check_plan(const std::string& plan, Open how) const;
  void check(const ChunkHeader& header) const;
  std::vector<ChunkHeader> headers();
  int owner(std::uint64_t chunk) const;
  void receive();
  void send_end();
  void send_stop();
  bool next_has_come();
  std::optional<Waiting> wait_for_next(std::chrono::milliseconds wait);
  void copy_rows(ContactSetWriter& writer) const;

  std::filesystem::path output_, folder_;
  std::uint64_t plan_sum_, count_, first_, next_;  ///< chunks: all, those that existed, the next of this process
  SetColumns columns_;
  Ring ring_;
  bool torn_ = false;
  std::uint64_t bytes_ = 0;
  double seconds_ = 0;
  std::optional<PlacedSet> placed_;
  bool holds_end_;      ///< of the set: no other process places the next chunk
  bool ended_ = false;  ///< by a stop
  std::mutex mutex_;
  std::map<std::uint64_t, Waiting> waiting_;
  std::atomic<bool> stopped_ = false;
  std::condition_variable changed_;
  std::chrono::steady_clock::time_point synced_{};
  FileLock lock_;
};

}  // namespace tactel::host
