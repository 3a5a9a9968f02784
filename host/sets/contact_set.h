// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/set_arrays.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "host/support/tables.h"
#include "nn/frame_set.h"

namespace tactel::host {

using tactel::SetArrays;

/// Which datasets a set has.
struct SetColumns {
  SetColumns(int inputs = 0, bool sensors = false, bool pad = false) : inputs(inputs), sensors(sensors), pad(pad) {}
  int inputs;              ///< 2 tactels; of a pad axes nx ny
  bool sensors;            ///< each contact has its own sensor: its numbers are columns, too
  bool pad;                ///< contacts on pads
  int axes = 2;            ///< stresses of a tactel; of a pad 3, or 1
  int marker_numbers = 0;  ///< 3 markers; 0: none
  int pixel_numbers = 0;   ///< 2 markers that a camera sees; 0: none
  std::vector<std::string> parameter_names, parameter_units;  ///< of `/parameters`, ContactParameters; or none
  std::vector<float> tactel_x;                                ///< [tactels] mm; empty where contacts differ in them
  std::vector<float> tactel_y;                                ///< [tactels] mm, of pads, whose x is the fastest
  std::set<std::string> left_out;                             ///< names of datasets that the set does not have

  bool slid_of_cells = false;  ///< of grips without /slip_path, whose /slid may be that, as it was before
  bool has(const char* dataset) const { return !left_out.contains(dataset); }
  /// Returns the directions along the surface.
  int directions() const { return pad ? 2 : 1; }
};

/// Status of a row whose contact extends over few of the elements or cells that are laid for the deepest
/// step: its forces are coarse.
inline constexpr int coarse_row = 3;

/// Numbers of contacts of a set; of them fell_back, unsolved and without_rows are attributes of its file.
struct SetCounts {
  std::uint64_t fell_back = 0;                              ///< solved by the exact fallback
  std::uint64_t unsolved = 0;                               ///< with a load step over tolerance
  std::uint64_t too_deep = 0;                               ///< indented beyond the depth to which rubber is linear
  std::uint64_t without_rows = 0;                           ///< without a row, because mu P = 0 in every step
  std::uint64_t far_slip = 0;                               ///< that slide beyond slip_limit
  std::uint64_t near_edge = 0, unseen = 0, wide_cells = 0;  ///< of outside_edges, outside_tactels, outside_cells
  std::uint64_t never_slid = 0;                             ///< with rows, whose drag until sliding ends without it
  std::uint64_t coarse = 0;                                 ///< rows, not contacts: marked as coarse_row

  SetCounts& operator+=(const SetCounts& more) {
    for (const auto count : {&SetCounts::fell_back, &SetCounts::unsolved, &SetCounts::too_deep,
                             &SetCounts::without_rows, &SetCounts::far_slip, &SetCounts::near_edge, &SetCounts::unseen,
                             &SetCounts::wide_cells, &SetCounts::never_slid, &SetCounts::coarse})
      this->*count += more.*count;
    return *this;
  }
};

/// A set of contacts as in a set file (docs/sets.md): one row a load step; HDF5, plain datasets.
struct ContactSet : SetColumns, SetCounts, SetArrays {
  ContactSet() = default;
  explicit ContactSet(const SetColumns& columns) : SetColumns(columns) {}

  std::string version;  ///< attribute `tactel`: of the program that wrote the file

  /// Returns which datasets a file of this set has: all but those left out and those of later versions that are empty.
  SetColumns columns() const;
  /// Returns the frames and answers for training and judging networks.
  nn::FrameSet frames_with_answers() const;
};

/// A row: what set_columns puts into the datasets with rows, but for the inputs. Of lines x alone counts.
struct SetRow {
  double slip_index = 0, P = 0;
  std::array<double, 2> Q{}, tangential{}, net_slip{};
  double M = 0, force_ratio = 0, slid = 0, slip_path = 0, net_turn = 0, slid_ahead = 0;
  double indentation = 0, twist = 0, friction = 0, stick_fraction = 0, residual = 0;
  int touching = 0, outside = 0, step = 0, kind = 0, status = 0;
  std::uint64_t contact = 0;
  double poisson = 0, thickness = 0, young = 0, length = 0;  ///< of the contact's sensor
};

/// A unit of pads that is that of lines.
inline constexpr const char* as_line = "as of lines";

/// A dataset with rows.
template <class Values, class Number>
struct SetColumn {
  const char* name;
  const char *line, *pad;  ///< unit of lines, of pads; null: their sets have none
  Values& value;
  Number number;            ///< member of SetRow; of SetColumns: as many numbers a row, none with 0; null: the inputs
  bool of_sensors = false;  ///< only where each contact has its own sensor

  static constexpr bool is_inputs = std::is_null_pointer_v<Number>;
  static constexpr bool is_counted = std::is_same_v<Number, int SetColumns::*>;
  static constexpr bool is_directed = std::is_same_v<Number, std::array<double, 2> SetRow::*>;
  /// Returns the numbers of a row: 1, or as many as the set has directions, inputs, or counts.
  int width(const SetColumns& set) const {
    if constexpr (is_counted) return set.*number;
    return is_inputs ? set.inputs : is_directed ? set.directions() : 1;
  }
  /// Puts a row into place `at`, where the set has this dataset.
  void put(std::size_t at, const SetRow& row, std::size_t directions) const {
    using To = typename Values::value_type;
    if (value.empty()) return;
    if constexpr (is_directed)
      for (std::size_t axis = 0; axis < directions; ++axis)
        value[directions * at + axis] = static_cast<To>((row.*number)[axis]);
    else if constexpr (!is_inputs && !is_counted)
      value[at] = static_cast<To>(row.*number);
  }
};
template <class Values, class Number, class... More>
SetColumn(const char*, const char*, const char*, Values&, Number, More...) -> SetColumn<Values, Number>;

/// Returns the datasets with rows of a set, in their order: of a ContactSet, or of the public Set, whose arrays have
/// the same names.
template <class Set>
auto set_columns(Set& set) {
  using Row = SetRow;
  return std::tuple{
      SetColumn{"inputs", "MPa; normal stress of every tactel, then shear",
                "MPa; sigma_z of every tactel, x fastest, then tau_x, then tau_y", set.frames, nullptr},
      SetColumn{"markers", nullptr, "mm; displacement along x, y, z of every marker", set.markers,
                &SetColumns::marker_numbers},
      SetColumn{"pixels", nullptr, "pixels; where the camera sees every marker, x and y, with its noise", set.pixels,
                &SetColumns::pixel_numbers},
      SetColumn{"slip_index", "1; Q / (mu P)", "1; 1 / lambda, the share of the contact's limit that (Q, M) take",
                set.slip_index, &Row::slip_index},
      SetColumn{"normal_force", "N/mm", "N", set.normal_force, &Row::P},
      SetColumn{"tangential_force", "N/mm", "N; along x and y", set.tangential_force, &Row::Q},
      SetColumn{"torque", nullptr, "N mm; about the indenter's axis", set.torque, &Row::M},
      SetColumn{"force_ratio", nullptr, "1; |Q| / (mu P)", set.force_ratio, &Row::force_ratio},
      SetColumn{"slid", nullptr, "1; slide of the contact as a whole since first touch over its elastic limit",
                set.slid, &Row::slid},
      SetColumn{"slip_path", nullptr, "1; rms slips of the cells that touch since first touch, summed, over that limit",
                set.slip_path, &Row::slip_path},
      SetColumn{"net_slip", nullptr,
                "1; mean slips of the cells that touch since first touch, x and y, over that limit", set.net_slip,
                &Row::net_slip},
      SetColumn{"net_turn", nullptr, "1; their turn times the contact's rms radius, over that limit", set.net_turn,
                &Row::net_turn},
      SetColumn{"slid_ahead", nullptr, "1; how far slid grows in the next 0.2 s; NaN where the grip ends before",
                set.slid_ahead, &Row::slid_ahead},
      SetColumn{"indentation", "mm; depth of the indenter since first touch", as_line, set.indentation,
                &Row::indentation},
      SetColumn{"tangential", "mm; position of the indenter along x since first touch",
                "mm; position of the indenter along x and y since first touch", set.tangential, &Row::tangential},
      SetColumn{"twist", nullptr, "degrees; of the indenter about its axis since first touch", set.twist, &Row::twist},
      SetColumn{"friction", "1", as_line, set.friction, &Row::friction},
      SetColumn{"stick_fraction", "1; stuck length over contact length", "1; stuck cells over touching cells",
                set.stick_fraction, &Row::stick_fraction},
      SetColumn{"contact_nodes", "surface nodes that touch", "surface cells that touch", set.contact_nodes,
                &Row::touching},
      SetColumn{"outside", nullptr, "1 at an edge, 2 far from tactels, 4 cells wider than the thickness; their sum",
                set.outside, &Row::outside},
      SetColumn{"contact", "which contact", as_line, set.contact, &Row::contact},
      SetColumn{"step", "which load step of the contact", as_line, set.step, &Row::step},
      SetColumn{"indenter", "place in the attribute indenter_names", as_line, set.indenter, &Row::kind},
      SetColumn{"status", "0 solved, 1 sliding, 2 over tolerance, 3 few elements or cells touch", as_line, set.status,
                &Row::status},
      SetColumn{"residual", "1; largest relative residual", as_line, set.residual, &Row::residual},
      SetColumn{"poisson", "1; of the contact's own sensor", as_line, set.poisson, &Row::poisson, true},
      SetColumn{"thickness", "mm; of the contact's own sensor", as_line, set.thickness, &Row::thickness, true},
      SetColumn{"young", "MPa; of the contact's own sensor", as_line, set.young, &Row::young, true},
      SetColumn{"length", "mm; of the contact's own sensor", nullptr, set.length, &Row::length, true}};
}

/// Calls visit(name, values, columns, unit) for every dataset with rows of the kind of a set, also those that it leaves
/// out; columns 0: a plain list.
template <class Set, class Visit>
void each_column(Set& set, const Visit& visit) {
  each(set_columns(set), [&](const auto& column) {
    const char* const unit = set.pad && column.pad != as_line ? column.pad : column.line;
    if (unit == nullptr || (column.of_sensors && !set.sensors) || (column.is_counted && column.width(set) == 0)) return;
    const bool list = !column.is_inputs && column.width(set) == 1;
    visit(column.name, column.value, list ? 0 : column.width(set), unit);
  });
}
/// The same of those that it has.
template <class Set, class Visit>
void each_dataset(Set& set, const Visit& visit) {
  each_column(set, [&](const char* name, auto& values, int columns, const char* unit) {
    if (set.has(name)) visit(name, values, columns, unit);
  });
}

/// The same for the datasets of a set that have no rows: a row a contact, and one a tactel.
template <class Set, class Visit>
void each_other_dataset(Set& set, const Visit& visit) {
  if (set.has("parameters") && !set.parameter_names.empty())
    visit("parameters", set.parameters, static_cast<int>(set.parameter_names.size()),
          "one row a contact; attributes columns and units");
  if (set.has("tactel_x") && !set.tactel_x.empty()) visit("tactel_x", set.tactel_x, 0, "mm");
  if (set.has("tactel_y") && !set.tactel_y.empty()) visit("tactel_y", set.tactel_y, 0, "mm");
}

/// Returns which datasets a set file has; inputs and tactel_x are not read. Throws as read_contact_set.
SetColumns read_columns(const std::filesystem::path& path);
/// Returns the bytes of a row in all datasets.
std::uint64_t row_bytes(const SetColumns& columns);
/// Returns the bytes of this machine's memory.
double memory_bytes();
/// Throws ConfigError naming `file` and the first of `needed` that the set has not.
void require_datasets(const SetColumns& columns, const std::string& file, std::initializer_list<const char*> needed);
/// Returns the columns without the datasets that `wanted` does not name: a list of names, separated by commas. Throws
/// ConfigError naming --columns for a name that is none. `/slip_index` stays in any case: it counts the rows.
SetColumns only_columns(SetColumns columns, const std::string& wanted);

/// Returns the rows of a chunk of a dataset with so many columns; all datasets with rows share that of the widest.
std::uint64_t rows_of_chunk(int columns);

/// The rows of a set, wherever they are.
struct SetRows {
  SetColumns columns;
  std::uint64_t rows = 0, contacts = 0;  ///< contacts: rows of `/parameters`
  /// Copies rows first ... first + count - 1 of a dataset; they are counted in the order of each_dataset, `/parameters`
  /// behind them. Returns false where they cannot be read.
  std::function<bool(std::size_t dataset, std::uint64_t first, std::uint64_t count, char* to)> copy;
};

/// Writes a set file as a DurableFile, with the attributes of `set`, whose rows are ignored. Every chunk of the file
/// has a checksum (Fletcher32), and so have every dataset and the file itself (attribute `checksum`, set_seal.h).
/// `compress`: by HDF5's shuffle and gzip, slowly. Returns false where rows cannot be read or the file cannot be
/// written, and then leaves none behind.
bool write_set_file(const std::filesystem::path& path, const SetRows& rows, const ContactSet& set, bool compress);

/// Writes a whole set at once. Throws ConfigError naming --output where the file cannot be written.
void write_contact_set(const std::filesystem::path& path, const ContactSet& set);

/// Reads parts of a set file. Throws ConfigError as read_contact_set.
class ContactSetReader {
 public:
  explicit ContactSetReader(const std::filesystem::path& path, const char* without = "");
  ~ContactSetReader();
  std::uint64_t rows() const;
  const SetColumns& columns() const;
  /// Returns rows first ... first + count - 1, which must exist; of the attributes, indenter_names and
  /// press_rows.
  ContactSet read(std::uint64_t first, std::uint64_t count) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Reads a whole set but for the dataset `without`. Throws ConfigError where the file cannot be read, is not a set, is
/// damaged, has datasets of the wrong rank, type or extent, or exceeds the memory of the machine.
ContactSet read_contact_set(const std::filesystem::path& path, const char* without = "");
/// Returns the text of the sweep file of a set. Throws as read_contact_set.
std::string contact_set_sweep(const std::filesystem::path& path);

/// Returns the attributes of a set, without its rows. Throws as read_contact_set.
ContactSet read_attributes(const std::filesystem::path& path);

}  // namespace tactel::host
