// SPDX-License-Identifier: Apache-2.0
#include "host/sets/set_spool.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "host/support/bounded_file.h"
#include "host/support/checksum.h"
#include "host/support/errors.h"
#include "host/support/seconds.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;

/// Columns of the parameters that chunks hold.
std::size_t parameters_of(const SetColumns& columns) {
  return columns.has("parameters") ? columns.parameter_names.size() : 0;
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
  if (parameters_of(columns) > 0) add(rows.parameters);
  return parts;
}

ConfigError output_error(const fs::path& output, const std::string& allowed) {
  return ConfigError("command line", "--output", output.string(), allowed);
}

FileLock locked(const fs::path& file, const fs::path& output) {
  const std::string allowed = "of a set that no other program is writing; another one writes " + output.string();
  try {
    return FileLock::of_file("--output", file, allowed);
  } catch (const ConfigError&) {
    if (fs::exists(file.parent_path())) throw;  // else the other one has just ended its set
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

/// The files with chunks, in the order of their names.
std::vector<fs::path> chunk_files(const fs::path& folder) {
  std::vector<fs::path> all;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".chunks" && fs::is_regular_file(entry.symlink_status()))
      all.push_back(entry.path());
  std::ranges::sort(all);
  return all;
}

/// Chunks first, then the plan, then the lock: a kill on the way leaves a folder that the next run understands. Without
/// the lock another program may begin a set in the folder: nothing of its own is removed.
void remove_spool(const fs::path& folder) {
  for (const fs::path& file : chunk_files(folder)) fs::remove(file);
  fs::remove(folder / "plan");
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().filename() != "lock") fs::remove_all(entry.path());
  fs::remove(folder / "lock");
  std::error_code error;
  fs::remove(folder, error);
  if (error && error != std::errc::directory_not_empty && error != std::errc::no_such_file_or_directory)
    throw fs::filesystem_error("removal", folder, error);
}

/// Opens the file to which a process appends.
hw::Descriptor open_to_append(const fs::path& path) {
  hw::Descriptor file(::open(path.c_str(), O_CREAT | O_RDWR | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0666));
  struct stat status {};
  if (file < 0 || ::fstat(file, &status) != 0 || !sync_folder(path.parent_path()))
    throw fs::filesystem_error("opening", path, {errno, std::generic_category()});
  if (S_ISREG(status.st_mode)) return file;
  throw ConfigError(path.string(), "", "", "a regular file; remove it");
}

std::string_view bytes_of(const ChunkHeader& header) { return {reinterpret_cast<const char*>(&header), sizeof header}; }

}  // namespace

fs::path SetSpool::folder(const fs::path& output) { return output.string() + ".parts"; }

double SetSpool::bytes_left(const fs::path& output) {
  return with_output(output, [&] {
    double bytes = 0;
    if (fs::exists(folder(output)))
      for (const fs::path& file : chunk_files(folder(output))) bytes += static_cast<double>(fs::file_size(file));
    return bytes;
  });
}

void SetSpool::discard(const fs::path& output) {
  with_output(output, [&] {
    if (!fs::exists(folder(output))) return;
    const FileLock lock = locked(folder(output) / "lock", output);
    remove_spool(folder(output));
  });
}

SetSpool::SetSpool(const fs::path& output, const std::string& plan, const SetColumns& columns, std::uint64_t count,
                   Open how, int process)
    : output_(output), folder_(folder(output)), plan_sum_(checksum(plan)), count_(count), columns_(columns) {
  make_folder("--output", folder_);
  with_output(output_, [&] {
    if (how != Open::join) lock_ = locked(folder_ / "lock", output_);
    check_plan(plan, how);
    if (how != Open::join) {
      fs::remove(folder_ / "stop");
      find_chunks(true, true);
    }
    const fs::path file = folder_ / fmt::format("{:04}.chunks", process);
    file_lock_ = locked(file, output_);
    file_ = open_to_append(file);
    end_ = fs::file_size(file);
  });
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
  if (!found && std::ranges::any_of(chunk_files(folder_), [](const fs::path& file) { return fs::file_size(file) > 0; }))
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

/// Looks for chunks behind those that it has found before. `checked`: their rows are. `of_another_run`: no process of
/// it may still write, and what is torn at the end of a file is cut off, since new chunks come behind it.
void SetSpool::find_chunks(bool checked, bool of_another_run) {
  std::string rows;
  for (const fs::path& path : chunk_files(folder_)) {
    const FileLock lock = of_another_run ? locked(path, output_) : FileLock();
    const auto file = files_.try_emplace(path, 0).first;
    std::uint64_t& at = file->second;
    std::ifstream in(path, std::ios::binary | std::ios::ate);
    const std::uint64_t size = in ? static_cast<std::uint64_t>(in.tellg()) : 0;
    ChunkHeader header;
    while (in.seekg(static_cast<std::streamoff>(at)).read(reinterpret_cast<char*>(&header), sizeof header) &&
           header.whole()) {
      check(header);
      const std::uint64_t begin = at + sizeof header;
      if (header.bytes > size - begin) break;
      if (checked) rows.resize(header.bytes), in.read(rows.data(), static_cast<std::streamsize>(header.bytes));
      if (!checked || (in && checksum(rows) == header.payload_sum))
        chunks_.try_emplace(header.chunk, Chunk{header, &file->first, begin});
      else
        torn_ = true;
      at = begin + header.bytes;
    }
    if (of_another_run && at < size) torn_ = true, fs::resize_file(path, at);
  }
}

std::vector<double> SetSpool::found() const {
  std::vector<double> all(count_);
  for (const auto& [number, chunk] : chunks_) all[number] = 1;
  return all;
}

std::vector<std::uint64_t> missing_chunks(const std::vector<double>& found, int process, int processes) {
  std::vector<std::uint64_t> all;
  std::uint64_t missing = 0;
  for (std::uint64_t chunk = 0; chunk < found.size(); ++chunk)
    if (found[chunk] == 0 && static_cast<int>(missing++ % static_cast<std::uint64_t>(processes)) == process)
      all.push_back(chunk);
  return all;
}

std::uint64_t SetSpool::rows() const {
  std::uint64_t all = 0;
  for (const auto& [number, chunk] : chunks_) all += chunk.header.rows;
  return all;
}

void SetSpool::fail(int error) const {
  throw output_error(output_, fmt::format("on a disk with room for it ({}); chunks are kept in {}, and --resume "
                                          "continues from them",
                                          std::strerror(error), folder_.string()));
}

void SetSpool::append(std::uint64_t chunk, const ContactSet& rows) {
  const std::vector<std::string_view> payload = payload_of(rows, columns_);
  ChunkHeader header{.magic = ChunkHeader::right_magic,
                     .plan_sum = plan_sum_,
                     .chunk = chunk,
                     .rows = rows.rows(),
                     .contacts = parameters_of(columns_) > 0 ? rows.contacts : 0,
                     .inputs = static_cast<std::uint64_t>(rows.inputs),
                     .counts = rows};
  RunningChecksum sum;
  for (const std::string_view part : payload) header.bytes += part.size(), sum.add(part);
  header.payload_sum = sum.value();
  header.header_sum = header.sum();
  const std::lock_guard lock(mutex_);
  const auto start = std::chrono::steady_clock::now();
  bool good = write_all(file_, bytes_of(header));
  for (const std::string_view part : payload) good = good && write_all(file_, part);
  if (!good) {
    const int error = errno;
    [[maybe_unused]] const int cut = ::ftruncate(file_, static_cast<off_t>(end_));  // else the next run cuts it off
    fail(error);
  }
  end_ += sizeof header + header.bytes;
  bytes_ += header.bytes;
  seconds_ += seconds_since(start);
}

void SetSpool::flush(std::chrono::seconds apart) {
  const auto time = std::chrono::steady_clock::now();
  if (time - synced_ < apart) return;
  if (::fdatasync(file_) != 0 && errno != EINVAL) fail(errno);  // EINVAL: a file system that cannot
  synced_ = time;
}

// A file, since a process that computes does not wait for messages.
void SetSpool::stop() const { std::ofstream(folder_ / "stop"); }

bool SetSpool::stopped() const {
  std::error_code error;
  return fs::exists(folder_ / "stop", error);
}

/// The rows of all chunks in order, read from their files.
class SetSpool::Rows {
 public:
  explicit Rows(const SetSpool& spool) {
    const ContactSet nothing(spool.columns_);
    each_dataset(nothing, [&](const char*, const auto& values, int width, const char*) {
      begins_.push_back(begins_.back() + sizeof(values[0]) * static_cast<std::size_t>(std::max(width, 1)));
    });
    begins_.push_back(begins_.back() + parameters_of(spool.columns_) * sizeof(float));
    for (const auto& [number, chunk] : spool.chunks_) {
      chunks_.push_back(&chunk);
      rows_.push_back(rows_.back() + chunk.header.rows);
      contacts_.push_back(contacts_.back() + chunk.header.contacts);
      if (std::ifstream& file = files_[chunk.file]; !file.is_open()) file.open(*chunk.file, std::ios::binary);
    }
  }
  std::uint64_t rows() const { return rows_.back(); }
  std::uint64_t contacts() const { return contacts_.back(); }
  /// As SetRows::copy.
  bool copy(std::size_t dataset, std::uint64_t first, std::uint64_t count, char* to) {
    const std::vector<std::uint64_t>& before = dataset + 2 < begins_.size() ? rows_ : contacts_;
    const std::uint64_t size = begins_[dataset + 1] - begins_[dataset];
    auto k = static_cast<std::size_t>(std::ranges::upper_bound(before, first) - before.begin()) - 1;
    for (std::uint64_t take = 0; count > 0; count -= take, first += take, to += take * size, ++k) {
      const Chunk& chunk = *chunks_[k];
      take = std::min(count, before[k + 1] - first);
      const std::uint64_t at = chunk.at + chunk.header.rows * begins_[dataset] + (first - before[k]) * size;
      if (!files_[chunk.file]
               .seekg(static_cast<std::streamoff>(at))
               .read(to, static_cast<std::streamsize>(take * size)))
        return false;
    }
    return true;
  }

 private:
  std::vector<const Chunk*> chunks_;
  std::vector<std::uint64_t> rows_{0}, contacts_{0};  ///< before each chunk; the last: of all
  std::vector<std::uint64_t> begins_{0};              ///< of each dataset, of the parameters: bytes before, a row
  std::map<const fs::path*, std::ifstream> files_;
};

void SetSpool::assemble(ContactSet& set, bool compress) {
  with_output(output_, [&] { find_chunks(compress, false); });  // a slow copy has the time to check them, too
  if (chunks_.size() != count_)
    throw output_error(
        output_, fmt::format("complete: {} of {} chunks exist; --resume generates the others", chunks_.size(), count_));
  for (const auto& [number, chunk] : chunks_) set += chunk.header.counts;
  Rows rows(*this);
  const auto copy = [&](std::size_t dataset, std::uint64_t first, std::uint64_t count, char* to) {
    return rows.copy(dataset, first, count, to);
  };
  errno = 0;
  if (!write_set_file(output_, {columns_, rows.rows(), rows.contacts(), copy}, set, compress))
    fail(errno != 0 ? errno : EIO);  // HDF5 may not say why
  with_output(output_, [&] { remove_spool(folder_); });
}

}  // namespace tactel::host
