#include "host/binary_cache.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <iterator>

namespace tactel::host {
namespace {

namespace fs = std::filesystem;
constexpr std::string_view magic = "tactel program 1\n";

// File: magic, checksum of all that follows (8 bytes), key, kernel names joined by spaces, binary; each of the three
// with its length (8 bytes) before it. Byte order is the machine's: a binary serves no other.
void put(std::string& out, std::uint64_t number) { out.append(reinterpret_cast<const char*>(&number), sizeof number); }

void put(std::string& out, std::string_view part) {
  put(out, part.size());
  out += part;
}

std::optional<std::uint64_t> take_number(std::string_view& in) {
  std::uint64_t number = 0;
  if (in.size() < sizeof number) return std::nullopt;
  std::memcpy(&number, in.data(), sizeof number);
  in.remove_prefix(sizeof number);
  return number;
}

std::optional<std::string_view> take(std::string_view& in) {
  const std::optional<std::uint64_t> size = take_number(in);
  if (!size || *size > in.size()) return std::nullopt;
  const std::string_view part = in.substr(0, *size);
  in.remove_prefix(*size);
  return part;
}

std::string joined(const std::set<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += word + ' ';
  return text;
}

std::set<std::string> split(std::string_view text) {
  std::set<std::string> words;
  for (std::size_t end; (end = text.find(' ')) != text.npos; text.remove_prefix(end + 1))
    words.emplace(text.substr(0, end));
  return words;
}

std::optional<StoredBinary> decode(std::string_view content, std::string_view key) {
  if (!content.starts_with(magic)) return std::nullopt;
  content.remove_prefix(magic.size());
  const auto checksum = take_number(content);
  if (!checksum || *checksum != fnv1a(content)) return std::nullopt;
  const auto its_key = take(content);
  const auto kernels = take(content);
  const auto binary = take(content);
  if (!binary || *its_key != key) return std::nullopt;
  return StoredBinary{split(*kernels), {binary->begin(), binary->end()}};
}

std::string encode(const StoredBinary& stored, std::string_view key) {
  std::string body;
  put(body, key);
  put(body, joined(stored.kernels));
  put(body, std::string_view(reinterpret_cast<const char*>(stored.binary.data()), stored.binary.size()));
  std::string content(magic);
  put(content, fnv1a(body));
  return content + body;
}

}  // namespace

std::uint64_t fnv1a(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const unsigned char byte : bytes) hash = (hash ^ byte) * 0x100000001b3u;
  return hash;
}

BinaryCache::BinaryCache(const fs::path& directory, const std::string& name, std::string key)
    : path_(directory / fmt::format("{}-{:016x}.bin", fs::path(name).stem().string(), fnv1a(key))),
      key_(std::move(key)) {}

std::optional<StoredBinary> BinaryCache::load() const {
  std::ifstream file(path_, std::ios::binary);
  if (!file) return std::nullopt;
  const std::string content(std::istreambuf_iterator<char>(file), {});
  return decode(content, key_);
}

bool BinaryCache::store(const StoredBinary& stored) const {
  std::error_code error;
  fs::create_directories(path_.parent_path(), error);
  const fs::path temporary = fmt::format("{}.{}", path_.string(), getpid());
  {
    std::ofstream file(temporary, std::ios::binary);
    const std::string content = encode(stored, key_);
    file.write(content.data(), static_cast<std::streamsize>(content.size()));
    file.close();
    if (!file) error = std::make_error_code(std::errc::io_error);
  }
  if (!error) fs::rename(temporary, path_, error);
  if (error) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
  }
  return !error;
}

}  // namespace tactel::host
