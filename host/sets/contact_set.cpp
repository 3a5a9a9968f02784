// SPDX-License-Identifier: Apache-2.0
#include "host/sets/contact_set.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <new>
#include <optional>
#include <stdexcept>

#include "host/sets/set_file.h"
#include "host/support/errors.h"
#include "host/support/nearest_word.h"

namespace tactel::host {
namespace {

template <class Values>
using Value = typename std::remove_cvref_t<Values>::value_type;

/// Whether a dataset has columns; those of the inputs are not known before they are read.
bool is_matrix(const char* name, int columns) { return columns > 0 || std::string_view(name) == "inputs"; }

void read_kind(const SetFile& in, SetColumns& columns) {
  const std::string kind = in.text("kind");
  if (!kind.empty() && kind != "pad") in.refuse("kind", kind, "pad, or absent");
  columns.pad = !kind.empty();
  if (!columns.pad) return;
  const std::uint64_t axes = in.number("axes");
  if (axes != 1 && axes != 3) in.refuse("axes", std::to_string(axes), "3, or 1");
  columns.axes = static_cast<int>(axes);
}

bool read_press_rows(const SetFile& in) {
  const std::string text = in.text("press_rows");
  if (!text.empty() && text != "true") in.refuse("press_rows", text, "true, or absent");
  return !text.empty();
}

constexpr std::uint8_t over_tolerance = 2;  ///< LaneStatus

/// The datasets that the file names. Throws where one of them is missing.
SetColumns columns_of(const SetFile& in) {
  const std::vector<std::string> names = in.texts("columns");
  const std::set<std::string> has(names.begin(), names.end());
  if (!has.contains("slip_index"))
    in.refuse("columns", names.empty() ? "missing" : "without slip_index", "names of datasets, slip_index among them");
  SetColumns columns;
  read_kind(in, columns);
  for (const char* name : {"poisson", "thickness", "young", "length"})
    columns.sensors = columns.sensors || has.contains(name);
  const auto leave_out = [&](const char* name, const auto&, int, const char*) {
    if (!has.contains(name)) columns.left_out.insert(name);
  };
  const auto read_width = [&](const char* name, int each, int& numbers) {
    if (columns.pad && has.contains(name)) numbers = in.column<float>(name, true).columns;
    if (numbers % each != 0)
      in.refuse(name, fmt::format("{} columns", numbers), fmt::format("{} for each marker", each));
  };
  read_width("markers", 3, columns.marker_numbers);
  read_width("pixels", 2, columns.pixel_numbers);
  const ContactSet all(columns);
  each_dataset(all, leave_out);
  for (const char* name : {"parameters", "tactel_x", "tactel_y"}) leave_out(name, 0, 0, "");
  columns.slid_of_cells = !has.contains("slip_path") && in.text("sweep").find("[load.hold]") != std::string::npos;
  if (columns.has("parameters")) {
    columns.parameter_names = in.texts("parameters", "columns");
    columns.parameter_units = in.texts("parameters", "units");
    if (columns.parameter_names.empty() || columns.parameter_names.size() != columns.parameter_units.size())
      in.refuse("parameters",
                fmt::format("{} columns, {} units", columns.parameter_names.size(), columns.parameter_units.size()),
                "a name and a unit for each column");
  }
  return columns;
}

void read_attributes(const SetFile& in, ContactSet& set) {
  set.version = in.text("tactel");
  set.sweep = in.text("sweep");
  set.device = in.text("device");
  set.rung = in.text("rung");
  set.transducer = in.text("transducer");
  set.plan = in.text("plan");
  set.indenter_names = in.texts("indenter_names");
  set.press_rows = read_press_rows(in);
  set.seed = in.number("seed");
  set.fell_back = in.number("fallback_contacts");
  set.unsolved = in.number("unsolved_contacts");
  set.contacts = in.number("contacts");
  set.without_rows = in.number("contacts_without_rows");
}

/// Every dataset of a set file, open, with as many rows as slip_index.
struct Columns {
  Columns(const SetFile& in, const char* without) : of(columns_of(in)) {
    of.left_out.insert(without);
    if (*without != 0) of.left_out.insert("pixels");  // networks read none
    ContactSet set(of);
    rows = in.column<float>("slip_index", false).rows;
    each_dataset(set, [&](const char* name, auto& values, int width, const char*) {
      all.push_back(in.column<Value<decltype(values)>>(name, is_matrix(name, width)));
      if (width > 0 && all.back().columns != width)
        in.refuse(name, fmt::format("{} columns", all.back().columns), fmt::format("{} columns", width));
      if (all.back().rows != rows)
        in.refuse(name, fmt::format("{} rows", all.back().rows), fmt::format("{} rows, as slip_index", rows));
      if (std::string_view(name) != "inputs") return;
      of.inputs = all.back().columns;
      if (of.inputs % of.axes != 0)
        in.refuse(name, fmt::format("{} columns", of.inputs), fmt::format("{} for each tactel", of.axes));
    });
    if (of.has("tactel_x")) of.tactel_x = tactels(in, "tactel_x");
    if (of.has("tactel_y")) of.tactel_y = tactels(in, "tactel_y");
    if (of.has("parameters")) open_parameters(in);
  }

  /// Places of the tactels, finite; of lines increasing.
  std::vector<float> tactels(const SetFile& in, const char* name) const {
    const SetFile::Column column = in.column<float>(name, false);
    const auto axes = static_cast<std::uint64_t>(of.axes);
    if (column.rows < (of.pad ? 1 : 2) || column.rows > SetFile::most_columns ||
        (of.has("inputs") && axes * column.rows != static_cast<std::uint64_t>(of.inputs)))
      in.refuse(name, fmt::format("{} numbers", column.rows),
                of.pad ? fmt::format("one a tactel, of which inputs has {} columns", axes)
                       : "one a tactel: half as many as inputs has columns");
    std::vector<float> x;
    in.read(column, 0, column.rows, x);
    for (std::size_t i = 0; i < x.size(); ++i)
      if (!std::isfinite(x[i]) || (!of.pad && i > 0 && !(x[i] > x[i - 1])))
        in.refuse(name, fmt::format("{}", x[i]),
                  of.pad ? "places in mm, finite" : "places in mm, finite and increasing");
    return x;
  }
  void open_parameters(const SetFile& in) {
    parameters.emplace(in.column<float>("parameters", true));
    if (static_cast<std::size_t>(parameters->columns) != of.parameter_names.size())
      in.refuse("parameters", fmt::format("{} columns", parameters->columns),
                fmt::format("{}, one for each name of its attribute columns", of.parameter_names.size()));
    if (parameters->rows != in.number("contacts"))
      in.refuse("parameters", fmt::format("{} rows", parameters->rows),
                fmt::format("{}, the attribute contacts", in.number("contacts")));
  }

  ContactSet read(const SetFile& in, std::uint64_t first, std::uint64_t count) const {
    ContactSet set(of);
    std::size_t i = 0;
    each_dataset(set, [&](const char*, auto& values, int, const char*) { in.read(all[i++], first, count, values); });
    for (const auto& [name, values] : {std::pair("indentation", &set.indentation), {"tangential", &set.tangential}})
      for (std::size_t i = 0; i < values->size(); ++i) {
        const std::size_t row = values == &set.tangential ? i / static_cast<std::size_t>(of.directions()) : i;
        if (!std::isfinite((*values)[i]) && row < set.status.size() && set.status[row] != over_tolerance)
          in.refuse(fmt::format("{}[{}]", name, first + row), fmt::format("{}", (*values)[i]), "finite, mm");
      }
    return set;
  }
  /// NaN: the contact has no such number. Friction may be unlimited.
  void read_parameters(const SetFile& in, ContactSet& set) const {
    if (!parameters) return;
    in.read(*parameters, 0, parameters->rows, set.parameters);
    const std::size_t columns = of.parameter_names.size();
    for (std::size_t i = 0; i < set.parameters.size(); ++i)
      if (std::isinf(set.parameters[i]) && of.parameter_names[i % columns] != "contact.friction")
        in.refuse(fmt::format("parameters[{}]", i / columns), "infinity", "finite numbers, or NaN where there is none");
  }

  SetColumns of;
  std::uint64_t rows = 0;
  std::vector<SetFile::Column> all;  ///< in the order of each_dataset
  std::optional<SetFile::Column> parameters;
};

/// Throws where so many rows do not fit into memory, before any is allocated.
void check_memory(const SetFile& in, std::uint64_t rows, const SetColumns& columns, std::uint64_t contacts = 0) {
  const double of_contacts = static_cast<double>(contacts) * static_cast<double>(columns.parameter_names.size());
  const double bytes =
      static_cast<double>(rows) * static_cast<double>(row_bytes(columns)) + sizeof(float) * of_contacts;
  if (const double memory = memory_bytes(); bytes > memory)
    in.refuse(
        "inputs", fmt::format("{} rows, {:.3g} GB", rows, 1e-9 * bytes),
        fmt::format("fewer rows than fit into memory ({:.3g} GB), or read in pieces (train --block)", 1e-9 * memory));
}

/// Turns a failed allocation into the error of the file that requires it.
template <class Read>
auto within_memory(const SetFile& in, const Read& read) try {
  return read();
} catch (const std::bad_alloc&) {
  in.refuse("inputs", "too many rows", "fewer rows than fit into memory");
} catch (const std::length_error&) {
  in.refuse("inputs", "too many rows", "fewer rows than fit into memory");
}

}  // namespace

double memory_bytes() {
  return static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

std::uint64_t row_bytes(const SetColumns& columns) {
  std::uint64_t bytes = 0;
  const ContactSet set(columns);
  each_dataset(set, [&](const char*, auto& values, int width, const char*) {
    bytes += sizeof(Value<decltype(values)>) * static_cast<std::uint64_t>(width ? width : 1);
  });
  return bytes;
}

void require_datasets(const SetColumns& columns, const std::string& file, std::initializer_list<const char*> needed) {
  for (const char* name : needed)
    if (!columns.has(name))
      throw ConfigError(file, name, "missing", "a dataset of the set: generate it with this name among --columns");
}

SetColumns only_columns(SetColumns columns, const std::string& wanted) {
  std::vector<std::string> names;
  const ContactSet set(columns);
  const auto know = [&](const char* name, const auto&, int, const char*) { names.emplace_back(name); };
  each_dataset(set, know);
  each_other_dataset(set, know);
  std::set<std::string> kept = {"slip_index"};
  for (std::size_t from = 0; from <= wanted.size();) {
    const std::size_t end = std::min(wanted.find(',', from), wanted.size());
    const std::string name = wanted.substr(from, end - from);
    if (std::ranges::find(names, name) == names.end())
      throw ConfigError("command line", "--columns", name, "of " + listed(names) + did_you_mean(name, names));
    kept.insert(name);
    from = end + 1;
  }
  for (const std::string& name : names)
    if (!kept.contains(name)) columns.left_out.insert(name);
  return columns;
}

SetColumns ContactSet::columns() const {
  SetColumns columns = *this;
  if (rows() > 0 && indentation.empty()) columns.left_out.insert("indentation");
  if (rows() > 0 && tangential.empty()) columns.left_out.insert("tangential");
  if (parameters.empty()) columns.parameter_names.clear(), columns.parameter_units.clear();
  return columns;
}

nn::FrameSet ContactSet::frames_with_answers() const {
  nn::FrameSet out;
  out.frames = Eigen::Map<const nn::RowMatrix<float>>(frames.data(), static_cast<Eigen::Index>(rows()), inputs);
  out.slip_index = Eigen::Map<const nn::Vector<float>>(slip_index.data(), static_cast<Eigen::Index>(rows()));
  out.shape_class = indenter;
  out.contact_nodes.assign(contact_nodes.begin(), contact_nodes.end());
  out.contact = contact, out.step = step;
  out.press_rows = press_rows;
  out.axes = axes;
  return out;
}

struct ContactSetReader::State {
  State(const std::filesystem::path& path, const char* without) : in(path), columns(in, without) {}
  SetFile in;
  Columns columns;
};

ContactSetReader::ContactSetReader(const std::filesystem::path& path, const char* without)
    : state_(std::make_unique<State>(path, without)) {}
ContactSetReader::~ContactSetReader() = default;
std::uint64_t ContactSetReader::rows() const { return state_->columns.rows; }
const SetColumns& ContactSetReader::columns() const { return state_->columns.of; }

ContactSet ContactSetReader::read(std::uint64_t first, std::uint64_t count) const {
  check_memory(state_->in, count, columns());
  ContactSet set = within_memory(state_->in, [&] { return state_->columns.read(state_->in, first, count); });
  set.indenter_names = state_->in.texts("indenter_names");
  set.press_rows = read_press_rows(state_->in);
  return set;
}

SetColumns read_columns(const std::filesystem::path& path) { return columns_of(SetFile(path)); }

std::string contact_set_sweep(const std::filesystem::path& path) { return SetFile(path).text("sweep"); }

ContactSet read_attributes(const std::filesystem::path& path) {
  ContactSet set;
  read_attributes(SetFile(path), set);
  return set;
}

ContactSet read_contact_set(const std::filesystem::path& path, const char* without) {
  const SetFile in(path);
  const Columns columns(in, without);
  check_memory(in, columns.rows, columns.of, columns.parameters ? columns.parameters->rows : 0);
  ContactSet set = within_memory(in, [&] {
    ContactSet rows = columns.read(in, 0, columns.rows);
    columns.read_parameters(in, rows);
    return rows;
  });
  read_attributes(in, set);
  return set;
}

}  // namespace tactel::host
