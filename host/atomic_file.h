#pragma once
#include <filesystem>
#include <string>
#include <string_view>

namespace tactel::host {

/// Writes a whole file under a temporary name beside `path`, then renames it: a reader sees the old file or the new
/// one, never a half. What is not a regular file (a pipe, /dev/stdout) is written straight. Throws ConfigError naming
/// `option`, as --json.
void write_file(const std::string& option, const std::filesystem::path& path, std::string_view content);

/// Throws ConfigError when write_file could not work at `path`: asked before a long computation, not after it.
void check_writable(const std::string& option, const std::filesystem::path& path);

}  // namespace tactel::host
