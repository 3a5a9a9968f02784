#pragma once
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <utility>

namespace tactel::host {

/// Folder of compiled kernels between runs.
struct CachePlace {
  std::filesystem::path folder;  ///< empty: no candidate can be used
  std::string trouble;           ///< of the candidates before it, "PATH (reason), ..."
};
/// Takes the first of the candidates that can be written and has `room` bytes left. `shared_parents`: folders that
/// others can write, too; in each a folder "tactel-UID" is taken if it is ours alone.
CachePlace choose_cache(const std::filesystem::path& own, std::span<const std::filesystem::path> shared_parents,
                        std::size_t room = std::size_t{8} << 20);

/// PoCL's cache of compiled kernels, guarded: PoCL loads what it finds there and aborts on a damaged file. A list of
/// the files in it, with sizes and checksums, stands in `sealed`. Files are listed after they have reached the disk, so
/// that a power cut leaves files that are not listed, never a listed file that is damaged.
class CompileCache {
 public:
  explicit CompileCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// The use of the cache for one compilation. One exists at a time, over all threads and processes; others wait.
  /// Cost: one stat a file; content is read only where the time of change differs.
  class Use {
   public:
    /// Removes the programs with a file that is damaged or not listed: none is in the making now, so that a file that
    /// is not listed was left by a process that did not finish.
    explicit Use(const CompileCache& cache);
    ~Use();
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

    std::size_t damaged() const { return damaged_; }  ///< programs removed because a listed file had changed
    /// Brings new files to the disk and lists them. Failure costs the next run a compilation, nothing else.
    void seal() const noexcept;

   private:
    void check();

    const std::filesystem::path folder_;
    int lock_ = -1;  ///< descriptor; -1: the folder cannot be locked, and nothing is removed or listed
    std::size_t damaged_ = 0;
  };

 private:
  std::filesystem::path folder_;
};

}  // namespace tactel::host
