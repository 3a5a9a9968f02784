#include "host/contact_set.h"

#include <fmt/format.h>
#include <hdf5.h>
#include <unistd.h>

#include <functional>
#include <utility>

#include "host/errors.h"

namespace tactel::host {
namespace {

/// An HDF5 handle that closes itself.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }
  bool open() const { return id_ >= 0; }

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

/// Calls visit(name, values, columns, unit) for every dataset; columns 0: a plain list.
template <class Set, class Visit>
void each_dataset(Set& set, const Visit& visit) {
  visit("inputs", set.frames, set.inputs, "MPa; normal stress of every tactel, then shear");
  visit("slip_index", set.slip_index, 0, "1; Q / (mu P)");
  visit("normal_force", set.normal_force, 0, "N/mm");
  visit("tangential_force", set.tangential_force, 0, "N/mm");
  visit("friction", set.friction, 0, "1");
  visit("stick_fraction", set.stick_fraction, 0, "1; stuck length over contact length");
  visit("contact_nodes", set.contact_nodes, 0, "surface nodes that touch");
  visit("contact", set.contact, 0, "which contact");
  visit("step", set.step, 0, "which load step of the contact");
  visit("indenter", set.indenter, 0, "place in the attribute indenter_names");
  visit("status", set.status, 0, "0 solved, 1 sliding, 2 over tolerance");
  visit("residual", set.residual, 0, "1; largest relative residual");
}

bool write_text(hid_t where, const char* name, const std::string& text) {
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
  H5Tset_size(type, text.size() + 1);
  H5Tset_cset(type, H5T_CSET_UTF8);
  const Handle attribute(H5Acreate2(where, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return attribute.open() && H5Awrite(attribute, type, text.c_str()) >= 0;
}

template <class T>
bool write_values(hid_t file, const char* name, const std::vector<T>& values, int columns, const char* unit) {
  const hsize_t extent[2] = {columns ? values.size() / columns : values.size(), static_cast<hsize_t>(columns)};
  const Handle space(H5Screate_simple(columns ? 2 : 1, extent, nullptr), H5Sclose);
  const Handle plain(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(plain, false);  // the same set gives the same bytes
  const Handle data(H5Dcreate2(file, name, type_of<T>(), space, H5P_DEFAULT, plain, H5P_DEFAULT), H5Dclose);
  return data.open() &&
         (values.empty() || H5Dwrite(data, type_of<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0) &&
         write_text(data, "unit", unit);
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

bool write_all(const std::string& path, const ContactSet& set) {
  const Handle plain(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  H5Pset_obj_track_times(plain, false);
  const Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, plain, H5P_DEFAULT), H5Fclose);
  bool good = file.open();
  each_dataset(set, [&](const char* name, const auto& values, int columns, const char* unit) {
    good = good && write_values(file, name, values, columns, unit);
  });
  good = good && write_text(file, "tactel", TACTEL_VERSION) && write_text(file, "format", "tactel contact set 1") &&
         write_text(file, "sweep", set.sweep) && write_text(file, "seed", std::to_string(set.seed)) &&
         write_text(file, "fallback_contacts", std::to_string(set.fell_back)) &&
         write_text(file, "unsolved_contacts", std::to_string(set.unsolved)) &&
         write_text(file, "device", set.device) && write_text(file, "rung", set.rung) &&
         write_text(file, "indenter_names", joined(set.indenter_names)) &&
         write_text(file, "units", "mm, MPa, N/mm; sigma_y < 0 is compression, tau_xy > 0 drags towards +x");
  return good && H5Fflush(file, H5F_SCOPE_GLOBAL) >= 0;
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

void write_contact_set(const std::filesystem::path& path, const ContactSet& set) {
  silence_hdf5();
  const std::string temporary = fmt::format("{}.{}.part", path.string(), getpid());
  std::error_code error;
  const bool good = write_all(temporary, set);
  if (good) std::filesystem::rename(temporary, path, error);
  if (good && !error) return;
  std::filesystem::remove(temporary, error);
  throw ConfigError("command line", "--output", path.string(),
                    "a file that can be written, on a disk with room for it");
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
  set.indenter_names = split(in.text("indenter_names"));
  const auto number = [&](const char* name) { return std::strtoull(in.text(name).c_str(), nullptr, 10); };
  set.seed = number("seed");
  set.fell_back = number("fallback_contacts");
  set.unsolved = number("unsolved_contacts");
  return set;
}

}  // namespace tactel::host
