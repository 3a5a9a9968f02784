#include "host/contact_set.h"

#include <fmt/format.h>
#include <hdf5.h>
#include <unistd.h>

#include <functional>
#include <tuple>
#include <utility>

#include "host/errors.h"

namespace tactel::host {
namespace {

/// An HDF5 handle that closes itself.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() { close(); }
  Handle(Handle&& other) : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }
  bool open() const { return id_ >= 0; }
  /// False when the library could not close it: what it still held back is lost.
  bool close() { return id_ < 0 || close_(std::exchange(id_, H5I_INVALID_HID)) >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// HDF5 prints a stack of its own on every error; we say it in our words.
void silence_hdf5() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

template <class T>
hid_t type_of();
template <>
hid_t type_of<float>() {
  return H5T_IEEE_F32LE;
}
template <>
hid_t type_of<std::uint8_t>() {
  return H5T_STD_U8LE;
}
template <>
hid_t type_of<std::uint16_t>() {
  return H5T_STD_U16LE;
}
template <>
hid_t type_of<std::uint32_t>() {
  return H5T_STD_U32LE;
}
template <>
hid_t type_of<std::uint64_t>() {
  return H5T_STD_U64LE;
}

bool write_text(hid_t where, const char* name, const std::string& text) {
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
  H5Tset_size(type, text.size() + 1);
  H5Tset_cset(type, H5T_CSET_UTF8);
  const Handle attribute(H5Acreate2(where, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return attribute.open() && H5Awrite(attribute, type, text.c_str()) >= 0;
}

/// An empty dataset of its final size, its unit beside it.
template <class T>
bool create_dataset(hid_t file, const char* name, std::size_t rows, int columns, const char* unit) {
  const hsize_t extent[2] = {rows, static_cast<hsize_t>(columns)};
  const Handle space(H5Screate_simple(columns ? 2 : 1, extent, nullptr), H5Sclose);
  const Handle plain(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(plain, false);  // the same set gives the same bytes
  H5Pset_fill_time(plain, H5D_FILL_TIME_NEVER);
  const Handle data(H5Dcreate2(file, name, type_of<T>(), space, H5P_DEFAULT, plain, H5P_DEFAULT), H5Dclose);
  return data.open() && write_text(data, "unit", unit);
}

/// Rows `first` and on of a dataset.
template <class T>
bool write_rows(hid_t file, const char* name, std::size_t first, const std::vector<T>& values, int columns) {
  if (values.empty()) return true;
  const Handle data(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose);
  const Handle space(H5Dget_space(data), H5Sclose);
  const hsize_t start[2] = {first, 0};
  const hsize_t count[2] = {columns ? values.size() / columns : values.size(), static_cast<hsize_t>(columns)};
  const Handle memory(H5Screate_simple(columns ? 2 : 1, count, nullptr), H5Sclose);
  return data.open() && H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, nullptr) >= 0 &&
         H5Dwrite(data, type_of<T>(), memory, space, H5P_DEFAULT, values.data()) >= 0;
}

std::string joined(const std::vector<std::string>& names) { return fmt::format("{}", fmt::join(names, "\n")); }

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> names;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t end = std::min(text.find('\n', from), text.size());
    names.push_back(text.substr(from, end - from));
    from = end + 1;
  }
  return names;
}

bool write_attributes(hid_t file, const ContactSet& set) {
  return write_text(file, "tactel", TACTEL_VERSION) && write_text(file, "format", "tactel contact set 1") &&
         write_text(file, "sweep", set.sweep) && write_text(file, "seed", std::to_string(set.seed)) &&
         write_text(file, "device", set.device) && write_text(file, "rung", set.rung) &&
         write_text(file, "transducer", set.transducer) &&
         write_text(file, "fallback_contacts", std::to_string(set.fell_back)) &&
         write_text(file, "unsolved_contacts", std::to_string(set.unsolved)) &&
         write_text(file, "indenter_names", joined(set.indenter_names)) &&
         write_text(file, "units", "mm, MPa, N/mm; sigma_y < 0 is compression, tau_xy > 0 drags towards +x");
}

/// A new file whose bytes do not depend on the hour.
Handle create_file(const std::string& path) {
  const Handle plain(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  H5Pset_obj_track_times(plain, false);
  return Handle(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, plain, H5P_DEFAULT), H5Fclose);
}

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path)
      : path_(path), file_(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose) {
    if (!file_.open())
      refuse("(file)", std::filesystem::exists(path) ? "not HDF5, or damaged" : "not there",
             "an HDF5 file written by tactel generate");
    if (text("format") != "tactel contact set 1")
      refuse("format", text("format"), "tactel contact set 1: a file written by tactel generate");
  }

  std::string text(const char* name) const {
    const Handle attribute(H5Aopen(file_, name, H5P_DEFAULT), H5Aclose);
    if (!attribute.open()) return "";
    const Handle type(H5Aget_type(attribute), H5Tclose);
    std::string value(H5Tget_size(type), '\0');
    if (H5Aread(attribute, type, value.data()) < 0) return "";
    value.resize(std::char_traits<char>::length(value.c_str()));
    return value;
  }

  /// columns < 0: find out.
  template <class T>
  int read(const char* name, std::vector<T>& values, bool matrix) const {
    const Handle data(H5Dopen2(file_, name, H5P_DEFAULT), H5Dclose);
    if (!data.open()) refuse(name, "missing", "a dataset of the set");
    const Handle space(H5Dget_space(data), H5Sclose);
    hsize_t extent[2] = {0, 1};
    if (H5Sget_simple_extent_ndims(space) != (matrix ? 2 : 1))
      refuse(name, "of another rank", matrix ? "[rows, inputs]" : "[rows]");
    H5Sget_simple_extent_dims(space, extent, nullptr);
    values.resize(extent[0] * extent[1]);
    if (!values.empty() && H5Dread(data, type_of<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
      refuse(name, "unreadable", "numbers that can be read: the file is damaged");
    return static_cast<int>(extent[1]);
  }

  /// Rows first ... first + count - 1.
  template <class T>
  void read_rows(const char* name, std::vector<T>& values, int columns, std::uint64_t first,
                 std::uint64_t count) const {
    const Handle data(H5Dopen2(file_, name, H5P_DEFAULT), H5Dclose);
    if (!data.open()) refuse(name, "missing", "a dataset of the set");
    const Handle space(H5Dget_space(data), H5Sclose);
    const hsize_t start[2] = {first, 0}, size[2] = {count, static_cast<hsize_t>(columns)};
    const Handle memory(H5Screate_simple(columns ? 2 : 1, size, nullptr), H5Sclose);
    values.resize(count * std::max(columns, 1));
    if (H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, size, nullptr) < 0 ||
        H5Dread(data, type_of<T>(), memory, space, H5P_DEFAULT, values.data()) < 0)
      refuse(name, "unreadable", "numbers that can be read: the file is damaged");
  }

  /// [rows] or [rows, columns] of a dataset.
  std::pair<std::uint64_t, int> extent(const char* name) const {
    const Handle data(H5Dopen2(file_, name, H5P_DEFAULT), H5Dclose);
    if (!data.open()) refuse(name, "missing", "a dataset of the set");
    const Handle space(H5Dget_space(data), H5Sclose);
    hsize_t size[H5S_MAX_RANK] = {0, 0};
    H5Sget_simple_extent_dims(space, size, nullptr);
    return {size[0], static_cast<int>(size[1])};
  }

  [[noreturn]] void refuse(const std::string& key, const std::string& value, const std::string& allowed) const {
    throw ConfigError(path_.string(), key, value, allowed);
  }

 private:
  std::filesystem::path path_;
  Handle file_;
};

}  // namespace

nn::FrameSet ContactSet::frames_with_answers() const {
  nn::FrameSet out;
  out.frames = Eigen::Map<const nn::RowMatrix<float>>(frames.data(), static_cast<Eigen::Index>(rows()), inputs);
  out.slip_index = Eigen::Map<const nn::Vector<float>>(slip_index.data(), static_cast<Eigen::Index>(rows()));
  out.shape_class = indenter;
  out.contact_nodes.assign(contact_nodes.begin(), contact_nodes.end());
  return out;
}

struct ContactSetWriter::State {
  State(const std::filesystem::path& path)
      : path(path), temporary(fmt::format("{}.{}.part", path.string(), getpid())), file(create_file(temporary)) {}

  std::filesystem::path path;
  std::string temporary;
  Handle file;
  std::size_t written = 0;  ///< rows
  bool finished = false;
};

ContactSetWriter::ContactSetWriter(const std::filesystem::path& path, int inputs, std::size_t rows) {
  silence_hdf5();
  state_ = std::make_unique<State>(path);
  ContactSet nothing;
  nothing.inputs = inputs;
  bool good = state_->file.open();
  each_dataset(nothing, [&](const char* name, const auto& values, int columns, const char* unit) {
    using T = typename std::remove_cvref_t<decltype(values)>::value_type;
    good = good && create_dataset<T>(state_->file, name, rows, columns, unit);
  });
  if (!good) fail();
}

ContactSetWriter::~ContactSetWriter() {
  if (!state_ || state_->finished) return;
  std::error_code error;
  std::filesystem::remove(state_->temporary, error);
}

void ContactSetWriter::fail() const {
  std::error_code error;
  std::filesystem::remove(state_->temporary, error);
  throw ConfigError("command line", "--output", state_->path.string(),
                    "a file that can be written, on a disk with room for it");
}

void ContactSetWriter::append(const ContactSet& rows) {
  bool good = true;
  each_dataset(rows, [&](const char* name, const auto& values, int columns, const char*) {
    good = good && write_rows(state_->file, name, state_->written, values, columns);
  });
  if (!good) fail();
  state_->written += rows.rows();
}

void ContactSetWriter::finish(const ContactSet& set) {
  bool good = write_attributes(state_->file, set) && H5Fflush(state_->file, H5F_SCOPE_GLOBAL) >= 0;
  good = state_->file.close() && good;
  std::error_code error;
  if (good) std::filesystem::rename(state_->temporary, state_->path, error);
  if (!good || error) fail();
  state_->finished = true;
}

void write_contact_set(const std::filesystem::path& path, const ContactSet& set) {
  ContactSetWriter writer(path, set.inputs, set.rows());
  writer.append(set);
  writer.finish(set);
}

struct ContactSetReader::State {
  explicit State(const std::filesystem::path& path) : in(path) {
    std::tie(rows, inputs) = in.extent("inputs");
    ContactSet set;
    each_dataset(set, [&](const char* name, auto&, int, const char*) {
      if (in.extent(name).first != rows)
        in.refuse(name, fmt::format("{} rows", in.extent(name).first), fmt::format("{} rows, as inputs", rows));
    });
  }

  Reader in;
  std::uint64_t rows = 0;
  int inputs = 0;
};

ContactSetReader::ContactSetReader(const std::filesystem::path& path) {
  silence_hdf5();
  state_ = std::make_unique<State>(path);
}

ContactSetReader::~ContactSetReader() = default;
std::uint64_t ContactSetReader::rows() const { return state_->rows; }
int ContactSetReader::inputs() const { return state_->inputs; }

ContactSet ContactSetReader::read(std::uint64_t first, std::uint64_t count) const {
  ContactSet set;
  set.inputs = state_->inputs;
  set.indenter_names = split(state_->in.text("indenter_names"));
  each_dataset(set, [&](const char* name, auto& values, int columns, const char*) {
    state_->in.read_rows(name, values, columns, first, count);
  });
  return set;
}

std::string contact_set_sweep(const std::filesystem::path& path) {
  silence_hdf5();
  return Reader(path).text("sweep");
}

ContactSet read_contact_set(const std::filesystem::path& path) {
  silence_hdf5();
  const Reader in(path);
  ContactSet set;
  each_dataset(set, [&](const char* name, auto& values, int, const char*) {
    const int columns = in.read(name, values, std::string_view(name) == "inputs");
    if (std::string_view(name) == "inputs") set.inputs = columns;
  });
  each_dataset(set, [&](const char* name, auto& values, int columns, const char*) {
    const std::size_t rows = columns ? values.size() / columns : values.size();
    if (rows != set.rows())
      in.refuse(name, fmt::format("{} rows", rows), fmt::format("{} rows, as slip_index", set.rows()));
  });
  set.sweep = in.text("sweep");
  set.device = in.text("device");
  set.rung = in.text("rung");
  set.transducer = in.text("transducer");
  set.indenter_names = split(in.text("indenter_names"));
  const auto number = [&](const char* name) { return std::strtoull(in.text(name).c_str(), nullptr, 10); };
  set.seed = number("seed");
  set.fell_back = number("fallback_contacts");
  set.unsolved = number("unsolved_contacts");
  return set;
}

}  // namespace tactel::host
