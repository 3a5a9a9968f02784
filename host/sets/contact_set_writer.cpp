// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <future>
#include <map>

#include "host/sets/contact_set.h"
#include "host/sets/hdf5_handle.h"
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
  std::uint64_t rows, rows_of_chunk, row_bytes;
  int columns;
  std::vector<const char*> dimensions{};  ///< names
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

Column create_column(hid_t file, const char* name, hid_t type, std::uint64_t rows, int columns,
                     std::uint64_t rows_of_chunk, const char* unit, bool compress) {
  rows_of_chunk = std::min(rows, rows_of_chunk);
  const hsize_t extent[2] = {rows, static_cast<hsize_t>(columns)};
  const hsize_t chunk[2] = {rows_of_chunk, static_cast<hsize_t>(columns)};
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
  Column column{.name = name,
                .data = Handle(H5Dcreate2(file, name, type, space, H5P_DEFAULT, plain, H5P_DEFAULT), H5Dclose),
                .type = type,
                .rows = rows,
                .rows_of_chunk = rows_of_chunk,
                .row_bytes = H5Tget_size(type) * static_cast<std::uint64_t>(std::max(columns, 1)),
                .columns = columns};
  if (column.data.open() && !write_text(column.data, "unit", unit)) column.data.close();
  return column;
}

/// Takes the next rows of a dataset, those of a whole chunk, into its sum, and puts the chunk's checksum behind them.
void finish_chunk(Column& column, std::uint64_t rows, std::string& chunk) {
  const std::uint64_t used = rows * column.row_bytes, size = column.rows_of_chunk * column.row_bytes;
  column.sum.add({chunk.data(), used});
  std::memset(chunk.data() + used, 0, size - used);
  const std::uint32_t sum = fletcher32({chunk.data(), size});  // faster than HDF5's filter, which copies the chunk
  std::memcpy(chunk.data() + size, &sum, sizeof sum);
}

/// Writes a chunk of so many rows, with its checksum.
bool write_chunk(const Column& column, std::uint64_t first, std::uint64_t rows, const std::string& chunk,
                 bool compress) {
  const hsize_t start[2] = {first, 0}, count[2] = {rows, static_cast<hsize_t>(column.columns)};
  if (compress) {
    const Handle space(H5Dget_space(column.data), H5Sclose);
    const Handle memory(H5Screate_simple(column.columns ? 2 : 1, count, nullptr), H5Sclose);
    return H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, nullptr) >= 0 &&
           H5Dwrite(column.data, column.type, memory, space, H5P_DEFAULT, chunk.data()) >= 0;
  }
  return H5Dwrite_chunk(column.data, H5P_DEFAULT, 0, start, chunk.size(), chunk.data()) >= 0;
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
Handle create_file(const std::filesystem::path& path) {
  const Handle plain(H5Pcreate(H5P_FILE_CREATE), H5Pclose), access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_obj_track_times(plain, false);
  H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18);
  const WithoutLocks without;
  return Handle(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, plain, access), H5Fclose);
}

/// Datasets of their final size, in the order of each_dataset, then of each_other_dataset, and the attribute that names
/// them. Empty on failure.
std::vector<Column> create_columns(hid_t file, const SetRows& rows, bool compress) {
  std::vector<Column> all;
  const ContactSet nothing(rows.columns);
  bool good = true;
  std::string names;
  const auto create = [&](const char* name, const auto& values, int width, const char* unit, std::uint64_t size,
                          std::uint64_t rows_of_chunk, std::vector<const char*> dimensions) {
    using T = typename std::remove_cvref_t<decltype(values)>::value_type;
    if (!good) return;
    names += (names.empty() ? "" : "\n") + std::string(name);
    all.push_back(create_column(file, name, type_of<T>(), size, width, rows_of_chunk, unit, compress));
    all.back().dimensions = std::move(dimensions);
    good = all.back().data.open();
  };
  each_dataset(nothing, [&](const char* name, const auto& values, int width, const char* unit) {
    std::vector<const char*> dimensions = {"row"};
    if (width > 0)
      dimensions.push_back(name == std::string_view("inputs")    ? "input"
                           : name == std::string_view("markers") ? "displacement"
                           : name == std::string_view("pixels")  ? "pixel"
                                                                 : "direction");
    create(name, values, width, unit, rows.rows,
           rows_of_chunk(std::max({rows.columns.inputs, rows.columns.marker_numbers, rows.columns.pixel_numbers})),
           std::move(dimensions));
  });
  each_other_dataset(nothing, [&](const char* name, const auto& values, int width, const char* unit) {
    std::vector<const char*> dimensions = {"tactel"};
    if (width > 0) dimensions = {"contacts", "parameter"};
    create(name, values, width, unit, width > 0 ? rows.contacts : values.size(), rows_of_chunk(width),
           std::move(dimensions));
    if (good && width > 0)
      good = write_text(all.back().data, "columns", joined(rows.columns.parameter_names)) &&
             write_text(all.back().data, "units", joined(rows.columns.parameter_units));
  });
  if (!good || !write_text(file, "columns", names)) all.clear();
  return all;
}

/// Writes all rows, those of datasets with rows in common side by side. A thread has the next chunks ready. Returns
/// false on failure.
bool write_columns(std::vector<Column>& columns, const SetRows& rows, bool compress) {
  std::vector<std::string> chunks(columns.size()), next(columns.size());
  const auto copy = [&](std::size_t c, std::uint64_t first, std::uint64_t count) {
    const std::string& name = columns[c].name;
    if (name != "tactel_x" && name != "tactel_y") return rows.copy(c, first, count, next[c].data());
    const std::vector<float>& places = name == "tactel_x" ? rows.columns.tactel_x : rows.columns.tactel_y;
    std::memcpy(next[c].data(), places.data() + first, count * sizeof(float));
    return true;
  };
  const auto count = [&](std::size_t c, std::uint64_t first) {
    return std::min(columns[c].rows_of_chunk, columns[c].rows - first);
  };
  const auto prepare = [&](std::size_t begin, std::size_t end, std::uint64_t first) {
    for (std::size_t c = begin; c < end; ++c) {
      next[c].resize(columns[c].rows_of_chunk * columns[c].row_bytes + sizeof(std::uint32_t));
      if (!copy(c, first, count(c, first))) return false;
      finish_chunk(columns[c], count(c, first), next[c]);
    }
    return true;
  };
  const auto with_rows = static_cast<std::size_t>(
      std::ranges::count(columns, "row", [](const Column& column) { return std::string_view(column.dimensions[0]); }));
  for (std::size_t begin = 0, end = with_rows; begin < columns.size(); begin = end, ++end) {
    const auto begin_at = [&](std::uint64_t first) {
      return std::async(std::launch::async, prepare, begin, end, first);
    };
    if (columns[begin].rows == 0) continue;
    std::future<bool> ready = begin_at(0);
    for (std::uint64_t first = 0, after; first < columns[begin].rows; first = after) {
      if (!ready.get()) return false;
      std::swap(chunks, next);
      after = first + columns[begin].rows_of_chunk;
      if (after < columns[begin].rows) ready = begin_at(after);
      for (std::size_t c = begin; c < end; ++c)
        if (!write_chunk(columns[c], first, count(c, first), chunks[c], compress)) return false;
    }
  }
  return true;
}

/// Attributes, then the seals of the datasets and of the file, which are closed. Returns false on failure.
bool finish_file(Handle& file, std::vector<Column>& columns, const ContactSet& set) {
  bool good = write_attributes(file, set) && write_dimensions(file, columns);
  for (Column& column : columns) {
    good = good && write_text(column.data, seal_name, dataset_seal(column.data, column.name, column.sum.text()));
    good = column.data.close() && good;
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

bool write_set_file(const std::filesystem::path& path, const SetRows& rows, const ContactSet& set, bool compress) {
  prepare_hdf5();
  DurableFile whole("--output", path);
  Handle file = create_file(whole.temporary());
  std::vector<Column> columns;
  if (file.open()) columns = create_columns(file, rows, compress);
  if (columns.empty() || !write_columns(columns, rows, compress) || !finish_file(file, columns, set)) return false;
  whole.commit();
  return true;
}

void write_contact_set(const std::filesystem::path& path, const ContactSet& set) {
  SetRows rows;
  rows.columns = set.columns(), rows.rows = set.rows();
  if (!rows.columns.parameter_names.empty())
    rows.contacts = set.parameters.size() / rows.columns.parameter_names.size();
  struct Dataset {
    std::string_view bytes;
    std::size_t row_bytes;
  };
  std::vector<Dataset> datasets;
  const auto add = [&](const char* name, const auto& values, int width, const char*) {
    if (rows.columns.has(name))
      datasets.push_back({{reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0])},
                          sizeof(values[0]) * static_cast<std::size_t>(std::max(width, 1))});
  };
  each_dataset(set, add);
  each_other_dataset(set, add);
  rows.copy = [&](std::size_t dataset, std::uint64_t first, std::uint64_t count, char* to) {
    const auto& [bytes, size] = datasets[dataset];
    if (bytes.size() < (first + count) * size) return false;
    std::memcpy(to, bytes.data() + first * size, count * size);
    return true;
  };
  if (!write_set_file(path, rows, set, set.plan.find("\ncompress yes\n") != std::string::npos))
    throw ConfigError("command line", "--output", path.string(),
                      "a file that can be written, on a disk with room for it");
}

}  // namespace tactel::host
