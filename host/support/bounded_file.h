// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace tactel::host {

/// A file that was not read: "it is a folder", "it is no regular file", "it is larger than 16 MiB", "it changed while
/// it was read", or the reason of the system.
class UnreadableFile : public std::runtime_error {
 public:
  UnreadableFile(const std::string& why, bool missing) : std::runtime_error(why), missing(missing) {}
  bool missing;  ///< there is no such file
};

/// Whether the system would take a shorter name: for it a name ends at a NUL byte.
inline bool has_nul(const std::filesystem::path& path) { return path.native().find('\0') != std::string::npos; }

/// Returns the content of a regular file of `most` bytes or fewer. Throws UnreadableFile for every other file: folders,
/// devices, which may never end, pipes, which may wait for ever, files that grow, and names with a NUL byte. Waits for
/// no writer.
std::string read_bounded_file(const std::filesystem::path& path, std::uintmax_t most);

}  // namespace tactel::host
