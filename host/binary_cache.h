#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace tactel::host {

struct StoredBinary {
  std::set<std::string> kernels;  ///< those that had been launched, and so compiled, when it was stored
  std::vector<unsigned char> binary;
};

/// One program's binary in a directory. The file holds the whole key, so that two keys with one hash cannot be
/// confused, and a checksum. What cannot be read, is damaged or belongs to another key counts as absent; what cannot be
/// written is not stored.
class BinaryCache {
 public:
  /// `name` begins the file's name, for people; `key` is all that the binary depends on.
  BinaryCache(const std::filesystem::path& directory, const std::string& name, std::string key);
  std::optional<StoredBinary> load() const;
  bool store(const StoredBinary& stored) const;  ///< under a temporary name, then renamed; false when that failed
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  std::string key_;
};

/// FNV-1a, 64 bit (http://www.isthe.com/chongo/tech/comp/fnv/).
std::uint64_t fnv1a(std::string_view bytes);

}  // namespace tactel::host
