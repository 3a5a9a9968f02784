// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace tactel::fem {

// Results that are arrays of numbers, in files of a cache folder: a file for each key. A file is believed only where
// magic, format version, byte order, key and sizes are the expected ones, its checksum is right and every number is
// finite. Files are written under a temporary name, then renamed.

/// A file of the cache and the text that it must contain: all that the result depends on, to the last digit.
struct CacheFile {
  std::filesystem::path path;
  std::string key;
};

/// Returns the file `directory`/`name`-HASH.`kind`, HASH of the key; its path is empty where `directory` is.
CacheFile cache_file(const std::filesystem::path& directory, const std::string& name, const std::string& kind,
                     std::string key);

/// Fills the arrays, in the file's order. Returns false where the file is missing or not believed; the arrays may then
/// hold anything.
bool read_arrays(const CacheFile& file, std::span<const std::span<double>> arrays);

/// What the files of this cache in a folder may take together: those not read for longest are removed.
inline constexpr std::uintmax_t most_cached = std::uintmax_t{1} << 30;
void bound_cache(const std::filesystem::path& directory, std::uintmax_t most = most_cached);

/// Writes the arrays, makes the folder and bounds it. Failure leaves no trace: the next run computes them again.
void write_arrays(const CacheFile& file, std::span<const std::span<const double>> arrays);

}  // namespace tactel::fem
