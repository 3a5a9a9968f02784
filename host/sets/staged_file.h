// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string_view>
#include <vector>

namespace tactel::host {

/// A file whose bytes gather in aligned blocks. Full blocks go to the disk past the system's page cache (O_DIRECT),
/// or through it where the file system cannot. The cache would copy every byte into pages that the system must find
/// first, which took more processor time than all sums of these bytes.
class StagedFile {
 public:
  /// Opens a file that exists. Throws std::system_error.
  explicit StagedFile(const std::filesystem::path& path);
  ~StagedFile();
  StagedFile(const StagedFile&) = delete;
  StagedFile& operator=(const StagedFile&) = delete;

  /// Puts bytes where they belong. A block that has all its bytes is written. Returns false where the file cannot be
  /// written, with errno.
  bool write(std::uint64_t at, std::string_view bytes);
  /// Writes what blocks have so far. They stay in memory for the bytes that follow.
  bool flush();

 private:
  struct Free {
    void operator()(char* memory) const;
  };
  using Memory = std::unique_ptr<char, Free>;  ///< of a block, aligned
  struct Block {
    Memory memory;
    std::size_t filled = 0;        ///< bytes that write() put
    std::size_t from = 0, to = 0;  ///< the part that the file lacks
  };
  Block* block_at(std::uint64_t number);
  bool put(std::uint64_t number, Block& block);

  int file_ = -1;
  bool direct_ = true;
  std::map<std::uint64_t, Block> blocks_;
  std::vector<Memory> spare_;
};

}  // namespace tactel::host
