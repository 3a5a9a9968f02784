// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <functional>
#include <map>

#include "host/sets/contact_set.h"
#include "host/sets/hdf5_handle.h"
#include "host/sets/placed_driver.h"
#include "host/sets/set_headers.h"
#include "host/sets/set_seal.h"
#include "host/support/checksum.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

/// Bytes of the largest chunk, at most: HDF5 keeps 1 MiB of chunks of an open dataset in memory.
constexpr std::uint64_t most_chunk_bytes = 1u << 20;
constexpr std::uint64_t most_chunk_rows = 8192;

/// `count`: of values in a list; none: one value.
bool write_attribute(hid_t where, const char* name, hid_t type, const void* values, std::optional<hsize_t> count = {}) {
  const Handle space(count ? H5Screate_simple(1, &*count, nullptr) : H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate2(where, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return attribute.open() && H5Awrite(attribute, type, values) >= 0;
}

bool write_text(hid_t where, const char* name, const std::string& text) {
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, text.size() + 1);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return write_attribute(where, name, type, text.c_str());
}

bool write_number(hid_t where, const char* name, std::uint64_t value) {
  return write_attribute(where, name, H5T_STD_U64LE, &value);
}

/// A dataset of its final size, its unit beside it, and the checksum of what was written to it.
struct Column {
  std::string name;
  Handle data;
  hid_t type;
  std::size_t value_bytes;
  int columns;
  std::vector<const char*> dimensions{};  ///< names
  std::size_t written = 0;                ///< rows
  RunningChecksum sum{};
};

/// A dataset along one of its dimensions, as HDF5 Dimension Scales list it.
struct AlongScale {
  hobj_ref_t dataset;
  int dimension, unused = 0;  ///< the same set gives the same bytes
};

/// Names the dimensions of the datasets, for netCDF, xarray and h5py: to each name belongs a dataset without numbers
/// (HDF5 Dimension Scale Specification 1.0; its name is netCDF's, for a dimension without coordinates). It and the
/// datasets along it refer to each other. Returns false on failure.
bool write_dimensions(hid_t file, const std::vector<Column>& columns) {
  const Handle many(H5Tvlen_create(H5T_STD_REF_OBJ), H5Tclose);
  const Handle along(H5Tcreate(H5T_COMPOUND, sizeof(AlongScale)), H5Tclose);
  H5Tinsert(along, "dataset", HOFFSET(AlongScale, dataset), H5T_STD_REF_OBJ);
  H5Tinsert(along, "dimension", HOFFSET(AlongScale, dimension), H5T_NATIVE_INT);
  std::map<std::string, std::vector<AlongScale>> scales;
  std::map<std::string, hsize_t> sizes;
  bool good = true;
  for (const Column& column : columns) {
    hsize_t extent[2] = {0, 0};
    const Handle space(H5Dget_space(column.data), H5Sclose);
    H5Sget_simple_extent_dims(space, extent, nullptr);
    AlongScale self{};
    good = good && H5Rcreate(&self.dataset, file, column.name.c_str(), H5R_OBJECT, -1) >= 0;
    for (const char* name : column.dimensions) {
      scales[name].push_back(self);
      sizes[name] = extent[self.dimension++];
    }
  }
  for (const auto& [name, datasets] : scales) {
    const Handle space(H5Screate_simple(1, &sizes[name], nullptr), H5Sclose),
        plain(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_obj_track_times(plain, false);
    const Handle scale(H5Dcreate2(file, name.c_str(), H5T_IEEE_F32LE, space, H5P_DEFAULT, plain, H5P_DEFAULT),
                       H5Dclose);
    good = good && scale.open() && write_text(scale, "CLASS", "DIMENSION_SCALE") &&
           write_text(scale, "NAME",
                      fmt::format("This is a netCDF dimension but not a netCDF variable.{:10}", sizes[name])) &&
           write_attribute(scale, "REFERENCE_LIST", along, datasets.data(), datasets.size());
  }
  for (const Column& column : columns) {
    hobj_ref_t scale[2] = {0, 0};
    const hvl_t lists[2] = {{1, &scale[0]}, {1, &scale[1]}};
    for (std::size_t i = 0; i < column.dimensions.size(); ++i)
      good = good && H5Rcreate(&scale[i], file, column.dimensions[i], H5R_OBJECT, -1) >= 0;
    good = good && write_attribute(column.data, "DIMENSION_LIST", many, lists, column.dimensions.size());
  }
  return good;
}

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
         (!set.pad ||
          (write_text(file, "kind", "pad") && write_number(file, "axes", static_cast<std::uint64_t>(set.axes)))) &&
         write_text(file, "indenter_names", joined(set.indenter_names)) &&
         write_text(file, "units",
                    set.pad ? "mm, MPa, N, N mm, degrees; sigma_z < 0 is compression, tau > 0 drags towards +x, +y"
                            : "mm, MPa, N/mm; sigma_y < 0 is compression, tau_xy > 0 drags towards +x");
}

/// A new file whose bytes do not depend on the hour. The format of HDF5 1.8: its headers carry checksums, too, and an
/// attribute may be longer than 64 KiB. The temporary is locked already; HDF5 must not lock it again.
Handle create_file(const std::filesystem::path& path, const Handle& access) {
  const Handle plain(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  H5Pset_obj_track_times(plain, false);
  H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18);
  const WithoutLocks without;
  return Handle(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, plain, access), H5Fclose);
}

/// Datasets of `columns` of their final size, and the attribute that names them. Empty on failure.
std::vector<Column> create_columns(hid_t file, const SetColumns& columns, std::size_t rows, std::size_t contacts,
                                   bool compress) {
  std::vector<Column> all;
  const ContactSet nothing(columns);
  bool good = true;
  std::string names;
  const auto create = [&](const char* name, const auto& values, int width, const char* unit, std::size_t size,
                          hsize_t rows_of_chunk, std::vector<const char*> dimensions) {
    using T = typename std::remove_cvref_t<decltype(values)>::value_type;
    if (!good) return;
    names += (names.empty() ? "" : "\n") + std::string(name);
    all.push_back(create_column(file, name, type_of<T>(), size, width, rows_of_chunk, unit, compress));
    all.back().dimensions = std::move(dimensions);
    good = all.back().data.open();
  };
  each_dataset(nothing, [&](const char* name, const auto& values, int width, const char* unit) {
    std::vector<const char*> dimensions = {"row"};
    if (width > 0) dimensions.push_back(std::string_view(name) == "inputs" ? "input" : "direction");
    create(name, values, width, unit, rows, rows_of_chunk(columns.inputs), std::move(dimensions));
  });
  each_other_dataset(nothing, [&](const char* name, const auto& values, int width, const char* unit) {
    std::vector<const char*> dimensions = {"tactel"};
    if (width > 0) dimensions = {"contacts", "parameter"};
    create(name, values, width, unit, width > 0 ? contacts : values.size(), rows_of_chunk(width),
           std::move(dimensions));
    if (good && width > 0)
      good = write_text(all.back().data, "columns", joined(columns.parameters)) &&
             write_text(all.back().data, "units", joined(columns.parameter_units));
  });
  if (!good || !write_text(file, "columns", names)) all.clear();
  return all;
}

/// Attributes, then the seals of the datasets and of the file, which are closed. `sums`: [columns], checksums of their
/// numbers. Returns false on failure.
bool finish_file(Handle& file, std::vector<Column>& columns, const std::vector<std::string>& sums,
                 const ContactSet& set) {
  bool good = write_attributes(file, set) && write_dimensions(file, columns);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    good = good && write_text(columns[c].data, seal_name, dataset_seal(columns[c].data, columns[c].name, sums[c]));
    good = columns[c].data.close() && good;
  }
  good = good && write_text(file, seal_name, file_seal(file));
  good = good && H5Fflush(file, H5F_SCOPE_GLOBAL) >= 0;
  return file.close() && good;
}

}  // namespace

// The same in every dataset with rows, so that a damaged chunk takes as few rows as possible along.
std::uint64_t rows_of_chunk(int columns) {
  const std::uint64_t fit = most_chunk_bytes / (sizeof(float) * static_cast<std::uint64_t>(std::max(columns, 1)));
  return std::clamp<std::uint64_t>(std::bit_floor(fit), 1, most_chunk_rows);
}

std::optional<std::uint64_t> write_headers(int descriptor, std::uint64_t end, const SetColumns& columns,
                                           const std::vector<const PlacedRows*>& placed, const ContactSet& set) {
  prepare_hdf5();
  PlacedFile places{.file = descriptor, .end = end};
  Handle file = create_file("set", placed_access(places));
  const std::size_t contacts = columns.has("parameters") && !columns.parameters.empty() ? placed[1]->rows() : 0;
  std::vector<Column> all;
  if (file.open()) all = create_columns(file, columns, placed[0]->rows(), contacts, false);
  bool good = !all.empty();
  std::string nothing;  // in place of chunks, which are there
  std::vector<std::string> sums;
  for (const PlacedRows* rows : placed) {
    const auto& datasets = rows->datasets();
    for (std::size_t d = 0; good && d < datasets.size(); ++d) {
      const Column& column = all[sums.size()];
      nothing.resize(std::max<std::size_t>(nothing.size(), rows->chunk_bytes(d)));
      for (std::size_t stripe = 0; good && stripe < rows->stripes().size(); ++stripe) {
        const hsize_t first[2] = {stripe * rows->rows_of_stripe(), 0};
        places.chunk = rows->stripes()[stripe] + rows->chunk_begin(d);
        good = H5Dwrite_chunk(column.data, H5P_DEFAULT, 0, first, rows->chunk_bytes(d), nothing.data()) >= 0;
      }
      sums.push_back(datasets[d].sum.text());
    }
  }
  places.chunk = 0;  // what comes now is no chunk
  if (!good || sums.size() != all.size() || !finish_file(file, all, sums, set)) return {};
  return places.end;
}

struct ContactSetWriter::State {
  explicit State(const std::filesystem::path& path)
      : path((prepare_hdf5(), path)),
        whole("--output", path),
        file(create_file(whole.temporary(), Handle(H5Pcreate(H5P_FILE_ACCESS), H5Pclose))) {}

  std::filesystem::path path;
  DurableFile whole;
  Handle file;
  std::vector<Column> columns;  ///< in the order of each_dataset, then of each_other_dataset
};

ContactSetWriter::ContactSetWriter(const std::filesystem::path& path, const SetColumns& columns, std::size_t rows,
                                   std::size_t contacts, bool compress)
    : state_(std::make_unique<State>(path)) {
  if (state_->file.open()) state_->columns = create_columns(state_->file, columns, rows, contacts, compress);
  if (state_->columns.empty()) fail();
  for (const auto& [name, places] : {std::pair("tactel_x", &columns.tactel_x), {"tactel_y", &columns.tactel_y}}) {
    const auto column = std::ranges::find(state_->columns, name, &Column::name);
    if (column != state_->columns.end() && !write_rows(*column, places->data(), places->size())) fail();
  }
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
  std::vector<std::string> sums;
  for (const Column& column : state_->columns) sums.push_back(column.sum.text());
  if (!finish_file(state_->file, state_->columns, sums, set)) fail();
  state_->whole.commit();
}

void write_contact_set(const std::filesystem::path& path, const ContactSet& set) {
  const SetColumns columns = set.columns();
  const std::size_t contacts =
      columns.parameters.empty() ? 0 : set.contact_parameters.size() / columns.parameters.size();
  const bool compress = set.plan.find("\ncompress yes\n") != std::string::npos;
  ContactSetWriter writer(path, columns, set.rows(), contacts, compress);
  writer.append(set);
  writer.finish(set);
}

}  // namespace tactel::host
