// SPDX-License-Identifier: Apache-2.0
#include "host/sets/contact_set.h"

#include <fmt/format.h>
#include <unistd.h>

#include <new>
#include <optional>
#include <stdexcept>

#include "host/sets/set_file.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

template <class Values>
using Value = typename std::remove_cvref_t<Values>::value_type;

bool is_matrix(const char* name) { return std::string_view(name) == "inputs"; }

bool read_press_rows(const SetFile& in) {
  const std::string text = in.text("press_rows");
  if (!text.empty() && text != "true") in.refuse("press_rows", text, "true, or absent");
  return !text.empty();
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

/// Every dataset of a set file, open, with as many rows as the first.
struct Columns {
  explicit Columns(const SetFile& in) : sensors(in.has_dataset("poisson")) {
    ContactSet set(SetColumns(0, sensors));
    each_dataset(set, [&](const char* name, auto& values, int, const char*) {
      all.push_back(in.column<Value<decltype(values)>>(name, is_matrix(name)));
      if (all.back().rows != rows())
        in.refuse(name, fmt::format("{} rows", all.back().rows), fmt::format("{} rows, as inputs", rows()));
    });
  }
  std::uint64_t rows() const { return all.front().rows; }
  int inputs() const { return all.front().columns; }

  ContactSet read(const SetFile& in, std::uint64_t first, std::uint64_t count) const {
    ContactSet set(SetColumns(inputs(), sensors));
    std::size_t i = 0;
    each_dataset(set, [&](const char*, auto& values, int, const char*) { in.read(all[i++], first, count, values); });
    return set;
  }

  bool sensors;
  std::vector<SetFile::Column> all;  ///< in the order of each_dataset, which begins with inputs
};

/// Throws where so many rows do not fit into memory, before any is allocated.
void check_memory(const SetFile& in, std::uint64_t rows, const SetColumns& columns) {
  const double bytes = static_cast<double>(rows) * static_cast<double>(row_bytes(columns));
  const double memory = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  if (bytes > memory)
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

std::uint64_t row_bytes(const SetColumns& columns) {
  std::uint64_t bytes = 0;
  const ContactSet set(columns);
  each_dataset(set, [&](const char*, auto& values, int width, const char*) {
    bytes += sizeof(Value<decltype(values)>) * static_cast<std::uint64_t>(width ? width : 1);
  });
  return bytes;
}

nn::FrameSet ContactSet::frames_with_answers() const {
  nn::FrameSet out;
  out.frames = Eigen::Map<const nn::RowMatrix<float>>(frames.data(), static_cast<Eigen::Index>(rows()), inputs);
  out.slip_index = Eigen::Map<const nn::Vector<float>>(slip_index.data(), static_cast<Eigen::Index>(rows()));
  out.shape_class = indenter;
  out.contact_nodes.assign(contact_nodes.begin(), contact_nodes.end());
  out.contact = contact, out.step = step;
  out.press_rows = press_rows;
  return out;
}

struct ContactSetReader::State {
  explicit State(const std::filesystem::path& path) : in(path), columns(in) {}
  SetFile in;
  Columns columns;
};

ContactSetReader::ContactSetReader(const std::filesystem::path& path) : state_(std::make_unique<State>(path)) {}
ContactSetReader::~ContactSetReader() = default;
std::uint64_t ContactSetReader::rows() const { return state_->columns.rows(); }
int ContactSetReader::inputs() const { return state_->columns.inputs(); }

ContactSet ContactSetReader::read(std::uint64_t first, std::uint64_t count) const {
  check_memory(state_->in, count, {inputs(), state_->columns.sensors});
  ContactSet set = within_memory(state_->in, [&] { return state_->columns.read(state_->in, first, count); });
  set.indenter_names = state_->in.texts("indenter_names");
  set.press_rows = read_press_rows(state_->in);
  return set;
}

std::string contact_set_sweep(const std::filesystem::path& path) { return SetFile(path).text("sweep"); }

ContactSet read_attributes(const std::filesystem::path& path) {
  ContactSet set;
  read_attributes(SetFile(path), set);
  return set;
}

ContactSet read_contact_set(const std::filesystem::path& path) {
  const SetFile in(path);
  const Columns columns(in);
  check_memory(in, columns.rows(), {columns.inputs(), columns.sensors});
  ContactSet set = within_memory(in, [&] { return columns.read(in, 0, columns.rows()); });
  read_attributes(in, set);
  return set;
}

}  // namespace tactel::host
