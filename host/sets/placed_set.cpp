// SPDX-License-Identifier: Apache-2.0
#include "host/sets/placed_set.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <system_error>

#include "host/sets/set_headers.h"
#include "host/support/durable_file.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t rows_from = 4096;  ///< before it is HDF5's superblock

int open_file(const fs::path& path) {
  const int file = ::open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (file < 0) throw std::system_error(errno, std::generic_category());
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

std::optional<PlacedRows> placed_tactels(const SetColumns& columns) {
  if (!columns.has("tactel_x") || columns.tactel_x.empty()) return {};
  std::vector<PlacedRows::Dataset> datasets;
  datasets.push_back({"tactel_x", sizeof(float)});
  return PlacedRows(std::move(datasets), std::min<std::uint64_t>(columns.tactel_x.size(), rows_of_chunk(0)));
}

}  // namespace

PlacedSet::Places::Places(const SetColumns& columns)
    : rows(placed_rows(columns)),
      parameters(placed_parameters(columns)),
      tactels(placed_tactels(columns)),
      end(rows_from) {}

std::vector<fs::path> PlacedSet::files(const fs::path& folder) { return {folder / "placed", folder / "set"}; }

std::vector<ChunkHeader> PlacedSet::read_headers(const fs::path& folder) {
  std::vector<ChunkHeader> headers;
  std::ifstream in(folder / "placed", std::ios::binary);
  ChunkHeader header;
  while (in.read(reinterpret_cast<char*>(&header), sizeof header) && header.whole() && header.chunk == headers.size())
    headers.push_back(header);
  return headers;
}

PlacedSet::PlacedSet(const fs::path& folder, const SetColumns& columns)
    : columns_(columns), file_(open_file(folder / "set")), staged_(folder / "set"), places_(columns) {
  headers_ = open_file(folder / "placed");
}

PlacedSet::~PlacedSet() {
  if (file_ >= 0) ::close(file_);
  if (headers_ >= 0) ::close(headers_);
}

void PlacedSet::resume(std::vector<ChunkHeader> headers) {
  if (const std::size_t whole = take(headers); whole < headers.size()) {
    headers.resize(whole);
    places_ = Places(columns_);
    headers.resize(take(headers));
  }
  chunks_ = std::move(headers);
  const auto end = static_cast<off_t>(chunks_.size() * sizeof(ChunkHeader));
  torn_ = ::lseek(headers_, 0, SEEK_END) != end;
  if ((torn_ && ::ftruncate(headers_, end) != 0) || ::lseek(headers_, end, SEEK_SET) != end)
    throw std::system_error(errno, std::generic_category());
}

/// Goes on behind these chunks. Returns how many of them are whole.
std::size_t PlacedSet::take(std::span<const ChunkHeader> headers) {
  std::string payload;
  for (std::size_t k = 0; k < headers.size(); ++k)
    if (!read(places_, headers[k], payload)) return k;
  return headers.size();
}

bool PlacedSet::read(Places& places, const ChunkHeader& header, std::string& payload) const {
  const off_t size = ::lseek(file_, 0, SEEK_END);
  if (size < 0 || header.bytes > static_cast<std::uint64_t>(size)) return false;
  payload.clear();
  std::vector<std::string> values;
  const auto take = [&](PlacedRows& of, std::uint64_t rows) {
    if (!of.read(file_, places.end, rows, values)) return false;
    for (const std::string& part : values) payload += part;
    return true;
  };
  if (places.tactels && header.chunk == 0 && !places.tactels->read(file_, places.end, columns_.tactel_x.size(), values))
    return false;
  return take(places.rows, header.rows) && (!places.parameters || take(*places.parameters, header.contacts)) &&
         checksum(payload) == header.payload_sum;
}

bool PlacedSet::append(const ChunkHeader& header, const std::vector<std::string_view>& payload) {
  std::vector<std::string_view> rows = payload, parameters;
  if (places_.parameters) parameters = {rows.back()}, rows.pop_back();
  if (places_.tactels && header.chunk == 0) {
    const std::string_view x(reinterpret_cast<const char*>(columns_.tactel_x.data()),
                             columns_.tactel_x.size() * sizeof(float));
    if (!places_.tactels->append(staged_, places_.end, columns_.tactel_x.size(), {x}) ||
        !places_.tactels->finish(staged_))
      return false;
  }
  if (!places_.rows.append(staged_, places_.end, header.rows, rows)) return false;
  if (places_.parameters && !places_.parameters->append(staged_, places_.end, header.contacts, parameters))
    return false;
  if (!staged_.flush() || !write_all(headers_, {reinterpret_cast<const char*>(&header), sizeof header})) return false;
  chunks_.push_back(header);
  return true;
}

bool PlacedSet::sync() const { return synced(file_) && synced(headers_); }

void PlacedSet::begin_sync() const { ::sync_file_range(file_, 0, 0, SYNC_FILE_RANGE_WRITE); }

bool PlacedSet::fits_hdf5() const {
  const auto fits = [](const PlacedRows& of) { return of.rows() >= of.rows_of_stripe(); };
  return fits(places_.rows) && (!places_.parameters || fits(*places_.parameters));
}

bool PlacedSet::finish(const ContactSet& set) {
  if (!places_.rows.finish(staged_) || (places_.parameters && !places_.parameters->finish(staged_))) return false;
  if (!staged_.flush()) return false;
  std::vector<const PlacedRows*> all{&places_.rows};
  for (const auto* more : {&places_.parameters, &places_.tactels})
    if (*more) all.push_back(&**more);
  errno = 0;
  const std::optional<std::uint64_t> end = write_headers(file_, places_.end, columns_, all, set);
  return end && ::ftruncate(file_, static_cast<off_t>(*end)) == 0 && ::fsync(file_) == 0;
}

}  // namespace tactel::host
