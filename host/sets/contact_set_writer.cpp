// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <functional>

#include "host/sets/contact_set.h"
#include "host/sets/hdf5_handle.h"
#include "host/support/checksum.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

/// Bytes of the largest chunk, at most: HDF5 keeps 1 MiB of chunks of an open dataset in memory.
constexpr std::uint64_t most_chunk_bytes = 1u << 20;
constexpr std::uint64_t most_chunk_rows = 8192;

/// Rows of a chunk, the same in every dataset, so that a damaged one takes as few rows as possible along.
hsize_t chunk_rows(int inputs) {
  const std::uint64_t fit = most_chunk_bytes / (sizeof(float) * static_cast<std::uint64_t>(std::max(inputs, 1)));
  return std::clamp<std::uint64_t>(std::bit_floor(fit), 1, most_chunk_rows);
}

bool write_text(hid_t where, const char* name, const std::string& text) {
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
  H5Tset_size(type, text.size() + 1);
  H5Tset_cset(type, H5T_CSET_UTF8);
  const Handle attribute(H5Acreate2(where, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return attribute.open() && H5Awrite(attribute, type, text.c_str()) >= 0;
}

bool write_number(hid_t where, const char* name, std::uint64_t value) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate2(where, name, H5T_STD_U64LE, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return attribute.open() && H5Awrite(attribute, H5T_NATIVE_UINT64, &value) >= 0;
}

/// A dataset of its final size, its unit beside it, and the checksum of what was written to it.
struct Column {
  std::string name;
  Handle data;
  hid_t type;
  std::size_t value_bytes;
  int columns;
  std::size_t written = 0;  ///< rows
  RunningChecksum sum{};
};

Column create_column(hid_t file, const char* name, hid_t type, std::size_t rows, int columns, hsize_t rows_of_chunk,
                     const char* unit, bool compress) {
  const hsize_t extent[2] = {rows, static_cast<hsize_t>(columns)};
  const hsize_t chunk[2] = {std::min<hsize_t>(rows, rows_of_chunk), static_cast<hsize_t>(columns)};
  const int rank = columns ? 2 : 1;
  const Handle space(H5Screate_simple(rank, extent, nullptr), H5Sclose);
  const Handle plain(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(plain, false);  // the same set gives the same bytes
  if (rows > 0) {
    H5Pset_chunk(plain, rank, chunk);
    if (compress) H5Pset_shuffle(plain), H5Pset_deflate(plain, 1);
    H5Pset_fletcher32(plain);
    H5Pset_fill_time(plain, H5D_FILL_TIME_ALLOC);  // what the last chunk does not use is 0
  }
  Column column{name, Handle(H5Dcreate2(file, name, type, space, H5P_DEFAULT, plain, H5P_DEFAULT), H5Dclose), type,
                H5Tget_size(type), columns};
  if (column.data.open() && !write_text(column.data, "unit", unit)) column.data.close();
  return column;
}

/// The next rows of a dataset.
bool write_rows(Column& column, const void* values, std::size_t count) {
  if (count == 0) return true;
  const std::size_t rows = column.columns ? count / static_cast<std::size_t>(column.columns) : count;
  const Handle space(H5Dget_space(column.data), H5Sclose);
  const hsize_t start[2] = {column.written, 0}, size[2] = {rows, static_cast<hsize_t>(column.columns)};
  const Handle memory(H5Screate_simple(column.columns ? 2 : 1, size, nullptr), H5Sclose);
  column.sum.add({static_cast<const char*>(values), count * column.value_bytes});
  column.written += rows;
  return H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, size, nullptr) >= 0 &&
         H5Dwrite(column.data, column.type, memory, space, H5P_DEFAULT, values) >= 0;
}

std::string joined(const std::vector<std::string>& names) { return fmt::format("{}", fmt::join(names, "\n")); }

bool write_attributes(hid_t file, const ContactSet& set) {
  return write_text(file, "tactel", TACTEL_VERSION) && write_text(file, "format", "tactel contact set 1") &&
         write_text(file, "sweep", set.sweep) && write_number(file, "seed", set.seed) &&
         write_text(file, "device", set.device) && write_text(file, "rung", set.rung) &&
         write_text(file, "transducer", set.transducer) && write_text(file, "plan", set.plan) &&
         write_number(file, "contacts", set.contacts) &&
         write_number(file, "contacts_without_rows", set.without_rows) &&
         write_number(file, "fallback_contacts", set.fell_back) &&
         write_number(file, "unsolved_contacts", set.unsolved) &&
         (!set.press_rows || write_text(file, "press_rows", "true")) &&
         write_text(file, "indenter_names", joined(set.indenter_names)) &&
         write_text(file, "units", "mm, MPa, N/mm; sigma_y < 0 is compression, tau_xy > 0 drags towards +x");
}

/// A new file whose bytes do not depend on the hour. The format of HDF5 1.8: its headers carry checksums, too, and an
/// attribute may be longer than 64 KiB. The temporary is locked already; HDF5 must not lock it again.
Handle create_file(const std::filesystem::path& path) {
  prepare_hdf5();
  const Handle plain(H5Pcreate(H5P_FILE_CREATE), H5Pclose), access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_obj_track_times(plain, false);
  H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18);
  H5Pset_file_locking(access, false, true);
  return Handle(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, plain, access), H5Fclose);
}

}  // namespace

struct ContactSetWriter::State {
  explicit State(const std::filesystem::path& path)
      : path(path), whole("--output", path), file(create_file(whole.temporary())) {}

  std::filesystem::path path;
  DurableFile whole;
  Handle file;
  std::vector<Column> columns;  ///< in the order of each_dataset, then of each_other_dataset
};

ContactSetWriter::ContactSetWriter(const std::filesystem::path& path, const SetColumns& columns, std::size_t rows,
                                   std::size_t contacts, bool compress)
    : state_(std::make_unique<State>(path)) {
  const ContactSet nothing(columns);
  bool good = state_->file.open();
  std::string names;
  const auto create = [&](const char* name, const auto& values, int width, const char* unit, std::size_t size,
                          hsize_t rows_of_chunk) {
    using T = typename std::remove_cvref_t<decltype(values)>::value_type;
    if (!good) return;
    names += (names.empty() ? "" : "\n") + std::string(name);
    state_->columns.push_back(
        create_column(state_->file, name, type_of<T>(), size, width, rows_of_chunk, unit, compress));
    good = state_->columns.back().data.open();
  };
  each_dataset(nothing, [&](const char* name, const auto& values, int width, const char* unit) {
    create(name, values, width, unit, rows, chunk_rows(columns.inputs));
  });
  each_other_dataset(nothing, [&](const char* name, const auto& values, int width, const char* unit) {
    create(name, values, width, unit, width > 0 ? contacts : values.size(), chunk_rows(width));
    if (!good) return;
    Column& column = state_->columns.back();
    good = width > 0 ? write_text(column.data, "columns", joined(columns.parameters)) &&
                           write_text(column.data, "units", joined(columns.parameter_units))
                     : write_rows(column, values.data(), values.size());
  });
  if (!good || !write_text(state_->file, "columns", names)) fail();
}

ContactSetWriter::~ContactSetWriter() = default;

void ContactSetWriter::fail() const {
  throw ConfigError("command line", "--output", state_->path.string(),
                    "a file that can be written, on a disk with room for it");
}

void ContactSetWriter::append(const ContactSet& rows) {
  const auto write = [&](const char* name, const auto& values, int, const char*) {
    const auto column = std::ranges::find(state_->columns, name, &Column::name);
    if (column != state_->columns.end() && !write_rows(*column, values.data(), values.size())) fail();
  };
  each_dataset(rows, write);
  if (rows.has("parameters")) write("parameters", rows.contact_parameters, 0, "");
}

void ContactSetWriter::finish(const ContactSet& set) {
  bool good = write_attributes(state_->file, set);
  for (Column& column : state_->columns) {
    good = good && write_text(column.data, "checksum", column.sum.text());
    good = column.data.close() && good;
  }
  good = good && H5Fflush(state_->file, H5F_SCOPE_GLOBAL) >= 0;
  good = state_->file.close() && good;
  if (!good) fail();
  state_->whole.commit();
}

void write_contact_set(const std::filesystem::path& path, const ContactSet& set) {
  const SetColumns columns = set.columns();
  const std::size_t contacts =
      columns.parameters.empty() ? 0 : set.contact_parameters.size() / columns.parameters.size();
  ContactSetWriter writer(path, columns, set.rows(), contacts);
  writer.append(set);
  writer.finish(set);
}

}  // namespace tactel::host
