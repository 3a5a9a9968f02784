// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <filesystem>
#include <string>
#include <string_view>

#include "hw/descriptor.h"

namespace tactel::host {

/// A file under a temporary name beside its target until commit(). A reader sees the old file or the new one,
/// never a part. A committed file survives a power cut (write, fsync of the file, rename, fsync of the folder).
/// The temporary is created anew, never through a symbolic link, and is locked by flock during the life of its
/// process. A symbolic link at `path` stays; its target is replaced. Every member throws ConfigError naming
/// `option` (as --output), the path and the reason; the temporary is then removed.
class DurableFile {
 public:
  DurableFile(std::string option, std::filesystem::path path);
  /// Removes the temporary unless it was committed.
  ~DurableFile();

  /// Returns the temporary, for libraries that write by name, such as HDF5. They must close it before commit().
  const std::filesystem::path& temporary() const { return temporary_; }
  void write(std::string_view content);
  void commit();

 private:
  [[noreturn]] void fail(int error);
  void drop();

  std::string option_;
  std::filesystem::path path_, target_, temporary_;  ///< as given; with links resolved; empty after commit()
  hw::Descriptor file_;
};

/// Writes a whole file as a DurableFile. A target that is not a regular file (a pipe, /dev/stdout) is written
/// directly. Throws ConfigError naming `option`, as --json.
void write_file(const std::string& option, const std::filesystem::path& path, std::string_view content);

/// Throws ConfigError where write_file could not work at `path`, for a check before a long computation.
void check_writable(const std::string& option, const std::filesystem::path& path);

/// Creates a folder and its missing parents, so that they survive a power cut. Throws ConfigError as write_file.
void make_folder(const std::string& option, const std::filesystem::path& path);

/// Makes the names in a folder survive a power cut, after a file in it was created, renamed or removed. Returns
/// false on failure, with errno. A file system without this operation counts as done.
bool sync_folder(const std::filesystem::path& folder);

/// Writes all bytes to a descriptor. Returns false on failure, with errno.
bool write_all(int file, std::string_view bytes);

/// Removes the temporaries of killed processes from a folder: regular files of this user with names of
/// DurableFile that are abandoned. DurableFile does so once for each folder that it writes to.
void remove_leftovers(const std::filesystem::path& folder);

/// Returns 16 letters that the running kernel has until the machine starts again. Processes that have the same see each
/// other's locks; on some network file systems, others do not.
const std::string& running_kernel();

/// Whether what a process under `kernel` made, and held locked by flock, has no owner any more: nobody changed it for
/// `least`, for a day where that was another kernel, and its lock is free.
bool is_abandoned(int file, std::string_view kernel, std::chrono::seconds least = {});

/// A lock (flock) that ends with its process.
class FileLock {
 public:
  /// Locks a folder itself, without a file in it. Throws ConfigError: option, `path` and `allowed` where
  /// another process holds the lock. A file system without locks counts as free.
  static FileLock of_folder(const std::string& option, const std::filesystem::path& path, const std::string& allowed);
  /// Locks a file, which is created where it is missing.
  static FileLock of_file(const std::string& option, const std::filesystem::path& path, const std::string& allowed);
  bool held() const { return file_ >= 0; }
  void release() { file_.close(); }

 private:
  hw::Descriptor file_;
};

}  // namespace tactel::host
