#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>

#include "host/contact_set.h"

namespace tactel::host {

/// Where the chunks of a set wait until all are there: a folder SET.h5.parts beside the set to be. A chunk is appended
/// to a file with a checksum, so that a program killed at any moment leaves whole chunks and at most one torn, which
/// the next run finds and cuts off. Any number of processes may add chunks, each to a file of its own (`writer`).
class SetSpool {
 public:
  enum class Open { fresh, resume, join };  ///< join: another process of the same run has opened it
  /// `plan` is all that the rows depend on, as text. Throws ConfigError when another run is at work there, when there
  /// is something to resume and `fresh` was asked for, nothing of this plan for `resume`, or it cannot be written.
  SetSpool(const std::filesystem::path& output, const std::string& plan, int writer, Open how);
  ~SetSpool();
  SetSpool(const SetSpool&) = delete;
  SetSpool& operator=(const SetSpool&) = delete;

  /// Chunks that are there, of every writer.
  std::set<std::uint64_t> chunks() const;
  /// Throws ConfigError when the disk is full; what was there before stays whole.
  void append(std::uint64_t chunk, const ContactSet& rows);
  /// Makes the set file of chunks 0 ... count - 1, all of which must be there, and removes the folder. `set`:
  /// attributes; contacts that fell back, stayed unsolved or are too deep are summed up into it.
  void assemble(std::uint64_t count, ContactSet& set);
  std::uint64_t rows() const;   ///< of all chunks
  std::size_t torn() const;     ///< places where a file was cut off on opening
  std::uint64_t bytes() const;  ///< appended by this object

  static std::filesystem::path folder(const std::filesystem::path& output);
  /// Removes an earlier run's folder. Throws ConfigError when that run is still at work.
  static void discard(const std::filesystem::path& output);

 private:
  struct Place {
    std::filesystem::path file;
    std::uint64_t offset = 0, bytes = 0, rows = 0, fell_back = 0, unsolved = 0, too_deep = 0;
  };
  void check_plan(const std::string& plan, Open how) const;
  void scan(const std::filesystem::path& file, bool cut);
  void open_own_file(int writer);
  ContactSet load(const Place& place, int inputs) const;

  std::filesystem::path output_, folder_, own_;
  std::map<std::uint64_t, Place> chunks_;
  std::size_t torn_ = 0;
  std::uint64_t bytes_ = 0;
  int lock_ = -1, file_ = -1;
};

}  // namespace tactel::host
