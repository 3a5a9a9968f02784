// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "hw/recording.h"

namespace tactel::hw {
namespace {

constexpr std::size_t block_size = 8192;  // bytes

/// A device or pipe: it holds no file that could be lost.
bool is_stream(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return false;
  return S_ISCHR(status.st_mode) || S_ISFIFO(status.st_mode);
}

/// Makes a new file's name durable; a folder that cannot be synchronised is left alone.
void sync_folder(const std::filesystem::path& path) {
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  const Descriptor descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  ::fsync(descriptor);
}

}  // namespace

OutputFile::OutputFile(const std::filesystem::path& path, Existing existing) : path_(path) {
  const bool stream = is_stream(path);
  if (!stream && existing == Existing::replace) remove_file();
  const int fresh = O_CREAT | O_EXCL | O_NOFOLLOW;
  descriptor_ = Descriptor(::open(path.c_str(), O_WRONLY | O_CLOEXEC | (stream ? 0 : fresh), 0666));
  if (descriptor_ < 0) fail(errno == EEXIST ? "exists and is not overwritten" : "cannot be written", errno);
  block_.reserve(block_size);
}

/// Removes a regular file. A link is kept: its target may be valuable, and /dev/stdout is a link.
void OutputFile::remove_file() const {
  struct stat status {};
  if (::lstat(path_.c_str(), &status) != 0) {
    if (errno == ENOENT) return;
    fail("cannot be replaced", errno);
  }
  if (S_ISLNK(status.st_mode))
    throw RecordingError(path_.string() + ": is a symbolic link and is not overwritten; name its target");
  if (!S_ISREG(status.st_mode)) throw RecordingError(path_.string() + ": is no regular file and is not overwritten");
  if (::unlink(path_.c_str()) != 0) fail("cannot be replaced", errno);
}

void OutputFile::write(Bytes bytes) { write({reinterpret_cast<const char*>(bytes.data()), bytes.size()}); }

void OutputFile::write(std::string_view text) {
  if (block_.size() + text.size() > block_size) flush();
  block_ += text;
  size_ += text.size();
}

void OutputFile::flush() {
  std::size_t written = 0;
  while (written < block_.size()) {
    const ssize_t count = ::write(descriptor_, block_.data() + written, block_.size() - written);
    if (count > 0) written += static_cast<std::size_t>(count);
    if (count >= 0 || errno == EINTR) continue;
    const int error = errno;
    block_.erase(0, written);  // nothing is written twice
    fail("cannot be written", error);
  }
  block_.clear();
}

// Only close tells of some full disks. A pipe or device cannot be synchronised: EINVAL.
void OutputFile::close() {
  flush();
  if (::fsync(descriptor_) != 0 && errno != EINVAL && errno != ENOTSUP) fail("cannot be written", errno);
  if (!descriptor_.close()) fail("cannot be written", errno);
  sync_folder(path_);
}

void OutputFile::fail(const std::string& what, int error) const {
  throw RecordingError(path_.string() + ": " + what + ": " + std::strerror(error));
}

}  // namespace tactel::hw
