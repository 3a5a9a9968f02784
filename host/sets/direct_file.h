// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>

namespace tactel::host {

/// Disks want offsets, lengths and memory in multiples of it.
inline constexpr std::size_t page_bytes = 4096;
constexpr std::size_t whole_pages(std::size_t bytes) { return (bytes + page_bytes - 1) / page_bytes * page_bytes; }

/// Memory of whole pages, for a DirectFile.
class Pages {
 public:
  Pages() = default;
  /// The bytes of the last page are 0 at first; the others are anything.
  explicit Pages(std::size_t bytes);
  char* data() const { return memory_.get(); }
  std::size_t size() const { return size_; }

 private:
  struct Free {
    void operator()(char* memory) const;
  };
  std::unique_ptr<char, Free> memory_;
  std::size_t size_ = 0;
};

/// A file to which whole pages go past the system's page cache (O_DIRECT), or through it where the file system cannot.
/// The cache would copy every byte into pages that the system must find first, which took more processor time than all
/// sums of these bytes.
class DirectFile {
 public:
  /// Opens a file that exists. Throws std::system_error.
  explicit DirectFile(const std::filesystem::path& path);
  ~DirectFile();
  DirectFile(const DirectFile&) = delete;
  DirectFile& operator=(const DirectFile&) = delete;

  /// Writes pages; `at`: a multiple of page_bytes. Returns false where the file cannot be written, with errno.
  bool write(std::uint64_t at, const Pages& pages);
  bool direct() const { return direct_; }

 private:
  int file_ = -1;
  bool direct_ = true;
};

}  // namespace tactel::host
