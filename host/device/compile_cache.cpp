// SPDX-License-Identifier: Apache-2.0
#include "host/device/compile_cache.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <utility>
#include <vector>

#include "fem/numbers/cache_directory.h"
#include "host/support/bounded_file.h"
#include "host/support/checksum.h"
#include "host/support/durable_file.h"
#include "host/support/exit_code.h"
#include "host/support/host_limits.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr const char* lock_name = "compiling";
constexpr const char* programs_name = "programs";
constexpr std::string_view own_prefix = "process.";
constexpr auto until_locked = 10s;  // far more than a process takes from the making of its folder to the lock of it
constexpr std::uintmax_t largest_file = std::uintmax_t{1} << 30;  // a compiled kernel takes some MB

std::error_code last_error() { return {errno, std::generic_category()}; }

/// Empty where it cannot be read.
std::string content_of(const fs::path& path) try {
  return read_bounded_file(path, largest_file);
} catch (const UnreadableFile&) {
  return "";
}

bool full(const struct statvfs& disk, std::size_t room) {
  return disk.f_bavail * disk.f_frsize < room || (disk.f_files > 0 && disk.f_favail < 100);
}

/// Why a folder cannot hold a cache; empty where it can.
std::string unfit(const fs::path& folder, std::size_t room) {
  if (::access(folder.c_str(), W_OK | X_OK) != 0) return std::strerror(errno);
  struct statvfs disk {};
  if (::statvfs(folder.c_str(), &disk) != 0) return std::strerror(errno);
  return full(disk, room) ? "the disk is full" : "";
}

bool lacks_room(const fs::path& folder) {
  struct statvfs disk {};
  return ::statvfs(folder.c_str(), &disk) == 0 && full(disk, cache_room);
}

std::string full_disk_text(const fs::path& folder) {
  return "compiled kernels found no room in " + folder.string() +
         ": the disk is full; make room there, or set TACTEL_CACHE_DIR to another folder";
}

/// Makes a folder that is closed to others. Returns why it cannot hold machine code; empty where it can.
std::string unfit_to_load(const fs::path& folder) {
  ::mkdir(folder.c_str(), S_IRWXU);
  struct stat status {};
  if (::lstat(folder.c_str(), &status) != 0) return std::strerror(errno);
  return fem::distrust(folder);
}

}  // namespace

CachePlace choose_cache(const fs::path& own, std::span<const fs::path> shared_parents, std::size_t room) {
  CachePlace place;
  const auto fits = [&](const fs::path& folder, std::string why) {
    if (why.empty()) why = unfit(folder, room);
    if (why.empty())
      place.folder = folder;
    else
      place.trouble += (place.trouble.empty() ? "" : ", ") + folder.string() + " (" + why + ")";
    return why.empty();
  };
  std::error_code error;
  fs::create_directories(own.parent_path(), error);
  std::string why = error ? error.message() : fem::distrust(own.parent_path());
  if (own.empty())
    place.trouble = "the user's cache (HOME is not set)";
  else if (fits(own, why.empty() ? unfit_to_load(own) : why))
    return place;
  for (const fs::path& parent : shared_parents) {
    const fs::path folder = parent / ("tactel-" + std::to_string(::getuid()));
    if (fits(folder, unfit_to_load(folder))) return place;
  }
  return place;
}

std::atomic<const AbortNotice*> AbortNotice::current{nullptr};

AbortNotice::AbortNotice(const fs::path& folder) : folder_(folder), text_("error: " + full_disk_text(folder) + "\n") {
  std::signal(SIGABRT, explain);
  // LLVM ends the process by exit(1) where its output stream fails.
  static const int at_exit = std::atexit([] { explain(0); });
  (void)at_exit;
  current = this;
}

AbortNotice::~AbortNotice() { current = nullptr; }

// Only calls that are safe in a handler. Where it returns, the abort goes on.
void AbortNotice::explain(int) {
  const AbortNotice* const notice = current.load();
  if (!notice || !lacks_room(notice->folder_)) return;
  (void)!::write(STDERR_FILENO, notice->text_.data(), notice->text_.size());
  ::_exit(device_failed);
}

namespace {

/// Removes what processes left that are gone.
void remove_abandoned(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> others;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (entry->path().filename().native().starts_with(own_prefix)) others.push_back(entry->path());
  for (const fs::path& other : others) {
    const std::string kernel = other.filename().string().substr(own_prefix.size(), running_kernel().size());
    const hw::Descriptor open(::open(other.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (is_abandoned(open, kernel, until_locked)) fs::remove_all(other, error);
  }
}

}  // namespace

CompileCache::CompileCache(const fs::path& folder)
    : folder_(fs::absolute(folder)),
      compiling_(::open((folder_ / lock_name).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)),
      process_(::getpid()) {
  remove_abandoned(folder_);
  std::string own = folder_ / fmt::format("{}{}.{}.XXXXXX", own_prefix, running_kernel(), process_);
  if (::mkdtemp(own.data()) == nullptr) throw fs::filesystem_error("mkdtemp", own, last_error());
  own_ = own;
  presence_ = hw::Descriptor(::open(own.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  ::flock(presence_, LOCK_EX | LOCK_NB);
}

CompileCache::CompileCache(fs::path folder, fs::path own)
    : folder_(std::move(folder)), own_(std::move(own)), process_(::getpid()) {
  std::error_code error;
  fs::remove_all(own_, error);  // of an earlier one that was killed
  if (::mkdir(own_.c_str(), S_IRWXU) != 0) throw fs::filesystem_error("mkdir", own_, last_error());
}

CompileCache::~CompileCache() { leave(); }

void CompileCache::leave() const noexcept {
  std::error_code error;
  if (process_ == ::getpid()) fs::remove_all(own_, error);  // a fork does not own it
}

namespace {

/// The lock of a byte of the file: the process that has it can be asked for.
struct flock byte_lock(short type, long place) {
  struct flock lock {};
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  lock.l_start = place;
  lock.l_len = 1;
  return lock;
}

}  // namespace

CompileCache::Turn::Turn(const CompileCache& cache, std::string_view key)
    : lock_(cache.compiling_), place_(static_cast<long>(checksum(key) >> 2)) {}

int CompileCache::Turn::take() {
  struct flock lock = byte_lock(F_WRLCK, place_);
  if (lock_ < 0 || ::fcntl(lock_, F_SETLK, &lock) == 0) return 0;
  if (::fcntl(lock_, F_GETLK, &lock) != 0) return 0;
  return lock.l_type == F_UNLCK ? take() : std::max(lock.l_pid, 0);
}

CompileCache::Turn::~Turn() {
  struct flock lock = byte_lock(F_UNLCK, place_);
  if (lock_ >= 0) ::fcntl(lock_, F_SETLK, &lock);
}

namespace {

fs::path program_path(const fs::path& folder, std::string_view key) {
  return folder / programs_name / (checksum_text(key) + ".binary");
}

/// What the file of a program begins with.
std::string program_line(std::string_view key, std::string_view binary) {
  return fmt::format("tactel program 2 {} {} {}\n", checksum_text(key), binary.size(), checksum_text(binary));
}

}  // namespace

std::string CompileCache::program(std::string_view key) const {
  std::string file = content_of(program_path(folder_, key));
  const std::size_t begin = file.find('\n') + 1;
  const std::string_view line = std::string_view(file).substr(0, begin), binary = std::string_view(file).substr(begin);
  return line == program_line(key, binary) ? file.substr(begin) : "";
}

void CompileCache::keep_program(std::string_view key, std::string_view binary) const noexcept try {
  const fs::path path = program_path(folder_, key);
  fs::create_directories(path.parent_path());
  write_file("cache", path, program_line(key, binary) + std::string(binary));
} catch (...) {  // the next run builds it from its source
}

std::string CompileCache::advice() const {
  return lacks_room(folder_) ? full_disk_text(folder_) : address_space_advice();
}

}  // namespace tactel::host
