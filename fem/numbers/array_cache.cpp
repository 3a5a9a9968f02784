// SPDX-License-Identifier: Apache-2.0
#include "fem/numbers/array_cache.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>
#include <random>
#include <vector>

namespace tactel::fem {
namespace {

namespace fs = std::filesystem;

// Raised whenever the layout below changes.
constexpr std::uint32_t format_version = 1;

/// Fowler, Noll and Vo's FNV-1a, 64 bits (RFC 9923). Each step is invertible, so a change of any one byte always shows.
std::uint64_t checksum(const std::string& bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3;
  return hash;
}

std::string hexadecimal(std::uint64_t number) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(number));
  return text;
}

template <class Number>
void append(std::string& bytes, const Number& number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

/// What a file begins with: magic, version, byte order, key, sizes of the arrays. The reader builds it anew and
/// compares, so that nothing a foreign file claims is ever believed.
template <class Arrays>
std::string header(const std::string& key, const Arrays& arrays) {
  std::string bytes = "TACTEL\r\n";
  append(bytes, format_version);
  append(bytes, std::uint32_t{0x01020304});
  append(bytes, std::uint64_t{key.size()});
  bytes += key;
  for (const auto& array : arrays) append(bytes, static_cast<std::int64_t>(array.size()));
  return bytes;
}

/// The whole file if it has exactly the wanted size, else nothing.
std::optional<std::string> read_file(const fs::path& path, std::size_t size) {
  std::error_code error;
  if (!fs::is_regular_file(path, error) || fs::file_size(path, error) != size || error) return {};
  std::ifstream file(path, std::ios::binary);
  std::string bytes(size, '\0');
  if (!file.read(bytes.data(), static_cast<std::streamsize>(size))) return {};
  return bytes;
}

bool write_new_file(const fs::path& path, const std::string& bytes) {
  // "x": never over a file that someone else is writing.
  std::FILE* file = std::fopen(path.c_str(), "wbx");
  if (!file) return false;
  const bool whole = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  return (std::fclose(file) == 0) && whole;
}

/// Under a name of its own, then renamed: readers and other writers see a whole file or none. Failure leaves no trace.
void store(const fs::path& path, const std::string& bytes) {
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  std::random_device random;
  const std::uint64_t unique = (std::uint64_t{random()} << 32) ^ random();
  const fs::path temporary = path.string() + "." + hexadecimal(unique) + ".tmp";
  if (write_new_file(temporary, bytes))
    fs::rename(temporary, path, error);
  else
    error = std::make_error_code(std::errc::io_error);
  if (error) fs::remove(temporary, error);
}

/// Whether a name is that of a file of the cache: NAME-HASH.KIND.
bool named_as_cached(const fs::path& path) {
  constexpr std::size_t digits = 16;
  const std::string stem = path.stem().string();
  return path.has_extension() && stem.size() > digits && stem[stem.size() - digits - 1] == '-' &&
         stem.find_first_not_of("0123456789abcdef", stem.size() - digits) == std::string::npos;
}

}  // namespace

void bound_cache(const fs::path& directory, std::uintmax_t most) {
  struct File {
    fs::file_time_type used;
    std::uintmax_t size;
    fs::path path;
  };
  std::vector<File> files;
  std::uintmax_t all = 0;
  std::error_code error;  // files may vanish meanwhile, by another process
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, error)) {
    if (!named_as_cached(entry.path()) || !entry.is_regular_file(error)) continue;
    const std::uintmax_t size = entry.file_size(error);
    if (error) continue;
    files.push_back({entry.last_write_time(error), size, entry.path()});
    all += size;
  }
  std::ranges::sort(files, {}, &File::used);
  for (auto file = files.begin(); file != files.end() && all > most; ++file)
    if (fs::remove(file->path, error)) all -= file->size;
}

CacheFile cache_file(const fs::path& directory, const std::string& name, const std::string& kind, std::string key) {
  if (directory.empty()) return {{}, std::move(key)};
  fs::path path = directory / (name + "-" + hexadecimal(checksum(key)) + "." + kind);
  return {std::move(path), std::move(key)};
}

bool read_arrays(const CacheFile& file, std::span<const std::span<double>> arrays) {
  if (file.path.empty()) return false;
  const std::string begin = header(file.key, arrays);
  std::size_t values = 0;
  for (const auto& array : arrays) values += array.size();
  const std::size_t sum_at = begin.size() + values * sizeof(double);
  std::optional<std::string> bytes = read_file(file.path, sum_at + sizeof(std::uint64_t));
  if (!bytes || bytes->compare(0, begin.size(), begin) != 0) return false;
  std::uint64_t written;
  std::memcpy(&written, bytes->data() + sum_at, sizeof written);
  bytes->resize(sum_at);
  if (checksum(*bytes) != written) return false;
  const char* from = bytes->data() + begin.size();
  for (const auto& array : arrays) {
    std::memcpy(array.data(), from, array.size_bytes());
    from += array.size_bytes();
    if (!std::ranges::all_of(array, [](double number) { return std::isfinite(number); })) return false;
  }
  std::error_code error;
  fs::last_write_time(file.path, fs::file_time_type::clock::now(), error);  // used, so that bound_cache keeps it
  return true;
}

void write_arrays(const CacheFile& file, std::span<const std::span<const double>> arrays) {
  if (file.path.empty()) return;
  std::string bytes = header(file.key, arrays);
  for (const auto& array : arrays) bytes.append(reinterpret_cast<const char*>(array.data()), array.size_bytes());
  append(bytes, checksum(bytes));
  store(file.path, bytes);
  bound_cache(file.path.parent_path());
}

}  // namespace tactel::fem
