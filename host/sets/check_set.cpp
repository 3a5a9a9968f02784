// SPDX-License-Identifier: Apache-2.0
#include "host/sets/check_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "host/sets/contact_set.h"
#include "host/sets/set_file.h"
#include "host/sets/set_seal.h"
#include "host/support/checksum.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

constexpr std::uint64_t rows_at_once = 8192;     ///< of a dataset without chunks
constexpr std::uint64_t most_bytes = 64u << 20;  ///< of one piece

std::uint64_t rows_of_piece(const SetFile::Column& column, std::size_t value_bytes) {
  const std::uint64_t fit = most_bytes / (value_bytes * static_cast<std::uint64_t>(std::max(column.columns, 1)));
  return std::clamp<std::uint64_t>(column.chunk_rows ? column.chunk_rows : rows_at_once, 1,
                                   std::max<std::uint64_t>(fit, 1));
}

class Checker {
 public:
  Checker(const std::filesystem::path& path, const Progress& progress)
      : in_(path), columns_(read_columns(path)), progress_(progress) {
    if (in_.text(seal_name).empty())
      in_.refuse(seal_name, "missing",
                 "that of the attributes: the set was edited, or another program wrote it; generate it anew");
  }

  SetCheck run() {
    ContactSet set(columns_);
    std::vector<Opened> columns;
    const auto open_one = [&](const char* name, const auto& values, int width, const char*) {
      columns.push_back(open(name, values, width > 0 || std::string_view(name) == "inputs"));
    };
    each_dataset(set, open_one);
    for (const Opened& column : columns)
      if (column.it) check_.rows = std::max(check_.rows, column.it->rows);
    std::vector<float> numbers;
    if (set.has("parameters")) open_one("parameters", numbers, 1, ""), columns.back().rows = in_.number("contacts");
    for (const char* name : {"tactel_x", "tactel_y"})
      if (set.has(name)) open_one(name, numbers, 0, ""), columns.back().rows = 0;
    for (const Opened& column : columns)
      if (column.it) all_ += (column.it->rows + column.piece - 1) / column.piece;
    std::size_t i = 0;
    each_dataset(set, [&](const char* name, auto& values, int, const char*) { check(name, columns[i++], values); });
    if (set.has("parameters")) check("parameters", columns[i++], numbers);
    for (const char* name : {"tactel_x", "tactel_y"})
      if (set.has(name)) check(name, columns[i++], numbers);
    if (in_.text(seal_name) != in_.seal())
      check_.damage.push_back({.what = "attributes, or names of datasets, other than those written"});
    return check_;
  }

 private:
  struct Opened {
    std::optional<SetFile::Column> it{};
    std::uint64_t piece = 1;              ///< rows read at once
    std::optional<std::uint64_t> rows{};  ///< at least; none: as many as the set
    std::string why_not{};
  };

  template <class T>
  Opened open(const char* name, const std::vector<T>&, bool matrix) try {
    Opened opened{in_.column<T>(name, matrix)};
    opened.piece = rows_of_piece(*opened.it, sizeof(T));
    return opened;
  } catch (const ConfigError& error) {
    return {.why_not = error.value};
  }

  template <class T>
  void check(const char* name, const Opened& opened, std::vector<T>& values) {
    const std::uint64_t rows = opened.rows.value_or(check_.rows);
    if (!opened.it) return note(name, 0, rows, opened.why_not);
    const SetFile::Column& column = *opened.it;
    if (column.rows < rows) note(name, column.rows, rows, "missing");
    RunningChecksum sum;
    bool whole = true;
    for (std::uint64_t first = 0; first < column.rows && check_.finished; first += opened.piece) {
      const std::uint64_t count = std::min(opened.piece, column.rows - first);
      if (read(column, first, count, values))
        sum.add({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
      else
        whole = false, note(name, first, first + count, "damaged");
      ++check_.chunks;
      check_.bytes += values.size() * sizeof(T);
      if (progress_ && !progress_(check_.chunks, all_)) check_.finished = false;
    }
    if (check_.finished && whole && !column.sealed(sum))
      note(name, 0, column.rows,
           column.copied ? "copied in another form (filter, width or byte order): its checksum cannot judge it"
                         : "other numbers, name or attributes than those written, or another order");
  }

  template <class T>
  bool read(const SetFile::Column& column, std::uint64_t first, std::uint64_t count, std::vector<T>& values) try {
    in_.read(column, first, count, values);
    return true;
  } catch (const ConfigError&) {
    return false;
  }

  /// Rows first ... end - 1; those behind a damage of the same kind join it.
  void note(const std::string& name, std::uint64_t first, std::uint64_t end, const std::string& what) {
    const std::uint64_t last = std::max<std::uint64_t>(end, 1) - 1;
    if (!check_.damage.empty()) {
      SetDamage& before = check_.damage.back();
      if (before.dataset == name && before.what == what && before.last + 1 == first) {
        before.last = last;
        return;
      }
    }
    check_.damage.push_back({name, first, last, what});
  }

  SetFile in_;
  SetColumns columns_;
  const Progress& progress_;
  std::size_t all_ = 0;  ///< pieces to read
  SetCheck check_;
};

}  // namespace

SetCheck check_contact_set(const std::filesystem::path& path, const Progress& progress) {
  return Checker(path, progress).run();
}

}  // namespace tactel::host
