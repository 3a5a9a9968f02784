// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "fem/numbers/value_error.h"
#include "host/support/errors.h"

// Forward declarations of toml++; only the sources of scenes/ include its long header.
namespace toml {
inline namespace v3 {
class node;
class table;
}  // namespace v3
}  // namespace toml

namespace tactel::host {

/// A TOML file. It keeps its text, so that errors quote a value as it was written.
class TomlFile {
 public:
  /// Reads at most 16 MiB. Throws ConfigError for a file that cannot be read or is not TOML, and for keys or values
  /// nested more than 16 deep.
  explicit TomlFile(const std::filesystem::path& path);
  /// Reads a text that is not from a file; errors name `path`.
  TomlFile(const std::filesystem::path& path, std::string text);
  ~TomlFile();
  TomlFile(TomlFile&&) noexcept;
  const std::string& text() const { return text_; }

  const std::filesystem::path& path() const { return path_; }
  const toml::table& root() const { return *root_; }
  toml::table& root() { return *root_; }

  /// Returns the error about a value of this file. `node` (may be null) gives line and value.
  ConfigError error(const std::string& key, const toml::node* node, const std::string& allowed) const;
  /// The same from an error of the model, whose key is a path such as "sensor.poisson".
  ConfigError error(const ValueError& error) const;

 private:
  std::string as_written(const toml::node& node) const;

  std::filesystem::path path_;
  std::string text_;
  std::unique_ptr<toml::table> root_;
};

/// Returns the nearest number to a whole or floating-point one; nothing of another type. node::value<double>() is empty
/// for whole numbers beyond 2^53.
std::optional<double> toml_number(const toml::node& node);

/// One table of a file, read strictly. A value of the wrong type is an error, and so is a key that was not read.
/// `read` leaves `value` unchanged where the key is absent; `what` is the allowed range, with its unit.
class TomlTable {
 public:
  /// The table `name` of the file, which may be absent; the root table for an empty name.
  TomlTable(const TomlFile& file, const std::string& name);

  bool has(const std::string& key) const;
  bool has_text(const std::string& key) const;  ///< for keys that also accept another type
  /// T: double, int, std::int64_t, std::string, bool, two numbers (std::array), or a std::vector of numbers or of
  /// these.
  template <class T>
  bool read(const std::string& key, T& value, const std::string& what);
  /// One number, or an array of at least one.
  bool read_one_or_more(const std::string& key, std::vector<double>& value, const std::string& what);
  /// Reads one word of `words` and returns its index.
  std::optional<std::size_t> read_choice(const std::string& key, const std::vector<std::string>& words);
  /// Returns the tables of an array; none where the key is absent.
  std::vector<TomlTable> read_tables(const std::string& key, const std::string& what);
  /// Marks an inner table as known; it is read by a TomlTable of its own.
  void expect_table(const std::string& key);

  /// Throws ConfigError: `key` must be `allowed`.
  [[noreturn]] void refuse(const std::string& key, const std::string& allowed) const;
  [[noreturn]] void refuse_missing(const std::string& key, const std::string& allowed) const;
  /// Returns the keys present, in the order of the file.
  std::vector<std::string> keys() const;
  /// Throws ConfigError for the first key that is not in `known`, with the nearest known key. Call it before
  /// `refuse_missing`: the error then names a misspelt key rather than the key that it replaces.
  void refuse_unknown(std::vector<std::string> known) const;
  /// Throws ConfigError for the first key that is in `keys`: it must be `allowed`.
  void refuse_any(const std::vector<std::string>& keys, const std::string& allowed) const;
  /// Returns the one key of `keys` that is present; empty where none is. Throws ConfigError for two.
  std::string only_one(const std::vector<std::string>& keys) const;
  /// Throws ConfigError for the first key that was not read, with the nearest known key.
  void finish() const;

 private:
  TomlTable(const TomlFile& file, const std::string& name, const toml::table* table)
      : file_(file), name_(name), table_(table) {}
  const toml::node* find(const std::string& key);
  std::string full(const std::string& key) const { return name_.empty() ? key : name_ + "." + key; }
  template <class T>
  void take(const toml::node& node, const std::string& key, T& value, const std::string& what) const;

  const TomlFile& file_;
  std::string name_;
  const toml::table* table_ = nullptr;
  std::set<std::string> asked_;
};

}  // namespace tactel::host
