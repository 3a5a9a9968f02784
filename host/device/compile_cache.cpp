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
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <thread>
#include <utility>
#include <vector>

#include "fem/cache_directory.h"
#include "host/support/address_space.h"
#include "host/support/bounded_file.h"
#include "host/support/checksum.h"
#include "host/support/durable_file.h"
#include "host/support/exit_code.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr const char* list_name = "sealed";
constexpr const char* lock_name = "compiling";
constexpr const char* presence_name = "processes";
constexpr const char* programs_name = "programs";                 // a folder that PoCL does not know
constexpr auto patience = 2s;                                     // far more than a check takes
constexpr std::uintmax_t largest_file = std::uintmax_t{1} << 30;  // a compiled kernel takes some MB

/// A file as the list knows it.
struct Sealed {
  std::uint64_t size = 0, changed = 0, sum = 0;  ///< bytes; ns since 1970, 0: no longer listed; checksum of the content
};
using List = std::map<std::string, Sealed>;  ///< by path within the folder

class Descriptor {
 public:
  Descriptor(const fs::path& path, int flags) : fd_(::open(path.c_str(), flags | O_CLOEXEC, 0600)) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

bool sync(const fs::path& path) {
  const Descriptor file(path, O_RDONLY);
  return file.get() >= 0 && ::fsync(file.get()) == 0;
}

/// Empty where it cannot be read.
std::string content_of(const fs::path& path) try {
  return read_bounded_file(path, largest_file);
} catch (const UnreadableFile&) {
  return "";
}

std::uint64_t content_sum(const fs::path& path) { return checksum(content_of(path)); }

std::optional<Sealed> stat_of(const fs::path& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return {};
  return Sealed{static_cast<std::uint64_t>(status.st_size),
                static_cast<std::uint64_t>(status.st_mtim.tv_sec) * 1'000'000'000u +
                    static_cast<std::uint64_t>(status.st_mtim.tv_nsec),
                0};
}

std::string line_of(const std::string& path, const Sealed& file) {
  const std::string text = fmt::format("{} {} {:016x} {}", file.size, file.changed, file.sum, path);
  return fmt::format("{:016x} {}\n", checksum(text), text);
}

/// Lines that are torn or damaged are passed over: their files count as not listed.
List read_list(const fs::path& folder) {
  List list;
  std::istringstream in(content_of(folder / list_name));
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::uint64_t sum = 0;
    Sealed file;
    std::string path;
    words >> std::hex >> sum >> std::dec >> file.size >> file.changed >> std::hex >> file.sum;
    words.get();
    if (!words || !std::getline(words, path) || line_of(path, file) != line + "\n") continue;
    if (file.changed == 0)
      list.erase(path);
    else
      list[path] = file;
  }
  return list;
}

/// Adds lines to the list and brings it to the disk.
bool append(const fs::path& folder, std::string lines) {
  const Descriptor out(folder / list_name, O_WRONLY | O_CREAT | O_APPEND);
  if (out.get() < 0) return false;
  lines.insert(0, "\n");  // after a line that a power cut has torn
  return ::write(out.get(), lines.data(), lines.size()) >= 0 && ::fsync(out.get()) == 0;
}

/// The files of each program: PoCL keeps them in XX/REST, two letters and the rest of a hash. Left out are the stamp
/// that PoCL touches at each use, and whatever lies elsewhere.
std::map<fs::path, std::vector<fs::path>> programs_in(const fs::path& folder) {
  std::map<fs::path, std::vector<fs::path>> programs;
  std::error_code error;
  for (const fs::directory_entry& first : fs::directory_iterator(folder, error)) {
    if (first.path().filename().native().size() != 2 || !first.is_directory(error)) continue;
    for (const fs::directory_entry& program : fs::directory_iterator(first.path(), error)) {
      std::vector<fs::path>& files = programs[program.path()];
      for (fs::recursive_directory_iterator entry(program.path(), error), end; entry != end; entry.increment(error))
        if (!entry->is_directory(error) && entry->path().filename() != "last_accessed") files.push_back(entry->path());
    }
  }
  return programs;
}

enum class Verdict { good, unlisted, damaged };

Verdict judge(const fs::path& path, const std::string& name, const List& list) {
  const auto listed = list.find(name);
  if (listed == list.end()) return Verdict::unlisted;
  const auto now = stat_of(path);
  const bool same = now && now->size == listed->second.size &&
                    (now->changed == listed->second.changed || content_sum(path) == listed->second.sum);
  return same ? Verdict::good : Verdict::damaged;
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

CompileCache::CompileCache(fs::path folder, bool enter)
    : folder_(std::move(folder)),
      presence_(enter ? ::open((folder_ / presence_name).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600) : -1),
      compiling_(::open((folder_ / lock_name).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)) {
  if (presence_ < 0) return;
  if (::flock(presence_, LOCK_EX | LOCK_NB) == 0) check();
  // Another process may be at its check, which is short, unless that process is stopped.
  const auto end = std::chrono::steady_clock::now() + patience;
  while (::flock(presence_, LOCK_SH | LOCK_NB) != 0 && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(10ms);
}

CompileCache::~CompileCache() {
  for (const int each : {presence_, compiling_})
    if (each >= 0) ::close(each);
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
  return fmt::format("tactel program {} {} {}\n", checksum_text(key), binary.size(), checksum_text(binary));
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

void CompileCache::check() {
  const List list = read_list(folder_);
  std::error_code error;
  std::string no_longer;
  for (const auto& [program, files] : programs_in(folder_)) {
    Verdict worst = Verdict::good;
    for (const fs::path& file : files)
      worst = std::max(worst, judge(file, file.lexically_relative(folder_).string(), list));
    if (worst == Verdict::good) continue;
    damaged_ += worst == Verdict::damaged;
    fs::remove_all(program, error);
    for (const fs::path& file : files)
      if (const std::string name = file.lexically_relative(folder_).string(); list.contains(name))
        no_longer += line_of(name, {});
  }
  if (!no_longer.empty()) append(folder_, no_longer);
}

void CompileCache::seal() const noexcept try {
  const List list = read_list(folder_);
  std::string lines;
  std::set<fs::path> folders;
  for (const auto& [program, files] : programs_in(folder_))
    for (const fs::path& file : files) {
      const std::string name = file.lexically_relative(folder_).string();
      auto now = stat_of(file);
      if (!now || list.contains(name) || !sync(file)) continue;
      for (fs::path parent = file.parent_path(); parent != folder_; parent = parent.parent_path())
        folders.insert(parent);
      now->sum = content_sum(file);
      lines += line_of(name, *now);
    }
  if (lines.empty()) return;
  folders.insert(folder_);
  for (const fs::path& folder : folders) sync(folder);
  append(folder_, lines);
} catch (...) {  // the next run compiles again
}

}  // namespace tactel::host
