// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <string>

namespace tactel::host {

/// Reads strictly the text after the colon of --source: "path?key=value&key=value".
class SourceOptions {
 public:
  explicit SourceOptions(const std::string& text);
  const std::string& path() const { return path_; }
  /// Reads a finite number. Returns whether the key is there, and leaves `value` unchanged where it is not. Throws
  /// ConfigError for a text that is no number.
  bool read(const std::string& key, double& value);
  bool read(const std::string& key, int& value);
  /// Throws ConfigError for an empty text.
  void read(const std::string& key, std::string& value);
  /// Throws ConfigError for a key that was not read.
  void finish() const;

 private:
  template <class Number>
  bool read_number(const std::string& key, Number& value, const char* what);
  std::string path_;
  std::map<std::string, std::string> given_;
  std::map<std::string, bool> asked_;
};

}  // namespace tactel::host
