// SPDX-License-Identifier: Apache-2.0
#include "host/support/durable_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <climits>
#include <cstring>
#include <ctime>
#include <fstream>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "host/support/bounded_file.h"
#include "host/support/checksum.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view suffix = ".tactel-part";

/// What the user can do about an error of the file system; empty where that is plain.
std::string advice(int error) {
  if (error == ENOSPC || error == EDQUOT) return "; make room there or choose another disk";
  if (error == EFBIG) return "; allow larger files (ulimit -f)";
  if (error == EACCES || error == EPERM || error == EROFS) return "; choose a folder that you may write to";
  return error == ENOENT ? "; make the folder first" : "";
}

[[noreturn]] void refuse(const std::string& option, const fs::path& path, const std::string& why) {
  throw ConfigError("command line", option, path.string(), "a file that can be written (" + why + ")");
}

[[noreturn]] void refuse(const std::string& option, const fs::path& path, int error) {
  refuse(option, path, std::strerror(error) + advice(error));
}

/// The file behind symbolic links, so that renaming replaces it and not the link.
fs::path behind_links(const std::string& option, const fs::path& path) {
  if (has_nul(path)) refuse(option, path, "its name holds a NUL byte");
  std::error_code error;
  const fs::path absolute = fs::absolute(path, error);
  const fs::path real = error ? path : fs::weakly_canonical(absolute, error);
  return error ? path : real;
}

fs::path folder_of(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

bool is_special(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return fs::exists(status) && !fs::is_regular_file(status);
}

/// ".NAME.KERNEL.PID.COUNT.tactel-part"; NAME cut off where a file name would become too long.
fs::path temporary_beside(const fs::path& path) {
  static std::atomic<unsigned> count{0};
  return folder_of(path) / fmt::format(".{}.{}.{}.{}{}", path.filename().string().substr(0, 190), running_kernel(),
                                       ::getpid(), count++, suffix);
}

bool take_number(std::string_view& name) {
  const auto dot = name.rfind('.');
  if (dot == std::string_view::npos || dot + 1 == name.size()) return false;
  if (name.find_first_not_of("0123456789", dot + 1) != std::string_view::npos) return false;
  name.remove_suffix(name.size() - dot);
  return true;
}

/// The kernel under which a temporary of this name was made; none of another name.
std::optional<std::string> kernel_of(std::string_view name) {
  if (!name.starts_with('.') || !name.ends_with(suffix)) return {};
  name.remove_suffix(suffix.size());
  if (!take_number(name) || !take_number(name) || name.size() < 2) return {};
  const auto dot = name.rfind('.');
  return std::string(name.substr(dot + 1));
}

/// Whether the name still leads to the open file.
bool is_same_file(int file, const fs::path& path) {
  struct stat open, named;
  return ::fstat(file, &open) == 0 && ::lstat(path.c_str(), &named) == 0 && open.st_ino == named.st_ino &&
         open.st_dev == named.st_dev;
}

/// flock until it is not interrupted. 0 or errno.
int lock_error(int file, int how) {
  while (::flock(file, how) != 0)
    if (errno != EINTR) return errno;
  return 0;
}

/// Removes a temporary whose process has gone; its lock went with it.
void remove_if_left(const fs::path& path, const std::string& kernel) {
  const hw::Descriptor file(::open(path.c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK));
  struct stat status;
  if (file >= 0 && ::fstat(file, &status) == 0 && S_ISREG(status.st_mode) && status.st_uid == ::geteuid() &&
      is_abandoned(file, kernel))
    ::unlink(path.c_str());
}

void remove_leftovers_once(const fs::path& folder) {
  static std::mutex mutex;
  static std::set<fs::path> seen;
  {
    const std::lock_guard lock(mutex);
    if (!seen.insert(folder).second) return;
  }
  remove_leftovers(folder);
}

/// Opens a temporary of a new name beside `target`, locked. -1 with errno on failure.
hw::Descriptor open_temporary(const fs::path& target, fs::path& temporary) {
  for (int attempt = 0; attempt < 1000; ++attempt) {
    temporary = temporary_beside(target);
    hw::Descriptor file(::open(temporary.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666));
    if (file < 0 && errno == EEXIST) continue;  // left by a process that had this number
    if (file < 0) return file;
    lock_error(file, LOCK_EX);  // a file system without locks does without the removal of leftovers
    if (is_same_file(file, temporary)) return file;  // else another process took it for a leftover, before its lock
  }
  errno = EEXIST;
  return hw::Descriptor();
}

bool sync_file(int file) { return ::fsync(file) == 0 || errno == EINVAL || errno == ENOTSUP; }

}  // namespace

bool write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(file, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

bool sync_folder(const fs::path& folder) {
  const hw::Descriptor file(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return file < 0 ? errno == EACCES : sync_file(file);  // a folder may be written to and not read
}

void remove_leftovers(const fs::path& folder) {
  std::error_code error;
  std::vector<std::pair<fs::path, std::string>> left;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (const auto kernel = kernel_of(entry->path().filename().native())) left.emplace_back(entry->path(), *kernel);
  for (const auto& [path, kernel] : left) remove_if_left(path, kernel);
}

const std::string& running_kernel() {
  static const std::string name = [] {
    std::string id;
    std::ifstream("/proc/sys/kernel/random/boot_id") >> id;
    if (id.empty()) id.resize(HOST_NAME_MAX + 1), ::gethostname(id.data(), id.size() - 1);
    return checksum_text(id);
  }();
  return name;
}

bool is_abandoned(int file, std::string_view kernel, std::chrono::seconds least) {
  constexpr std::chrono::seconds day = std::chrono::hours(24);
  struct stat status;
  if (::fstat(file, &status) != 0) return false;
  const std::chrono::seconds unchanged(std::time(nullptr) - status.st_mtime);
  return unchanged >= (kernel == running_kernel() ? least : std::max(least, day)) &&
         lock_error(file, LOCK_EX | LOCK_NB) == 0;
}

DurableFile::DurableFile(std::string option, fs::path path)
    : option_(std::move(option)), path_(std::move(path)), target_(behind_links(option_, path_)) {
  if (is_special(target_)) refuse(option_, path_, "it names no file");
  remove_leftovers_once(folder_of(target_));
  file_ = open_temporary(target_, temporary_);
  if (file_ < 0) {
    temporary_.clear();
    fail(errno);
  }
}

DurableFile::~DurableFile() { drop(); }

void DurableFile::drop() {
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
  temporary_.clear();
  file_.close();
}

void DurableFile::fail(int error) {
  drop();
  refuse(option_, path_, error);
}

void DurableFile::write(std::string_view content) {
  if (!write_all(file_, content)) fail(errno);
}

void DurableFile::commit() {
  if (!sync_file(file_) || ::rename(temporary_.c_str(), target_.c_str()) != 0) fail(errno);
  temporary_.clear();
  if (!sync_folder(folder_of(target_))) fail(errno);
  if (!file_.close() && errno != EINTR) fail(errno);
}

void check_writable(const std::string& option, const fs::path& path) {
  const fs::path target = behind_links(option, path);
  std::error_code error;
  if (fs::is_directory(target, error) || !path.has_filename()) refuse(option, path, "it names a folder");
  if (error == std::errc::filename_too_long) refuse(option, path, ENAMETOOLONG);
  const fs::path asked = is_special(target) ? target : folder_of(target);
  if (::access(asked.c_str(), W_OK) != 0) refuse(option, path, errno);
  if (!is_special(target) && !fs::is_directory(asked, error)) refuse(option, path, ENOTDIR);
}

void write_file(const std::string& option, const fs::path& path, std::string_view content) {
  check_writable(option, path);
  if (const fs::path target = behind_links(option, path); is_special(target)) {
    const hw::Descriptor file(::open(target.c_str(), O_WRONLY | O_CLOEXEC));
    if (file < 0 || !write_all(file, content)) refuse(option, path, errno);
    return;
  }
  DurableFile file(option, path);
  file.write(content);
  file.commit();
}

void make_folder(const std::string& option, const fs::path& path) {
  std::error_code error;
  std::vector<fs::path> changed;  // folders that get a new name in them
  for (fs::path at = fs::absolute(path, error); !error && !at.empty() && !fs::exists(at, error); at = at.parent_path())
    changed.push_back(at.parent_path());
  fs::create_directories(path, error);
  if (!error && !fs::is_directory(path)) error = std::make_error_code(std::errc::not_a_directory);
  if (error)
    throw ConfigError("command line", option, path.string(),
                      "in a folder that can be written to (" + error.message() + advice(error.value()) + ")");
  for (const fs::path& folder : changed)
    if (!sync_folder(folder)) refuse(option, path, errno);
}

namespace {

/// Throws where another process holds the lock. A file system without locks counts as free. A process that was killed
/// holds its locks until the system has its memory back: it is waited for.
void take(int file, const std::string& option, const fs::path& path, const std::string& allowed) {
  constexpr auto turn = std::chrono::milliseconds(20);
  for (int turns = 0; turns < 50; ++turns, std::this_thread::sleep_for(turn))
    if (lock_error(file, LOCK_EX | LOCK_NB) != EWOULDBLOCK) return;
  throw ConfigError("command line", option, path.string(), allowed);
}

}  // namespace

FileLock FileLock::of_folder(const std::string& option, const fs::path& path, const std::string& allowed) {
  FileLock lock;
  lock.file_ = hw::Descriptor(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!lock.held()) refuse(option, path, errno);
  take(lock.file_, option, path, allowed);
  return lock;
}

FileLock FileLock::of_file(const std::string& option, const fs::path& path, const std::string& allowed) {
  for (;;) {
    FileLock lock;
    lock.file_ = hw::Descriptor(::open(path.c_str(), O_CREAT | O_RDWR | O_NOFOLLOW | O_CLOEXEC, 0666));
    if (!lock.held()) refuse(option, path, errno);
    take(lock.file_, option, path, allowed);
    if (is_same_file(lock.file_, path)) return lock;  // else its last owner removed it between the two calls
  }
}

}  // namespace tactel::host
