#include "host/set_spool.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "host/atomic_file.h"
#include "host/checksum.h"
#include "host/errors.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;

/// What stands before each chunk's rows. Byte order is the machine's; the folder does not travel.
struct Header {
  std::uint64_t magic = 0, chunk = 0, rows = 0, inputs = 0, bytes = 0, fell_back = 0, unsolved = 0, too_deep = 0;
  std::uint64_t payload_sum = 0;  ///< checksum of the rows that follow
  std::uint64_t header_sum = 0;   ///< checksum of all above
};
constexpr std::uint64_t magic = 0x326c6f6f70736c74;  // "tlspool2"

std::uint64_t sum_of(const Header& header) {
  return checksum({reinterpret_cast<const char*>(&header), offsetof(Header, header_sum)});
}

/// The rows of a chunk, dataset by dataset.
std::string payload_of(const ContactSet& rows) {
  std::string bytes;
  each_dataset(rows, [&](const char*, const auto& values, int, const char*) {
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0]));
  });
  return bytes;
}

ContactSet rows_from(const std::string& bytes, std::size_t rows, int inputs) {
  ContactSet set;
  set.inputs = inputs;
  std::size_t at = 0;
  each_dataset(set, [&](const char*, auto& values, int columns, const char*) {
    values.resize(rows * std::max(columns, 1));
    const std::size_t size = values.size() * sizeof(values[0]);
    if (size > 0) std::memcpy(values.data(), bytes.data() + at, size);
    at += size;
  });
  return set;
}

bool write_whole(int file, const char* from, std::size_t bytes) {
  while (bytes > 0) {
    const ssize_t done = ::write(file, from, bytes);
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) return false;
    from += done, bytes -= static_cast<std::size_t>(done);
  }
  return true;
}

std::string text_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

ConfigError output_error(const fs::path& output, const std::string& allowed) {
  return ConfigError("command line", "--output", output.string(), allowed);
}

int locked(const fs::path& folder, const fs::path& output) {
  const int file = ::open((folder / "lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
  if (file < 0)
    throw output_error(output, "in a folder that can be written to (" + std::string(std::strerror(errno)) + ")");
  if (::flock(file, LOCK_EX | LOCK_NB) == 0) return file;
  ::close(file);
  throw output_error(output, "a set that no other program is writing: one is at work in " + folder.string());
}

}  // namespace

fs::path SetSpool::folder(const fs::path& output) { return output.string() + ".parts"; }

void SetSpool::discard(const fs::path& output) {
  if (!fs::exists(folder(output))) return;
  const int lock = locked(folder(output), output);
  fs::remove_all(folder(output));
  ::close(lock);
}

SetSpool::SetSpool(const fs::path& output, const std::string& plan, int writer, Open how)
    : output_(output), folder_(folder(output)) {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) throw output_error(output, "in a folder that can be written to (" + error.message() + ")");
  if (how != Open::join) lock_ = locked(folder_, output_);
  try {
    check_plan(plan, how);
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_))
      if (entry.path().extension() == ".spool") scan(entry.path(), how != Open::join);
    open_own_file(writer);
  } catch (...) {
    if (lock_ >= 0) ::close(lock_);
    throw;
  }
}

SetSpool::~SetSpool() {
  if (file_ >= 0) ::close(file_);
  if (lock_ >= 0) ::close(lock_);
}

void SetSpool::check_plan(const std::string& plan, Open how) const {
  const fs::path path = folder_ / "plan";
  const bool there = fs::exists(path);
  if (how == Open::fresh && there)
    throw output_error(output_, "a new set: an interrupted run left chunks in " + folder_.string() +
                                    "; --resume goes on with it, --force starts anew");
  if (there && text_of(path) != plan)
    throw output_error(output_,
                       "the set that was begun: " + folder_.string() +
                           " holds chunks of another sweep file, seed, precision, tolerance or version; --force "
                           "starts anew");
  if (!there) write_file("--output", path, plan);
}

/// Finds the chunks of a file; `cut`: cuts it off behind the last whole one.
void SetSpool::scan(const fs::path& file, bool cut) {
  std::ifstream in(file, std::ios::binary);
  std::uint64_t offset = 0;
  Header header;
  std::string payload;
  while (in.read(reinterpret_cast<char*>(&header), sizeof header)) {
    if (header.magic != magic || header.header_sum != sum_of(header)) break;
    payload.resize(header.bytes);
    if (!in.read(payload.data(), static_cast<std::streamsize>(payload.size()))) break;
    if (checksum(payload) != header.payload_sum) break;
    chunks_[header.chunk] = {file,           offset, header.bytes, header.rows, header.fell_back, header.unsolved,
                             header.too_deep};
    offset += sizeof header + header.bytes;
  }
  if (offset == fs::file_size(file) || !cut) return;
  ++torn_;
  fs::resize_file(file, offset);
}

void SetSpool::open_own_file(int writer) {
  own_ = folder_ / fmt::format("{:04}.spool", writer);
  file_ = ::open(own_.c_str(), O_CREAT | O_WRONLY | O_APPEND | O_CLOEXEC, 0666);
  if (file_ < 0) throw output_error(output_, "a file that can be written (" + std::string(std::strerror(errno)) + ")");
}

std::set<std::uint64_t> SetSpool::chunks() const {
  std::set<std::uint64_t> there;
  for (const auto& [chunk, place] : chunks_) there.insert(chunk);
  return there;
}

std::uint64_t SetSpool::rows() const {
  std::uint64_t all = 0;
  for (const auto& [chunk, place] : chunks_) all += place.rows;
  return all;
}

std::size_t SetSpool::torn() const { return torn_; }
std::uint64_t SetSpool::bytes() const { return bytes_; }

void SetSpool::append(std::uint64_t chunk, const ContactSet& rows) {
  const std::string payload = payload_of(rows);
  Header header{.magic = magic,
                .chunk = chunk,
                .rows = rows.rows(),
                .inputs = static_cast<std::uint64_t>(rows.inputs),
                .bytes = payload.size(),
                .fell_back = rows.fell_back,
                .unsolved = rows.unsolved,
                .too_deep = rows.too_deep,
                .payload_sum = checksum(payload)};
  header.header_sum = sum_of(header);
  const off_t before = ::lseek(file_, 0, SEEK_END);
  if (!write_whole(file_, reinterpret_cast<const char*>(&header), sizeof header) ||
      !write_whole(file_, payload.data(), payload.size())) {
    const std::string why = std::strerror(errno);
    if (::ftruncate(file_, before) != 0) ++torn_;  // the next run cuts it off
    throw output_error(output_,
                       fmt::format("on a disk with room for it ({}); {} chunks are kept in {}, and --resume goes "
                                   "on with them",
                                   why, chunks_.size(), folder_.string()));
  }
  bytes_ += sizeof header + payload.size();
  chunks_[chunk] = {
      own_,           static_cast<std::uint64_t>(before), header.bytes, header.rows, header.fell_back, header.unsolved,
      header.too_deep};
}

ContactSet SetSpool::load(const Place& place, int inputs) const {
  std::ifstream in(place.file, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(place.offset));
  Header header;
  std::string payload(place.bytes, '\0');
  in.read(reinterpret_cast<char*>(&header), sizeof header);
  in.read(payload.data(), static_cast<std::streamsize>(payload.size()));
  if (!in || header.header_sum != sum_of(header) || checksum(payload) != header.payload_sum)
    throw output_error(output_, "made of whole chunks: " + place.file.string() +
                                    " was damaged while it was read; --resume simulates what is damaged again");
  return rows_from(payload, header.rows, inputs);
}

void SetSpool::assemble(std::uint64_t count, ContactSet& set) {
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_))  // what other writers added
    if (entry.path().extension() == ".spool" && entry.path() != own_) scan(entry.path(), false);
  if (chunks_.size() < count)
    throw output_error(
        output_, fmt::format("complete: {} of {} chunks are there; --resume makes the others", chunks_.size(), count));
  ContactSetWriter writer(output_, set.inputs, rows());
  for (const auto& [chunk, place] : chunks_) {
    writer.append(load(place, set.inputs));
    set.fell_back += place.fell_back;
    set.unsolved += place.unsolved;
    set.too_deep += place.too_deep;
  }
  writer.finish(set);
  fs::remove_all(folder_);
}

}  // namespace tactel::host
