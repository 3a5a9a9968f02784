// SPDX-License-Identifier: Apache-2.0
#include "host/support/bounded_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace tactel::host {
namespace {

[[noreturn]] void fail(int error) { throw UnreadableFile(std::strerror(error), error == ENOENT || error == ENOTDIR); }
[[noreturn]] void decline(const std::string& why) { throw UnreadableFile(why, false); }

/// A descriptor of a file that is open for reading.
class Descriptor {
 public:
  // O_NONBLOCK: the opening of a pipe without a writer, or of a terminal, returns at once.
  explicit Descriptor(const std::filesystem::path& path)
      : file_(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)) {
    if (file_ < 0) fail(errno);
  }
  ~Descriptor() { ::close(file_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  /// Of a regular file, bytes.
  std::uintmax_t size() const {
    struct stat status {};
    if (::fstat(file_, &status) != 0) fail(errno);
    if (S_ISDIR(status.st_mode)) decline("it is a folder");
    if (!S_ISREG(status.st_mode)) decline("it is no regular file");
    return static_cast<std::uintmax_t>(status.st_size);
  }

  /// Returns the bytes that were there: 0 at the end.
  std::size_t read(char* to, std::size_t count) const {
    ssize_t got = 0;
    do got = ::read(file_, to, count);
    while (got < 0 && errno == EINTR);
    if (got < 0) fail(errno);
    return static_cast<std::size_t>(got);
  }

 private:
  int file_;
};

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
  const Descriptor file(path);
  const std::uintmax_t size = file.size();
  if (size > most) decline("it is larger than " + size_in_words(most));
  std::string content(size, '\0');
  std::size_t length = 0;
  for (std::size_t got = 1; got > 0 && length < content.size(); length += got)
    got = file.read(content.data() + length, content.size() - length);
  char beyond = 0;
  if (length < content.size() || file.read(&beyond, 1) > 0) decline("it changed while it was read");
  return content;
}

}  // namespace tactel::host
