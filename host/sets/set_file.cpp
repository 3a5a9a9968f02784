// SPDX-License-Identifier: Apache-2.0
#include "host/sets/set_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "host/sets/set_seal.h"
#include "host/sets/set_spool.h"
#include "host/support/bounded_file.h"
#include "host/support/errors.h"
#include "hw/descriptor.h"

namespace tactel::host {
namespace {

constexpr const char* as_written = "as tactel generate wrote it: the file is damaged or cut short (tactel check)";
constexpr std::size_t most_attribute_bytes = std::size_t{1} << 28;
constexpr std::uint64_t most_compression = 1100;  ///< deflate gives 1032 at most

/// Texts of variable length, given back to the library when they have been copied.
class VariableTexts {
 public:
  VariableTexts(hid_t type, hid_t space, std::size_t count) : type_(type), space_(space), texts_(count, nullptr) {}
  ~VariableTexts() {
    if (read_) H5Dvlen_reclaim(type_, space_, H5P_DEFAULT, texts_.data());
  }
  VariableTexts(const VariableTexts&) = delete;
  VariableTexts& operator=(const VariableTexts&) = delete;
  bool read(hid_t attribute) { return read_ = H5Aread(attribute, type_, texts_.data()) >= 0; }
  std::vector<std::string> copy() const {
    std::vector<std::string> copied;
    for (const char* text : texts_) copied.emplace_back(text ? text : "");
    return copied;
  }

 private:
  hid_t type_, space_;
  std::vector<char*> texts_;
  bool read_ = false;
};

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t end = std::min(text.find('\n', from), text.size());
    lines.push_back(text.substr(from, end - from));
    from = end + 1;
  }
  return lines;
}

/// Whether the numbers of a dataset fill the file as they are, or squeezed by a filter.
bool compressed(hid_t plan) {
  for (int i = 0; i < H5Pget_nfilters(plan); ++i) {
    unsigned flags = 0, parameters = 0;
    std::size_t values = 0;
    const auto filter = H5Pget_filter2(plan, i, &flags, &values, nullptr, 0, nullptr, &parameters);
    if (filter != H5Z_FILTER_FLETCHER32 && filter != H5Z_FILTER_SHUFFLE) return true;
  }
  return false;
}

/// The filter of a dataset that this HDF5 lacks, as LZF of h5py; empty where it has all.
std::string missing_filter(hid_t plan) {
  for (int i = 0; i < H5Pget_nfilters(plan); ++i) {
    unsigned flags = 0, parameters = 0;
    std::size_t values = 0;
    char name[64] = "";
    const auto filter = H5Pget_filter2(plan, i, &flags, &values, nullptr, sizeof name, name, &parameters);
    if (H5Zfilter_avail(filter) <= 0) return fmt::format("packed by the filter {} ({})", name, filter);
  }
  return "";
}

/// The place of Fletcher32 among the filters of a dataset; -1: it has none.
int fletcher_place(hid_t plan) {
  for (int i = 0; i < H5Pget_nfilters(plan); ++i) {
    unsigned flags = 0, parameters = 0;
    std::size_t values = 0;
    if (H5Pget_filter2(plan, i, &flags, &values, nullptr, 0, nullptr, &parameters) == H5Z_FILTER_FLETCHER32) return i;
  }
  return -1;
}

/// Why the system does not open a file for reading; empty where it does. A pipe or a device is not opened at all: it
/// could wait for ever.
std::string unreadable(const std::filesystem::path& path) {
  if (has_nul(path)) return "its name holds a NUL byte";
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) return "missing";
  if (std::filesystem::is_directory(status)) return "a folder";
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) return "no regular file";
  return hw::Descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) < 0 ? std::strerror(errno) : "";
}

hid_t open_to_read(const std::filesystem::path& path) {
  prepare_hdf5();
  if (!unreadable(path).empty()) return H5I_INVALID_HID;
  const WithoutLocks without;
  return H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
}

}  // namespace

SetFile::SetFile(const std::filesystem::path& path) : path_(path), file_(open_to_read(path), H5Fclose) {
  std::error_code error;
  if (const auto parts = SetSpool::folder(path);
      !std::filesystem::exists(path, error) && std::filesystem::exists(parts, error))
    refuse("(file)", "unfinished",
           "finished: the command that began it goes on with " + parts.string() + " if --resume is added");
  if (!file_.open()) {
    const std::string why = unreadable(path);
    refuse("(file)", why.empty() ? "not HDF5, or damaged" : why, "an HDF5 file written by tactel generate");
  }
  if (const std::string format = text("format"); format != "tactel contact set 1")
    refuse("format", format.empty() ? "(missing)" : format, "tactel contact set 1: a file written by tactel generate");
}

void SetFile::refuse(const std::string& key, const std::string& value, const std::string& allowed) const {
  throw ConfigError(path_.string(), key, value, allowed);
}

std::vector<std::string> SetFile::attribute_texts(hid_t where, const std::string& name) const {
  const Handle attribute(H5Aopen(where, name.c_str(), H5P_DEFAULT), H5Aclose);
  if (!attribute.open()) refuse(name, "unreadable", as_written);
  const Handle type(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
  if (H5Tget_class(type) != H5T_STRING) refuse(name, "of another type", "a text");
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  const bool variable = H5Tis_variable_str(type) > 0;
  const std::size_t size = variable ? sizeof(char*) : H5Tget_size(type);
  if (count < 0 || size == 0 || static_cast<std::size_t>(count) > most_attribute_bytes / size)
    refuse(name, "too long", "a text of a set");
  if (count == 0) return {};
  if (variable) {
    VariableTexts texts(type, space, static_cast<std::size_t>(count));
    if (!texts.read(attribute)) refuse(name, "unreadable", as_written);
    return texts.copy();
  }
  std::string bytes(static_cast<std::size_t>(count) * size, '\0');
  if (H5Aread(attribute, type, bytes.data()) < 0) refuse(name, "unreadable", as_written);
  std::vector<std::string> texts;
  for (std::size_t at = 0; at < bytes.size(); at += size)
    texts.emplace_back(bytes.data() + at, strnlen(bytes.data() + at, size));
  return texts;
}

std::string SetFile::text(const char* attribute) const {
  if (!has(attribute)) return "";
  const std::vector<std::string> texts = attribute_texts(file_, attribute);
  if (texts.size() > 1) refuse(attribute, fmt::format("{} texts", texts.size()), "one text");
  return texts.empty() ? "" : texts[0];
}

std::vector<std::string> SetFile::texts(const char* attribute) const {
  if (!has(attribute)) return {};
  std::vector<std::string> texts = attribute_texts(file_, attribute);
  return texts.size() == 1 ? lines_of(texts[0]) : texts;
}

std::vector<std::string> SetFile::texts(const char* dataset, const char* attribute) const {
  if (!has_dataset(dataset)) return {};
  const Handle data(H5Dopen2(file_, dataset, H5P_DEFAULT), H5Dclose);
  if (!data.open() || H5Aexists(data, attribute) <= 0) return {};
  std::vector<std::string> texts = attribute_texts(data, attribute);
  return texts.size() == 1 ? lines_of(texts[0]) : texts;
}

std::uint64_t SetFile::number(const char* attribute) const {
  if (!has(attribute)) return 0;
  std::uint64_t value = 0;
  const Handle open(H5Aopen(file_, attribute, H5P_DEFAULT), H5Aclose);
  const Handle type(H5Aget_type(open), H5Tclose), space(H5Aget_space(open), H5Sclose);
  std::int64_t sign = 0;
  const bool readable = H5Tget_class(type) == H5T_INTEGER && H5Sget_simple_extent_npoints(space) == 1 &&
                        H5Aread(open, H5T_NATIVE_UINT64, &value) >= 0 && H5Aread(open, H5T_NATIVE_INT64, &sign) >= 0;
  if (!readable) refuse(attribute, "not one whole number", "a whole number");
  if (sign < 0) refuse(attribute, fmt::format("{}", sign), "a whole number, at least 0");
  return value;
}

std::string SetFile::seal() const { return file_seal(file_); }

bool SetFile::has_dataset(const char* name) const { return H5Lexists(file_, name, H5P_DEFAULT) > 0; }

SetFile::Column SetFile::column(const char* name, bool matrix, bool real) const {
  if (!has_dataset(name)) refuse(name, "missing", "a dataset of the set");
  H5L_info_t link;
  if (H5Lget_info(file_, name, &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
    refuse(name, "a link", "a dataset of this file");
  Column column(name, Handle(H5Dopen2(file_, name, H5P_DEFAULT), H5Dclose));
  if (!column.data_.open()) refuse(name, "unreadable", as_written);
  const Handle space(H5Dget_space(column.data_), H5Sclose), stored(H5Dget_type(column.data_), H5Tclose);
  hsize_t extent[H5S_MAX_RANK] = {0, 0};
  if (H5Sget_simple_extent_type(space) != H5S_SIMPLE || H5Sget_simple_extent_ndims(space) != (matrix ? 2 : 1))
    refuse(name, "of another rank", matrix ? "[rows, inputs]" : "[rows]");
  if (H5Tget_class(stored) != (real ? H5T_FLOAT : H5T_INTEGER))
    refuse(name, "of another type", real ? "floating-point numbers" : "whole numbers");
  H5Sget_simple_extent_dims(space, extent, nullptr);
  if (matrix && (extent[1] < 1 || extent[1] > most_columns))
    refuse(name, fmt::format("{} columns", extent[1]), fmt::format("1 to {} columns", most_columns));
  column.rows = extent[0];
  column.columns = matrix ? static_cast<int>(extent[1]) : 0;
  if (column.rows > (std::uint64_t{1} << 40)) refuse(name, fmt::format("{} rows", column.rows), as_written);
  look_at_layout(name, column);
  if (H5Aexists(column.data_, seal_name) > 0) {
    const std::vector<std::string> seal = attribute_texts(column.data_, seal_name);
    column.seal_ = seal.size() == 1 ? seal[0] : "(several)";
  }
  return column;
}

bool SetFile::Column::sealed(const RunningChecksum& numbers) const {
  return seal_ == dataset_seal(data_, name_, numbers.text());
}

/// How the rows are stored; throws where the file holds fewer numbers than the dataset claims.
void SetFile::look_at_layout(const std::string& name, Column& column) const {
  const Handle plan(H5Dget_create_plist(column.data_), H5Pclose), stored(H5Dget_type(column.data_), H5Tclose);
  const H5D_layout_t layout = H5Pget_layout(plan);
  if (const std::string missing = missing_filter(plan); !missing.empty())
    refuse(name, missing, "packed by gzip or not at all: h5repack -f NONE COPY.h5 SET.h5 where that filter is");
  column.copied = compressed(plan) || H5Tget_order(stored) == H5T_ORDER_BE ||
                  (H5Tget_class(stored) == H5T_FLOAT && H5Tget_size(stored) != sizeof(float));
  if (layout == H5D_CHUNKED) {
    hsize_t chunk[H5S_MAX_RANK] = {0};
    if (H5Pget_chunk(plan, H5S_MAX_RANK, chunk) < 1) refuse(name, "unreadable", as_written);
    column.chunk_rows = chunk[0];
    column.fletcher_ = fletcher_place(plan);
  }
  if (layout == H5D_VIRTUAL || H5Pget_external_count(plan) > 0)
    refuse(name, "kept in another file", "numbers in this file");
  const std::uint64_t claimed =
      column.rows * H5Tget_size(stored) * static_cast<std::uint64_t>(std::max(column.columns, 1));
  const std::uint64_t stored_bytes = H5Dget_storage_size(column.data_);
  if (claimed / (compressed(plan) ? most_compression : 1) > stored_bytes) refuse(name, "cut short", as_written);
}

/// A chunk that the index has lost would be read as zeros, one with another filter mask without its checksum.
void SetFile::check_chunks(const Column& column, std::uint64_t first, std::uint64_t count) const {
  if (first > column.rows || count > column.rows - first)
    refuse(column.name_, fmt::format("{} rows", column.rows), fmt::format("at least {} rows", first + count));
  if (column.fletcher_ < 0 || count == 0) return;
  for (std::uint64_t row = first / column.chunk_rows * column.chunk_rows; row < first + count;
       row += column.chunk_rows) {
    const hsize_t place[2] = {row, 0};
    unsigned mask = 0;
    haddr_t address = HADDR_UNDEF;
    hsize_t size = 0;
    if (H5Dget_chunk_info_by_coord(column.data_, place, &mask, &address, &size) < 0 || address == HADDR_UNDEF ||
        (mask >> column.fletcher_ & 1) != 0)
      refuse(column.name_, fmt::format("damaged in row {} or after it", row), as_written);
  }
}

void SetFile::read(const Column& column, hid_t type, std::uint64_t first, std::uint64_t count, void* values) const {
  const Handle space(H5Dget_space(column.data_), H5Sclose);
  const hsize_t start[2] = {first, 0}, size[2] = {count, static_cast<hsize_t>(column.columns)};
  const Handle memory(H5Screate_simple(column.columns ? 2 : 1, size, nullptr), H5Sclose);
  if (H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, size, nullptr) < 0 ||
      H5Dread(column.data_, type, memory, space, H5P_DEFAULT, values) < 0)
    refuse(column.name_, fmt::format("damaged in rows {} to {}", first, first + count - 1), as_written);
}

}  // namespace tactel::host
