// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace tactel::host {

/// Folder of compiled kernels between runs.
struct CachePlace {
  std::filesystem::path folder;  ///< empty: no candidate can be used
  std::string trouble;           ///< of the candidates before it, "PATH (reason), ..."
};
/// Room that a folder needs for compiled kernels, bytes: a program takes some 100 kB.
inline constexpr std::size_t cache_room = std::size_t{8} << 20;

/// Takes the first of the candidates that can be written and has `room` bytes left. `shared_parents`: folders that
/// others can write, too; in each a folder "tactel-UID" is taken if it is ours alone.
CachePlace choose_cache(const std::filesystem::path& own, std::span<const std::filesystem::path> shared_parents,
                        std::size_t room = cache_room);

/// PoCL's cache of compiled kernels, guarded: PoCL loads what it finds there and aborts on a damaged file. A list of
/// the files in it, with sizes and checksums, stands in `sealed`. Files are listed after they have reached the disk, so
/// that a power cut leaves files that are not listed, never a listed file that is damaged.
///
/// A process is in the folder from the construction of its CompileCache to its end. Files are removed only by a process
/// that is alone in the folder: PoCL compiles some kernels at their first launch and loads files at any time, so no
/// other moment is safe.
class CompileCache {
 public:
  /// Enters the folder. Where no other process is in it, removes the programs with a file that is damaged or not
  /// listed. Cost: one stat a file; content is read only where the time of change differs.
  explicit CompileCache(std::filesystem::path folder);
  ~CompileCache();
  CompileCache(const CompileCache&) = delete;
  CompileCache& operator=(const CompileCache&) = delete;

  std::size_t damaged() const { return damaged_; }  ///< programs removed because a listed file had changed

  /// One compilation. One exists at a time, over all threads and processes; others wait, so that each finds what the
  /// one before it compiled. PoCL aborts where the disk is full; the program then says so and ends with
  /// ExitCode device_failed.
  class Use {
   public:
    explicit Use(const CompileCache& cache);
    ~Use();
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

    /// Brings new files to the disk and lists them. Failure costs the next run a compilation, nothing else.
    void seal() const noexcept;

    /// Returns the binary that keep_program stored under this key, by any process; empty where there is none, or where
    /// its file is damaged.
    std::string program(std::string_view key) const;

    /// Stores the binary of a built program, from which the device builds it again without its compiler. `key`: all
    /// that it depends on. Failure costs the next run the time of the compiler's front end.
    void keep_program(std::string_view key, std::string_view binary) const noexcept;

    /// Returns what to do where the folder has too little room for a compilation; else nothing.
    std::string advice() const;

   private:
    /// Handler of SIGABRT, by which PoCL ends where it cannot write a kernel.
    static void explain_abort(int signal);
    static std::atomic<const Use*> under_way;

    const std::filesystem::path folder_;
    const std::string prefix_ = "error: ", remedy_;
    int lock_ = -1;  ///< descriptor; -1: the folder cannot be locked, and nothing is listed
  };

 private:
  void check();

  std::filesystem::path folder_;
  int presence_ = -1;  ///< descriptor with the lock of a process in the folder; -1: none can be had
  std::size_t damaged_ = 0;
};

}  // namespace tactel::host
