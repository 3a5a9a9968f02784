// SPDX-License-Identifier: Apache-2.0
#include "host/sets/placed_set.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "host/sets/set_headers.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t first_stripe = 4096;  ///< before it is HDF5's superblock

int open_file(const fs::path& path, int how) {
  const int file = ::open(path.c_str(), how | O_CREAT | O_RDWR | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (file < 0) throw std::system_error(errno, std::generic_category());
  if (struct stat status{}; ::fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(file);
    throw ConfigError(path.string(), "", "", "a regular file; remove it");
  }
  return file;
}

bool synced(int file) { return ::fdatasync(file) == 0 || errno == EINVAL; }  // EINVAL: a file system that cannot

PlacedRows placed_rows(const SetColumns& columns) {
  std::vector<PlacedRows::Dataset> datasets;
  const ContactSet nothing(columns);
  each_dataset(nothing, [&](const char* name, const auto& values, int width, const char*) {
    datasets.push_back({name, sizeof(values[0]) * static_cast<std::uint64_t>(std::max(width, 1))});
  });
  return {std::move(datasets), rows_of_chunk(columns.inputs)};
}

std::optional<PlacedRows> placed_parameters(const SetColumns& columns) {
  if (!columns.has("parameters") || columns.parameters.empty()) return {};
  std::vector<PlacedRows::Dataset> datasets;
  datasets.push_back({"parameters", sizeof(float) * columns.parameters.size()});
  return PlacedRows(std::move(datasets), rows_of_chunk(static_cast<int>(columns.parameters.size())));
}

/// The places of the tactels that a set has.
std::vector<std::pair<const char*, const std::vector<float>*>> tactel_places(const SetColumns& columns) {
  std::vector<std::pair<const char*, const std::vector<float>*>> all;
  for (const auto& [name, places] : {std::pair("tactel_x", &columns.tactel_x), {"tactel_y", &columns.tactel_y}})
    if (columns.has(name) && !places->empty()) all.emplace_back(name, places);
  return all;
}

std::optional<PlacedRows> placed_tactels(const SetColumns& columns) {
  const auto places = tactel_places(columns);
  if (places.empty()) return {};
  std::vector<PlacedRows::Dataset> datasets;
  datasets.reserve(places.size());
  for (const auto& [name, numbers] : places) datasets.push_back({name, sizeof(float)});
  return PlacedRows(std::move(datasets), std::min<std::uint64_t>(places[0].second->size(), rows_of_chunk(0)));
}

std::uint64_t tactel_count(const SetColumns& columns) {
  return std::max(columns.tactel_x.size(), columns.tactel_y.size());
}

/// Datasets and parameters apart.
struct Payload {
  Payload(std::vector<std::string_view> payload, bool has_parameters) : rows(std::move(payload)) {
    if (has_parameters) parameters = {rows.back()}, rows.pop_back();
  }
  PlacedRows::Values rows, parameters;
};

std::string_view bytes_of(const std::vector<ChunkHeader>& headers, std::size_t from = 0) {
  return {reinterpret_cast<const char*>(headers.data() + from), (headers.size() - from) * sizeof(ChunkHeader)};
}

}  // namespace

PlacedSet::Places::Places(const SetColumns& columns)
    : rows(placed_rows(columns)),
      parameters(placed_parameters(columns)),
      tactels(placed_tactels(columns)),
      end(first_stripe) {}

void PlacedSet::Places::skip(const ChunkHeader& header, const SetColumns& columns) {
  if (tactels && header.chunk == 0) tactels->skip(end, tactel_count(columns));
  rows.skip(end, header.rows);
  if (parameters) parameters->skip(end, header.contacts);
}

std::vector<fs::path> PlacedSet::header_files(const fs::path& folder) {
  std::vector<fs::path> all;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".placed" && fs::is_regular_file(entry.symlink_status()))
      all.push_back(entry.path());
  std::ranges::sort(all);
  return all;
}

PlacedSet::PlacedSet(const fs::path& folder, const SetColumns& columns, int writer)
    : columns_(columns),
      folder_(folder),
      file_(open_file(set_file(folder), 0)),
      direct_(set_file(folder)),
      places_(columns) {
  headers_ = open_file(folder / fmt::format("{:04}.placed", writer), O_APPEND);
  if (!sync_folder(folder)) throw std::system_error(errno, std::generic_category());
}

PlacedSet::~PlacedSet() {
  if (file_ >= 0) ::close(file_);
  if (headers_ >= 0) ::close(headers_);
}

void PlacedSet::resume(const std::vector<ChunkHeader>& headers) {
  std::string payload;
  for (const ChunkHeader& header : headers) {
    if (header.chunk != chunks_.size() || !read(places_, header, payload)) break;
    std::vector<std::string_view> values;
    std::string_view rest = payload;
    const auto take = [&](const PlacedRows& datasets, std::uint64_t rows) {
      for (const PlacedRows::Dataset& dataset : datasets.datasets()) {
        values.push_back(rest.substr(0, rows * dataset.row_bytes));
        rest.remove_prefix(rows * dataset.row_bytes);
      }
    };
    take(places_.rows, header.rows);
    if (places_.parameters) take(*places_.parameters, header.contacts);
    if (!place(header, values)) throw std::system_error(errno, std::generic_category());
  }
  const fs::path file_of_first = folder_ / "0000.placed";
  if (::ftruncate(file_, static_cast<off_t>(places_.end)) != 0) throw std::system_error(errno, std::generic_category());
  if (header_files(folder_).size() == 1 && fs::file_size(file_of_first) == bytes_of(chunks_).size()) return;
  write_file("--output", file_of_first, bytes_of(chunks_));
  for (const fs::path& file : header_files(folder_))
    if (file != file_of_first) fs::remove(file);
  ::close(std::exchange(headers_, open_file(file_of_first, O_APPEND)));
}

bool PlacedSet::read(const Places& places, const ChunkHeader& header, std::string& payload) const {
  const off_t size = ::lseek(file_, 0, SEEK_END);
  if (size < 0 || header.bytes > static_cast<std::uint64_t>(size)) return false;
  payload.clear();
  std::vector<std::string> values;
  std::uint64_t end = places.end;
  if (places.tactels && header.chunk == 0) places.tactels->pieces(end, tactel_count(columns_));
  const auto take = [&](const PlacedRows& datasets, std::uint64_t rows) {
    if (!datasets.read(file_, end, rows, values)) return false;
    for (const std::string& part : values) payload += part;
    return true;
  };
  return take(places.rows, header.rows) && (!places.parameters || take(*places.parameters, header.contacts)) &&
         checksum(payload) == header.payload_sum;
}

std::optional<PlacedSet::Unwritten> PlacedSet::place(const ChunkHeader& header,
                                                     const std::vector<std::string_view>& payload) {
  if (places_.tactels && header.chunk == 0) {
    PlacedRows::Values x;
    for (const auto& [name, numbers] : tactel_places(columns_))
      x.emplace_back(reinterpret_cast<const char*>(numbers->data()), numbers->size() * sizeof(float));
    for (PlacedRows::Stripe& stripe : places_.tactels->place(places_.end, tactel_count(columns_), x))
      if (!places_.tactels->write(direct_, std::move(stripe), x)) return {};
    if (!places_.tactels->flush(direct_)) return {};
  }
  const Payload parts(payload, places_.parameters.has_value());
  Unwritten chunk{places_.rows.place(places_.end, header.rows, parts.rows), {}};
  if (places_.parameters) chunk.parameters = places_.parameters->place(places_.end, header.contacts, parts.parameters);
  chunks_.push_back(header);
  return chunk;
}

bool PlacedSet::write(Unwritten chunk, const std::vector<std::string_view>& payload) {
  const Payload parts(payload, places_.parameters.has_value());
  for (PlacedRows::Stripe& stripe : chunk.rows)
    if (!places_.rows.write(direct_, std::move(stripe), parts.rows)) return false;
  for (PlacedRows::Stripe& stripe : chunk.parameters)
    if (!places_.parameters->write(direct_, std::move(stripe), parts.parameters)) return false;
  return write_all(headers_, bytes_of(chunks_, chunks_.size() - 1));
}

// Another process writes the same pages once they have all their rows: in a cache of this one they must not be later.
bool PlacedSet::flush() {
  return places_.rows.flush(direct_) && (!places_.parameters || places_.parameters->flush(direct_)) &&
         (direct_.direct() || synced(file_));
}

bool PlacedSet::sync() const { return synced(file_) && synced(headers_); }

void PlacedSet::begin_sync() const { ::sync_file_range(file_, 0, 0, SYNC_FILE_RANGE_WRITE); }

std::string PlacedSet::tail(std::uint64_t from) const {
  const std::uint64_t headers = chunks_.size() - from;
  std::string tail(reinterpret_cast<const char*>(&headers), sizeof headers);
  tail += bytes_of(chunks_, from);
  tail += places_.rows.tail();
  if (places_.parameters) tail += places_.parameters->tail();
  return tail;
}

/// Returns those of chunks that this process does not know.
std::vector<ChunkHeader> PlacedSet::take_headers(std::string_view& tail) {
  std::uint64_t count = 0;
  if (tail.size() < sizeof count) throw std::length_error("tail of a set");
  std::memcpy(&count, tail.data(), sizeof count);
  tail.remove_prefix(sizeof count);
  const std::size_t before = chunks_.size();
  for (ChunkHeader header; count > 0; --count, tail.remove_prefix(sizeof header)) {
    if (tail.size() < sizeof header) throw std::length_error("tail of a set");
    std::memcpy(&header, tail.data(), sizeof header);
    if (header.chunk != chunks_.size()) continue;
    places_.skip(header, columns_);
    chunks_.push_back(header);
  }
  return {chunks_.begin() + static_cast<std::ptrdiff_t>(before), chunks_.end()};
}

void PlacedSet::take_rows(std::string_view tail) {
  places_.rows.take_tail(tail);
  if (places_.parameters) places_.parameters->take_tail(tail);
}

bool PlacedSet::fits_hdf5() const {
  const auto fits = [](const PlacedRows& rows) { return rows.rows() >= rows.rows_of_stripe(); };
  return fits(places_.rows) && (!places_.parameters || fits(*places_.parameters));
}

bool PlacedSet::finish(const ContactSet& set) {
  if (!flush()) return false;
  std::vector<const PlacedRows*> all{&places_.rows};
  for (const auto* more : {&places_.parameters, &places_.tactels})
    if (*more) all.push_back(&**more);
  errno = 0;
  const std::optional<std::uint64_t> end = write_headers(file_, places_.end, columns_, all, set);
  return end && ::ftruncate(file_, static_cast<off_t>(*end)) == 0 && ::fsync(file_) == 0;
}

}  // namespace tactel::host
