// SPDX-License-Identifier: Apache-2.0
#include "host/sets/set_spool.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <fstream>
#include <future>
#include <thread>

#include "host/support/bounded_file.h"
#include "host/support/bounded_queue.h"
#include "host/support/checksum.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t version_bits = 0xff00000000000000;
/// Chunks that wait in memory for their predecessors, at most.
constexpr std::size_t most_waiting = 1;

/// Columns of the parameters that chunks hold.
std::size_t parameters_of(const SetColumns& columns) {
  return columns.has("parameters") ? columns.parameters.size() : 0;
}

/// The rows of a chunk, dataset by dataset, then the parameters of its contacts: where they are.
std::vector<std::string_view> payload_of(const ContactSet& rows, const SetColumns& of) {
  std::vector<std::string_view> parts;
  const auto add = [&](const auto& values) {
    parts.emplace_back(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0]));
  };
  each_dataset(rows, [&](const char* name, const auto& values, int, const char*) {
    if (of.has(name)) add(values);
  });
  if (parameters_of(of) > 0) add(rows.contact_parameters);
  return parts;
}

ContactSet rows_from(const std::string& bytes, const ChunkHeader& header, const SetColumns& of) {
  ContactSet set(of);
  std::size_t at = 0;
  const auto take = [&](auto& values, std::size_t count) {
    values.resize(count);
    const std::size_t size = values.size() * sizeof(values[0]);
    if (size > 0) std::memcpy(values.data(), bytes.data() + at, size);
    at += size;
  };
  each_dataset(set, [&](const char*, auto& values, int columns, const char*) {
    take(values, header.rows * static_cast<std::size_t>(std::max(columns, 1)));
  });
  take(set.contact_parameters, header.contacts * parameters_of(of));
  return set;
}

ConfigError output_error(const fs::path& output, const std::string& allowed) {
  return ConfigError("command line", "--output", output.string(), allowed);
}

FileLock locked(const fs::path& folder, const fs::path& output) {
  return FileLock::of_file("--output", folder / "lock",
                           "of a set that no other program is writing; another one writes " + output.string());
}

/// Errors of the file system while a folder is listed, measured or removed, as errors of --output.
template <class Work>
auto with_output(const fs::path& output, const Work& work) try {
  return work();
} catch (const fs::filesystem_error& error) {
  throw output_error(output, "beside a folder that can be read and written: " + error.path1().string() + " (" +
                                 error.code().message() + ")");
}

/// Chunks first, then the plan, then the lock: a kill on the way leaves a folder that the next run understands.
void remove_spool(const fs::path& folder) {
  std::vector<fs::path> chunks;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".spool") chunks.push_back(entry.path());
  for (const fs::path& file : PlacedSet::files(folder)) chunks.push_back(file);
  for (const fs::path& file : chunks) fs::remove(file);
  fs::remove(folder / "plan");
  fs::remove_all(folder);
}

/// What was left of `output` by versions that named their temporary SET.h5.PID.part, if that process is gone.
void remove_old_leftovers(const fs::path& output) {
  const fs::path folder = output.has_parent_path() ? output.parent_path() : ".";
  const std::string begin = output.filename().string() + ".", end = ".part";
  std::vector<fs::path> left;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), last; !error && entry != last; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.size() <= begin.size() + end.size() || !name.starts_with(begin) || !name.ends_with(end)) continue;
    const std::string pid = name.substr(begin.size(), name.size() - begin.size() - end.size());
    if (pid.size() > 9 || pid.find_first_not_of("0123456789") != std::string::npos) continue;
    if (::kill(std::stoi(pid), 0) != 0 && errno == ESRCH) left.push_back(entry->path());
  }
  for (const fs::path& path : left) fs::remove(path, error);
}

}  // namespace

fs::path SetSpool::folder(const fs::path& output) { return output.string() + ".parts"; }

void SetSpool::discard(const fs::path& output) {
  with_output(output, [&] {
    if (!fs::exists(folder(output))) return;
    const FileLock lock = locked(folder(output), output);
    remove_spool(folder(output));
  });
}

SetSpool::SetSpool(const fs::path& output, const std::string& plan, const SetColumns& columns, int writer, Open how)
    : output_(output), folder_(folder(output)), plan_sum_(checksum(plan)), columns_(columns) {
  make_folder("--output", folder_);
  with_output(output_, [&] {
    if (how != Open::join) {
      lock_ = locked(folder_, output_);
      remove_old_leftovers(output_);
    }
    check_plan(plan, how);
    const auto belongs = [&](const ChunkHeader& header) { check(header, PlacedSet::files(folder_)[0]); };
    check_version(PlacedSet::files(folder_)[0]);
    if (how != Open::join) {
      try {
        placed_.emplace(folder_, columns_, belongs);
      } catch (const std::system_error& error) {
        throw output_error(output_, "a file that can be written (" + error.code().message() + ")");
      }
      torn_ += placed_->torn();
    }
    for (const ChunkHeader& header : placed_ ? placed_->chunks() : PlacedSet::read_headers(folder_))
      belongs(header), chunks_[header.chunk] = {{}, 0, header};
    for (const fs::path& file : files()) scan(file, how != Open::join);
    open_own_file(writer);
  });
}

SetSpool::~SetSpool() {
  if (file_ >= 0) ::close(file_);
}

/// Files with chunks, in the order of their names. A symbolic link is none of ours.
std::vector<fs::path> SetSpool::files() const {
  std::vector<fs::path> all;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_))
    if (entry.path().extension() == ".spool" && fs::is_regular_file(entry.symlink_status()))
      all.push_back(entry.path());
  std::ranges::sort(all);
  return all;
}

void SetSpool::check_plan(const std::string& plan, Open how) const {
  const fs::path path = folder_ / "plan";
  const bool there = fs::exists(path);
  if (how == Open::fresh && there)
    throw output_error(output_, "a new set: an interrupted run left chunks in " + folder_.string() +
                                    "; --resume continues it, --force starts anew");
  const auto same = [&] {
    try {
      return read_bounded_file(path, plan.size()) == plan;
    } catch (const UnreadableFile&) {  // longer than the plan, or no file
      return false;
    }
  };
  if (there && !same())
    throw output_error(output_,
                       "the set that was begun: " + folder_.string() +
                           " holds chunks of another sweep file, seed, precision, tolerance or version, or of a file "
                           "named in it that has changed; --force starts anew");
  const bool chunks = std::ranges::any_of(files(), [](const fs::path& file) { return fs::file_size(file) > 0; }) ||
                      !PlacedSet::read_headers(folder_).empty();
  if (!there && chunks)
    throw output_error(output_, "a set whose plan is known: " + folder_.string() +
                                    " holds chunks, but its file `plan` is lost; put it back, or --force starts anew");
  if (!there) write_file("--output", path, plan);
}

/// Refuses a chunk of another plan: it was copied in.
void SetSpool::check(const ChunkHeader& header, const fs::path& file) const {
  const bool fits =
      header.plan_sum == plan_sum_ && header.inputs == static_cast<std::uint64_t>(columns_.inputs) &&
      header.rows <= header.bytes && header.contacts <= header.bytes &&
      header.bytes == header.rows * row_bytes(columns_) + header.contacts * parameters_of(columns_) * sizeof(float);
  if (!fits)
    throw output_error(output_, "made of chunks of one plan: " + file.string() +
                                    " holds some of another sweep file, seed, precision or version; remove it, or "
                                    "--force starts anew");
}

/// Refuses a file whose first chunk another version wrote, in a layout that this one does not read.
void SetSpool::check_version(const fs::path& file) const {
  std::uint64_t first = 0;
  std::ifstream in(file, std::ios::binary);
  if (!in.read(reinterpret_cast<char*>(&first), sizeof first)) return;
  constexpr std::uint64_t own = ChunkHeader::right_magic;
  if (first == own || ((first ^ own) & ~version_bits) != 0) return;
  throw output_error(output_, "made of chunks of this version of tactel: " + file.string() +
                                  " holds some of another; that version goes on with it, and --force starts anew");
}

/// Finds the chunks of a file; `cut`: cuts it off behind the last whole one.
void SetSpool::scan(const fs::path& file, bool cut) {
  check_version(file);
  std::ifstream in(file, std::ios::binary);
  const std::uint64_t size = fs::file_size(file);
  std::uint64_t offset = 0;
  ChunkHeader header;
  std::string payload;
  while (in.read(reinterpret_cast<char*>(&header), sizeof header)) {
    if (!header.whole()) break;
    check(header, file);
    if (header.bytes > size - offset - sizeof header) break;
    payload.resize(header.bytes);
    if (!in.read(payload.data(), static_cast<std::streamsize>(payload.size()))) break;
    if (checksum(payload) != header.payload_sum) break;
    chunks_.try_emplace(header.chunk, Place{file, offset, header});
    offset += sizeof header + header.bytes;
  }
  if (offset == size || !cut) return;
  ++torn_;
  fs::resize_file(file, offset);
}

void SetSpool::open_own_file(int writer) {
  own_ = folder_ / fmt::format("{:04}.spool", writer);
  file_ = ::open(own_.c_str(), O_CREAT | O_WRONLY | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (file_ < 0 || !sync_folder(folder_))
    throw output_error(output_, "a file that can be written (" + std::string(std::strerror(errno)) + ")");
}

std::set<std::uint64_t> SetSpool::chunks() const {
  std::set<std::uint64_t> there;
  for (const auto& [chunk, place] : chunks_) there.insert(chunk);
  return there;
}

std::uint64_t SetSpool::rows() const {
  std::uint64_t all = 0;
  for (const auto& [chunk, place] : chunks_) all += place.header.rows;
  return all;
}

std::size_t SetSpool::torn() const { return torn_; }
std::uint64_t SetSpool::bytes() const { return bytes_; }

void SetSpool::fail(int error) const {
  throw output_error(output_, fmt::format("on a disk with room for it ({}); {} chunks are kept in {}, and --resume "
                                          "continues from them",
                                          std::strerror(error), chunks_.size(), folder_.string()));
}

ChunkHeader SetSpool::header_of(std::uint64_t chunk, const ContactSet& rows,
                                const std::vector<std::string_view>& payload) const {
  std::uint64_t bytes = 0;
  RunningChecksum sum;
  for (const std::string_view part : payload) bytes += part.size(), sum.add(part);
  ChunkHeader header{.magic = ChunkHeader::right_magic,
                     .plan_sum = plan_sum_,
                     .chunk = chunk,
                     .rows = rows.rows(),
                     .contacts = parameters_of(columns_) > 0 ? rows.contacts : 0,
                     .inputs = static_cast<std::uint64_t>(rows.inputs),
                     .bytes = bytes,
                     .fell_back = rows.fell_back,
                     .unsolved = rows.unsolved,
                     .too_deep = rows.too_deep,
                     .without_rows = rows.without_rows,
                     .far_slip = rows.far_slip,
                     .never_slid = rows.never_slid,
                     .payload_sum = sum.value()};
  header.header_sum = header.sum();
  return header;
}

void SetSpool::append(std::uint64_t chunk, ContactSet rows) {
  const ChunkHeader header = header_of(chunk, rows, payload_of(rows, columns_));
  if (!placed_) return spool(header, rows);
  std::unique_lock lock(appending_);
  waiting_.emplace(chunk, Waiting{header, std::move(rows)});
  if (!placing_) place_waiting(lock);
  placed_some_.wait(lock, [&] { return waiting_.size() <= most_waiting || !placing_; });
  if (waiting_.size() <= most_waiting) return;
  const auto last = waiting_.extract(std::prev(waiting_.end()));
  lock.unlock();
  spool(last.mapped().header, last.mapped().rows);
}

/// Places chunks as long as the next one is there. One thread at a time does so; others leave theirs to it.
void SetSpool::place_waiting(std::unique_lock<std::mutex>& lock) {
  placing_ = true;
  try {
    for (;;) {
      const std::uint64_t next = placed_->chunks().size();
      const auto waits = waiting_.extract(next);
      const auto spooled = chunks_.find(next);
      if (waits.empty() && spooled == chunks_.end()) break;
      const Place place_of = waits.empty() ? spooled->second : Place{};
      lock.unlock();
      const Waiting chunk = waits.empty() ? Waiting{place_of.header, load(place_of)} : std::move(waits.mapped());
      const bool good = placed_->append(chunk.header, payload_of(chunk.rows, columns_)) && sync_sometimes();
      const int error = errno;
      lock.lock();
      if (!good) fail(error);
      chunks_[next] = {{}, 0, placed_->chunks().back()};
      bytes_ += waits.empty() ? 0 : chunks_[next].header.bytes;
      placed_some_.notify_all();
    }
  } catch (...) {
    if (!lock.owns_lock()) lock.lock();
    placing_ = false;
    placed_some_.notify_all();
    throw;
  }
  placing_ = false;
  placed_some_.notify_all();
}

/// The disk is told of every chunk, and waited for once a second.
bool SetSpool::sync_sometimes() {
  if (std::chrono::steady_clock::now() - synced_ < std::chrono::seconds(1)) {
    placed_->begin_sync();
    return true;
  }
  const bool good = placed_->sync();
  synced_ = std::chrono::steady_clock::now();
  return good;
}

void SetSpool::flush() {
  for (const auto& [number, chunk] : waiting_) spool(chunk.header, chunk.rows);
  waiting_.clear();
  if (placed_ && !placed_->sync()) fail(errno);
}

/// Appends a chunk to the spool file of this process.
void SetSpool::spool(const ChunkHeader& header, const ContactSet& rows) {
  const std::vector<std::string_view> payload = payload_of(rows, columns_);
  const auto fail_after = [&](off_t before) {
    const int error = errno;
    if (before < 0 || ::ftruncate(file_, before) != 0) ++torn_;  // the next run cuts it off
    fail(error);
  };
  off_t before = 0;
  {
    const std::lock_guard lock(appending_);
    before = ::lseek(file_, 0, SEEK_END);
    bool whole = write_all(file_, {reinterpret_cast<const char*>(&header), sizeof header});
    for (const std::string_view part : payload) whole = whole && write_all(file_, part);
    if (!whole) fail_after(before);
  }
  const bool synced = ::fdatasync(file_) == 0 || errno == EINVAL;  // EINVAL: a file system that cannot
  const std::lock_guard lock(appending_);
  if (!synced) fail_after(-1);  // another thread may have appended behind it
  bytes_ += sizeof header + header.bytes;
  chunks_[header.chunk] = {own_, static_cast<std::uint64_t>(before), header};
}

ContactSet SetSpool::load(const Place& place) const {
  std::ifstream in(place.file, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(place.offset));
  ChunkHeader header;
  std::string payload(place.header.bytes, '\0');
  in.read(reinterpret_cast<char*>(&header), sizeof header);
  in.read(payload.data(), static_cast<std::streamsize>(payload.size()));
  if (!in || std::memcmp(&header, &place.header, sizeof header) != 0 || checksum(payload) != header.payload_sum)
    throw output_error(output_, "made of whole chunks: " + place.file.string() +
                                    " was damaged while it was read; --resume generates the damaged chunks again");
  return rows_from(payload, header, columns_);
}

/// One thread reads chunks and checks them, the calling one writes.
void SetSpool::copy_rows(ContactSetWriter& writer) const {
  BoundedQueue<ContactSet> loaded(1);
  bool whole = true;
  std::exception_ptr error;
  {
    const std::jthread reader([&] {
      try {
        whole = placed_->each([&](const ChunkHeader& header, const std::string& payload) {
          loaded.push(rows_from(payload, header, columns_));
        });
      } catch (...) {
        error = std::current_exception();
      }
      loaded.close();
    });
    try {
      while (const auto rows = loaded.pop()) writer.append(*rows);
    } catch (...) {
      loaded.close(true);  // the reader waits no longer
      throw;
    }
  }
  if (error) std::rethrow_exception(error);
  if (!whole)
    throw output_error(output_, "made of whole chunks: one of " + folder_.string() +
                                    " was damaged while it was read; --resume generates it again");
}

/// The set as a copy of its rows: compressed, or too small for chunks of HDF5's.
void SetSpool::finish_copy(const ContactSet& set, std::uint64_t contacts, bool compress) const {
  ContactSetWriter writer(output_, columns_, rows(), contacts, compress);
  copy_rows(writer);
  writer.finish(set);
}

/// One thread reads a chunk and checks it, while the calling one places the chunk before.
void SetSpool::place_spooled(std::uint64_t count) {
  const auto loading = [&](std::uint64_t chunk) {
    return std::async(std::launch::async, [this, chunk] { return load(chunks_.at(chunk)); });
  };
  std::uint64_t chunk = placed_->chunks().size();
  if (chunk == count) return;
  for (std::future<ContactSet> next = loading(chunk); chunk < count; ++chunk) {
    const ContactSet rows = next.get();
    if (chunk + 1 < count) next = loading(chunk + 1);
    if (!placed_->append(chunks_.at(chunk).header, payload_of(rows, columns_))) fail(errno);
    placed_->begin_sync();
  }
}

void SetSpool::assemble(std::uint64_t count, ContactSet& set, bool compress) {
  with_output(output_, [&] {
    for (const fs::path& file : files())  // what other writers added
      if (file != own_) scan(file, false);
  });
  flush();
  if (chunks_.size() != count || (count > 0 && chunks_.rbegin()->first != count - 1))
    throw output_error(
        output_, fmt::format("complete: {} of {} chunks exist; --resume generates the others", chunks_.size(), count));
  std::uint64_t contacts = 0;
  for (const auto& [chunk, place_of] : chunks_) {
    const ChunkHeader& header = place_of.header;
    contacts += header.contacts;
    set.fell_back += header.fell_back;
    set.unsolved += header.unsolved;
    set.too_deep += header.too_deep;
    set.without_rows += header.without_rows;
    set.far_slip += header.far_slip;
    set.never_slid += header.never_slid;
  }
  place_spooled(count);
  if (compress || !placed_->fits_hdf5()) {
    finish_copy(set, contacts, compress);
  } else {
    if (!placed_->finish(set)) fail(errno != 0 ? errno : EIO);  // HDF5 may not say why
    move_file("--output", PlacedSet::files(folder_)[1], output_);
  }
  with_output(output_, [&] { remove_spool(folder_); });
}

}  // namespace tactel::host
