// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <type_traits>
#include <vector>

#include "host/sets/hdf5_handle.h"
#include "host/support/checksum.h"

namespace tactel::host {

/// A set file open for reading. Rank, type and extent of every dataset and attribute are checked before its numbers
/// are read. Members throw ConfigError: file, dataset or attribute, the problem and the allowed values.
class SetFile {
 public:
  static constexpr std::uint64_t most_columns = 1 << 16;
  explicit SetFile(const std::filesystem::path& path);

  bool has(const char* attribute) const { return H5Aexists(file_, attribute) > 0; }
  /// Returns a text attribute, of fixed or variable length; empty where it is absent.
  std::string text(const char* attribute) const;
  /// Returns an attribute of texts: a list of them, or one text with a line each.
  std::vector<std::string> texts(const char* attribute) const;
  /// The same of a dataset; empty where either is absent.
  std::vector<std::string> texts(const char* dataset, const char* attribute) const;
  /// Returns an attribute that is a whole number, or its digits; 0 where it is absent.
  std::uint64_t number(const char* attribute) const;

  /// Returns the seal of the file (file_seal), as it is now.
  std::string seal() const;

  /// Returns true where there is a dataset of this name.
  bool has_dataset(const char* name) const;

  /// A dataset whose rank and type have been checked.
  class Column {
   public:
    std::uint64_t rows = 0;
    int columns = 0;               ///< 0: a plain list
    std::uint64_t chunk_rows = 0;  ///< 0: stored in one piece
    bool copied = false;           ///< packed, or of another width or byte order than tactel writes
    /// Returns whether the dataset has its seal (dataset_seal), with these numbers.
    bool sealed(const RunningChecksum& numbers) const;

   private:
    friend class SetFile;
    Column(std::string name, Handle data) : name_(std::move(name)), data_(std::move(data)) {}
    std::string name_;
    Handle data_;
    std::string seal_;   ///< empty where it has none
    int fletcher_ = -1;  ///< place of Fletcher32 among the filters; -1: it has none
  };
  template <class T>
  Column column(const char* name, bool matrix) const {
    return column(name, matrix, std::is_floating_point_v<T>);
  }
  /// Returns rows first ... first + count - 1, which must exist. Throws where a chunk of them is damaged or
  /// missing.
  template <class T>
  void read(const Column& column, std::uint64_t first, std::uint64_t count, std::vector<T>& values) const {
    check_chunks(column, first, count);
    values.resize(count * static_cast<std::size_t>(std::max(column.columns, 1)));
    if (count > 0) read(column, type_of<T>(), first, count, values.data());
  }

  [[noreturn]] void refuse(const std::string& key, const std::string& value, const std::string& allowed) const;

 private:
  Column column(const char* name, bool matrix, bool real) const;
  void look_at_layout(const std::string& name, Column& column) const;
  void check_chunks(const Column& column, std::uint64_t first, std::uint64_t count) const;
  void read(const Column& column, hid_t type, std::uint64_t first, std::uint64_t count, void* values) const;
  std::vector<std::string> attribute_texts(hid_t where, const std::string& name) const;

  std::filesystem::path path_;
  Handle file_;
};

}  // namespace tactel::host
