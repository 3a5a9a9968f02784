// SPDX-License-Identifier: Apache-2.0
#include "host/support/bounded_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "hw/descriptor.h"

namespace tactel::host {
namespace {

[[noreturn]] void fail(int error) { throw UnreadableFile(std::strerror(error), error == ENOENT || error == ENOTDIR); }
[[noreturn]] void decline(const std::string& why) { throw UnreadableFile(why, false); }

/// Of a regular file, bytes.
std::uintmax_t size_of(int file) {
  struct stat status {};
  if (::fstat(file, &status) != 0) fail(errno);
  if (S_ISDIR(status.st_mode)) decline("it is a folder");
  if (!S_ISREG(status.st_mode)) decline("it is no regular file");
  return static_cast<std::uintmax_t>(status.st_size);
}

/// Returns the bytes that were there: 0 at the end.
std::size_t read(int file, char* to, std::size_t count) {
  ssize_t got = 0;
  do got = ::read(file, to, count);
  while (got < 0 && errno == EINTR);
  if (got < 0) fail(errno);
  return static_cast<std::size_t>(got);
}

std::string size_in_words(std::uintmax_t bytes) {
  const bool whole = bytes >= (1u << 20) && bytes % (1u << 20) == 0;
  return whole ? fmt::format("{} MiB", bytes >> 20) : fmt::format("{} bytes", bytes);
}

}  // namespace

std::string read_bounded_file(const std::filesystem::path& path, std::uintmax_t most) {
  if (has_nul(path)) decline("its name holds a NUL byte");
  // A device is not opened at all: the opening of some has an effect.
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (std::filesystem::is_other(status)) decline("it is no regular file");
  // O_NONBLOCK: the opening of a pipe without a writer, or of a terminal, returns at once.
  const hw::Descriptor file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  if (file < 0) fail(errno);
  const std::uintmax_t size = size_of(file);
  if (size > most) decline("it is larger than " + size_in_words(most));
  std::string content(size, '\0');
  std::size_t length = 0;
  for (std::size_t got = 1; got > 0 && length < content.size(); length += got)
    got = read(file, content.data() + length, content.size() - length);
  char beyond = 0;
  if (length < content.size() || read(file, &beyond, 1) > 0) decline("it changed while it was read");
  return content;
}

}  // namespace tactel::host
