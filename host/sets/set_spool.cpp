// SPDX-License-Identifier: Apache-2.0
#include "host/sets/set_spool.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <fstream>
#include <set>
#include <thread>

#include "host/sets/stage_seconds.h"
#include "host/support/bounded_file.h"
#include "host/support/bounded_queue.h"
#include "host/support/checksum.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;

/// Chunks that wait in memory for their predecessors before a thread waits with its own.
constexpr std::size_t most_waiting = 1;

/// Columns of the parameters that chunks hold.
std::size_t parameters_of(const SetColumns& columns) {
  return columns.has("parameters") ? columns.parameters.size() : 0;
}

/// The rows of a chunk, dataset by dataset, then the parameters of its contacts: where they are.
std::vector<std::string_view> payload_of(const ContactSet& rows, const SetColumns& columns) {
  std::vector<std::string_view> parts;
  const auto add = [&](const auto& values) {
    parts.emplace_back(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0]));
  };
  each_dataset(rows, [&](const char* name, const auto& values, int, const char*) {
    if (columns.has(name)) add(values);
  });
  if (parameters_of(columns) > 0) add(rows.contact_parameters);
  return parts;
}

ContactSet rows_from(const std::string& bytes, const ChunkHeader& header, const SetColumns& columns) {
  ContactSet set(columns);
  std::size_t at = 0;
  const auto take = [&](auto& values, std::size_t count) {
    values.resize(count);
    const std::size_t size = values.size() * sizeof(values[0]);
    if (size > 0) std::memcpy(values.data(), bytes.data() + at, size);
    at += size;
  };
  each_dataset(set, [&](const char*, auto& values, int width, const char*) {
    take(values, header.rows * static_cast<std::size_t>(std::max(width, 1)));
  });
  take(set.contact_parameters, header.contacts * parameters_of(columns));
  return set;
}

ConfigError output_error(const fs::path& output, const std::string& allowed) {
  return ConfigError("command line", "--output", output.string(), allowed);
}

FileLock locked(const fs::path& folder, const fs::path& output) {
  const std::string allowed = "of a set that no other program is writing; another one writes " + output.string();
  try {
    return FileLock::of_file("--output", folder / "lock", allowed);
  } catch (const ConfigError&) {
    if (fs::exists(folder)) throw;  // else the other one has just ended its set
    throw output_error(output, allowed);
  }
}

/// Errors of the file system while a folder is listed, measured or removed, as errors of --output.
template <class Work>
auto with_output(const fs::path& output, const Work& work) try {
  return work();
} catch (const fs::filesystem_error& error) {
  throw output_error(output, "beside a folder that can be read and written: " + error.path1().string() + " (" +
                                 error.code().message() + ")");
}

/// Chunks first, then the plan, then the lock: a kill on the way leaves a folder that the next run understands. Without
/// the lock another program may begin a set in the folder: nothing of its own is removed.
void remove_spool(const fs::path& folder) {
  for (const fs::path& file : PlacedSet::header_files(folder)) fs::remove(file);
  fs::remove(PlacedSet::set_file(folder));
  fs::remove(folder / "plan");
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().filename() != "lock") fs::remove_all(entry.path());
  fs::remove(folder / "lock");
  std::error_code error;
  fs::remove(folder, error);
  if (error && error != std::errc::directory_not_empty && error != std::errc::no_such_file_or_directory)
    throw fs::filesystem_error("removal", folder, error);
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

SetSpool::SetSpool(const fs::path& output, const std::string& plan, const SetColumns& columns, std::uint64_t count,
                   Open how, Ring ring, std::uint64_t existing)
    : output_(output),
      folder_(folder(output)),
      plan_sum_(checksum(plan)),
      count_(count),
      columns_(columns),
      ring_(std::move(ring)),
      holds_end_(how != Open::join) {
  make_folder("--output", folder_);
  with_output(output_, [&] {
    if (how != Open::join) lock_ = locked(folder_, output_);
    check_plan(plan, how);
    const std::vector<ChunkHeader> found = how == Open::join ? std::vector<ChunkHeader>() : headers();
    try {
      placed_.emplace(folder_, columns_, ring_.rank);
      if (how != Open::join) placed_->resume(found);
      torn_ = torn_ || (how != Open::join && chunks() < found.size());
    } catch (const std::system_error& error) {
      throw output_error(output_, "a file that can be written (" + error.code().message() + ")");
    }
  });
  first_ = how == Open::join ? existing : chunks();
  next_ = first_;
  while (next_ < count_ && owner(next_) != ring_.rank) ++next_;
}

SetSpool::~SetSpool() {
  if (placed_ && holds_end_) placed_->flush();  // after an error; else there is nothing left
}

void SetSpool::check_plan(const std::string& plan, Open how) const {
  const fs::path path = folder_ / "plan";
  const bool found = fs::exists(path);
  if (how == Open::fresh && found)
    throw output_error(output_, "a new set: an interrupted run left chunks in " + folder_.string() +
                                    "; --resume continues it, --force starts anew");
  const auto same = [&] {
    try {
      return read_bounded_file(path, plan.size()) == plan;
    } catch (const UnreadableFile&) {  // longer than the plan, or no file
      return false;
    }
  };
  if (found && !same())
    throw output_error(output_,
                       "the set that was begun: " + folder_.string() +
                           " holds chunks of another sweep file, seed, precision, tolerance or version, or of a file "
                           "named in it that has changed; --force starts anew");
  if (!found && std::ranges::any_of(PlacedSet::header_files(folder_),
                                    [](const fs::path& file) { return fs::file_size(file) > 0; }))
    throw output_error(output_, "a set whose plan is known: " + folder_.string() +
                                    " holds chunks, but its file `plan` is lost; put it back, or --force starts anew");
  if (!found) write_file("--output", path, plan);
}

/// Refuses a chunk of another plan: it was copied in.
void SetSpool::check(const ChunkHeader& header) const {
  const bool fits =
      header.plan_sum == plan_sum_ && header.chunk < count_ &&
      header.inputs == static_cast<std::uint64_t>(columns_.inputs) && header.rows <= header.bytes &&
      header.contacts <= header.bytes &&
      header.bytes == header.rows * row_bytes(columns_) + header.contacts * parameters_of(columns_) * sizeof(float);
  if (!fits)
    throw output_error(output_, "made of chunks of one plan: " + folder_.string() +
                                    " holds some of another sweep file, seed, precision or version; remove them, or "
                                    "--force starts anew");
}

/// Returns the headers of the folder, sorted, each chunk once.
std::vector<ChunkHeader> SetSpool::headers() {
  std::map<std::uint64_t, ChunkHeader> all;
  for (const fs::path& file : PlacedSet::header_files(folder_)) {
    std::ifstream in(file, std::ios::binary);
    ChunkHeader header;
    while (in.read(reinterpret_cast<char*>(&header), sizeof header) && header.whole())
      check(header), all.emplace(header.chunk, header);
    torn_ = torn_ || in.gcount() > 0;
  }
  std::vector<ChunkHeader> sorted;
  sorted.reserve(all.size());
  for (const auto& [chunk, header] : all) sorted.push_back(header);
  return sorted;
}

int SetSpool::owner(std::uint64_t chunk) const {
  return chunk < count_ ? static_cast<int>(chunk % static_cast<std::uint64_t>(ring_.count)) : 0;
}

std::vector<std::uint64_t> SetSpool::missing() const {
  std::vector<std::uint64_t> all;
  for (std::uint64_t chunk = next_; chunk < count_; chunk += static_cast<std::uint64_t>(ring_.count))
    all.push_back(chunk);
  return all;
}

std::uint64_t SetSpool::rows() const {
  std::uint64_t all = 0;
  for (const ChunkHeader& header : placed_->chunks()) all += header.rows;
  return all;
}

void SetSpool::fail(int error) const {
  throw output_error(output_, fmt::format("on a disk with room for it ({}); chunks are kept in {}, and --resume "
                                          "continues from them",
                                          std::strerror(error), folder_.string()));
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
                     .counts = rows,
                     .payload_sum = sum.value()};
  header.header_sum = header.sum();
  return header;
}

void SetSpool::append(std::uint64_t chunk, ContactSet rows) {
  const ChunkHeader header = header_of(chunk, rows, payload_of(rows, columns_));
  std::unique_lock lock(mutex_);
  waiting_.emplace(chunk, Waiting{header, std::move(rows)});
  changed_.notify_all();
  changed_.wait(lock, [&] { return waiting_.size() <= most_waiting || stopped_; });
}

void SetSpool::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  changed_.notify_all();
}

/// A message is 1 where the run ends; else 0 and the end of the set.
void SetSpool::receive() {
  const std::optional<std::string> message = ring_.receive();
  if (!message) return;
  if (message->front() == 1) {
    stop();
    ended_ = true;
    return;
  }
  placed_->take_tail(std::string_view(*message).substr(1), [&](const ChunkHeader& header) { check(header); });
  holds_end_ = true;
}

/// A process knows the chunks up to its last one in this run.
void SetSpool::send_end() {
  const auto processes = static_cast<std::uint64_t>(ring_.count);
  ring_.send(owner(chunks()), '\0' + placed_->tail(chunks() < first_ + processes ? 0 : chunks() - processes));
  holds_end_ = false;
}

/// Tells every process that waits for the end of the set.
void SetSpool::send_stop() {
  std::set<int> waiting;
  for (std::uint64_t chunk = chunks() + 1;
       chunk <= count_ && chunk < chunks() + static_cast<std::uint64_t>(ring_.count); ++chunk)
    waiting.insert(owner(chunk));
  waiting.erase(ring_.rank);
  for (const int process : waiting) ring_.send(process, "\1");
  ended_ = true;
}

bool SetSpool::next_has_come() {
  const std::lock_guard lock(mutex_);
  return waiting_.contains(next_);
}

/// Returns the next chunk of this process, where it has come and this process holds the end of the set.
std::optional<SetSpool::Waiting> SetSpool::wait_for_next(std::chrono::milliseconds wait) {
  if (holds_end_) {
    if (!next_has_come() && !placed_->flush()) fail(errno);     // the rows behind the last ones may come late
  } else if (next_has_come() || next_ >= count_ || stopped_) {  // only the end is missing: a message of another process
    std::this_thread::sleep_for(std::chrono::microseconds(100));
    return {};
  }
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, wait, [&] { return waiting_.contains(next_) || stopped_; });
  if (!holds_end_ || !waiting_.contains(next_)) return {};
  return std::move(waiting_.extract(next_).mapped());
}

bool SetSpool::place(std::chrono::milliseconds wait) {
  if (!holds_end_ && ring_.count > 1) receive();
  if (ended_) return false;
  if (holds_end_ && owner(chunks()) != ring_.rank) send_end();
  if (next_ >= count_ && (ring_.rank != 0 || holds_end_)) return false;
  const std::optional<Waiting> chunk = wait_for_next(wait);
  if (!chunk) {
    if (stopped_ && holds_end_) send_stop();
    return !ended_;
  }
  const auto start = std::chrono::steady_clock::now();
  const std::vector<std::string_view> payload = payload_of(chunk->rows, columns_);
  std::optional<PlacedSet::Unwritten> unwritten = placed_->place(chunk->header, payload);
  if (!unwritten) fail(errno);
  next_ += static_cast<std::uint64_t>(ring_.count);
  if (owner(chunks()) != ring_.rank) send_end();
  if (!placed_->write(std::move(*unwritten), payload) || !sync_sometimes()) fail(errno);
  bytes_ += chunk->header.bytes;
  seconds_ += seconds_since(start);
  const std::lock_guard lock(mutex_);
  changed_.notify_all();
  return true;
}

void SetSpool::flush() {
  if ((holds_end_ && !placed_->flush()) || !placed_->sync()) fail(errno);
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

void SetSpool::assemble(ContactSet& set, bool compress) {
  if (chunks() != count_)
    throw output_error(output_,
                       fmt::format("complete: {} of {} chunks exist; --resume generates the others", chunks(), count_));
  std::uint64_t contacts = 0;
  for (const ChunkHeader& header : placed_->chunks()) {
    contacts += header.contacts;
    set += header.counts;
  }
  if (compress || !placed_->fits_hdf5()) {  // a copy
    flush();
    ContactSetWriter writer(output_, columns_, rows(), contacts, compress);
    copy_rows(writer);
    writer.finish(set);
  } else {
    if (!placed_->finish(set)) fail(errno != 0 ? errno : EIO);  // HDF5 may not say why
    move_file("--output", PlacedSet::set_file(folder_), output_);
  }
  with_output(output_, [&] { remove_spool(folder_); });
}

}  // namespace tactel::host
