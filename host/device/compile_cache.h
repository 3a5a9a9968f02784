// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "hw/descriptor.h"

namespace tactel::host {

/// Folder of compiled kernels between runs.
struct CachePlace {
  std::filesystem::path folder;  ///< empty: no candidate can be used
  std::string trouble;           ///< of the candidates before it, "PATH (reason), ..."
};
/// Room that a folder needs for compiled kernels, bytes: a program takes some 100 kB.
inline constexpr std::size_t cache_room = std::size_t{8} << 20;

/// Takes the first of the candidates that can be written, has `room` bytes left and to which no other user can have
/// written (fem::distrust): machine code is loaded from it. `shared_parents`: folders that others can write, too; in
/// each a folder "tactel-UID" is a candidate.
CachePlace choose_cache(const std::filesystem::path& own, std::span<const std::filesystem::path> shared_parents,
                        std::size_t room = cache_room);

/// While it lives, an abort inside PoCL names its cause where `folder` is on a full disk. The process then ends with
/// ExitCode device_failed. One at a time counts.
class AbortNotice {
 public:
  explicit AbortNotice(const std::filesystem::path& folder);
  ~AbortNotice();
  AbortNotice(const AbortNotice&) = delete;
  AbortNotice& operator=(const AbortNotice&) = delete;

 private:
  static void explain(int signal);
  static std::atomic<const AbortNotice*> current;
  const std::filesystem::path folder_;
  const std::string text_;
};

/// Compiled programs, kept between runs. Each process gives PoCL a folder of its own for the files that PoCL compiles
/// and loads: PoCL aborts where another process removes one, or where one is half written. Processes share whole
/// programs alone. These get their names when they are on the disk, with a checksum. Nothing of this rests on locks,
/// which do not reach other hosts on some network file systems.
class CompileCache {
 public:
  /// Makes a folder for this process, and removes those of processes that are gone. Throws std::filesystem_error.
  explicit CompileCache(const std::filesystem::path& folder);
  /// The same in `own`, for a process that compiles for another.
  CompileCache(std::filesystem::path folder, std::filesystem::path own);
  ~CompileCache();
  CompileCache(const CompileCache&) = delete;
  CompileCache& operator=(const CompileCache&) = delete;

  /// Removes the folder of this process. PoCL must not compile or load afterwards.
  void leave() const noexcept;

  /// Returns the binary that keep_program stored under this key, by any process; empty where there is none, or where
  /// its file is damaged. Takes no lock: files are whole when they get their names.
  std::string program(std::string_view key) const;

  /// Stores the binary of a built program, from which the device builds it again without its compiler. `key`: all
  /// that it depends on. Failure costs the next run a compilation.
  void keep_program(std::string_view key, std::string_view binary) const noexcept;

  /// Returns what to do where a compilation lacks room on the disk or address space; else nothing.
  std::string advice() const;

  const std::filesystem::path& folder() const { return folder_; }
  const std::filesystem::path& own() const { return own_; }  ///< PoCL's folder of this process

  /// The turn to compile the program of a key, among processes. Other programs are not concerned. A process that dies
  /// gives its turn back. Threads of a process must not compete for one.
  class Turn {
   public:
    Turn(const CompileCache& cache, std::string_view key);
    ~Turn();
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    /// Tries to take it. Returns the process that has it, 0 where it is taken now, or where no process can be named.
    int take();

   private:
    int lock_;  ///< descriptor; -1: the folder cannot be locked
    long place_;
  };

 private:
  std::filesystem::path folder_, own_;
  hw::Descriptor presence_;   ///< with the lock of `own_`; -1: none can be had
  hw::Descriptor compiling_;  ///< of the turns; -1: none can be had
  int process_;
};

}  // namespace tactel::host
