#include "host/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>

#include "host/errors.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& option, const fs::path& path, const std::string& why) {
  throw ConfigError("command line", option, path.string(), "a file that can be written (" + why + ")");
}

/// A file descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  bool open() const { return fd_ >= 0; }
  bool write(std::string_view content) {
    while (!content.empty()) {
      const ssize_t count = ::write(fd_, content.data(), content.size());
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) return false;
      content.remove_prefix(static_cast<std::size_t>(count));
    }
    return true;
  }
  /// Closes now, because only close tells of some full disks.
  bool close() { return ::close(std::exchange(fd_, -1)) == 0; }

 private:
  int fd_;
};

/// The file behind symbolic links, so that renaming replaces it and not the link.
fs::path behind_links(const fs::path& path) {
  std::error_code error;
  const fs::path real = fs::weakly_canonical(path, error);
  return error ? path : real;
}

fs::path folder_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

bool is_special(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return fs::exists(status) && !fs::is_regular_file(status);
}

fs::path temporary_beside(const fs::path& path) {
  static std::atomic<int> count{0};
  return folder_of(path) / fmt::format(".{}.{}.{}.tmp", path.filename().string(), ::getpid(), count++);
}

}  // namespace

void check_writable(const std::string& option, const fs::path& path) {
  const fs::path target = behind_links(path);
  if (fs::is_directory(target) || !path.has_filename()) refuse(option, path, "it names a folder");
  const fs::path asked = is_special(target) ? target : folder_of(target);
  if (::access(asked.c_str(), W_OK) != 0) refuse(option, path, std::strerror(errno));
  if (!is_special(target) && !fs::is_directory(asked)) refuse(option, path, std::strerror(ENOTDIR));
}

void write_file(const std::string& option, const fs::path& path, std::string_view content) {
  check_writable(option, path);
  const fs::path target = behind_links(path);
  const bool straight = is_special(target);
  const fs::path written = straight ? target : temporary_beside(target);
  Descriptor file(::open(written.c_str(), straight ? O_WRONLY : O_WRONLY | O_CREAT | O_EXCL, 0666));
  bool good = file.open() && file.write(content) && file.close();
  if (!straight) good = good && ::rename(written.c_str(), target.c_str()) == 0;
  if (good) return;
  const std::string why = std::strerror(errno);
  if (!straight) ::unlink(written.c_str());
  refuse(option, path, why);
}

}  // namespace tactel::host
