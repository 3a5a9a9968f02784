#pragma once
#include <map>
#include <string>

namespace tactel::host {

/// What stands behind the colon of --source: "path?key=value&key=value". Read strictly.
class SourceOptions {
 public:
  explicit SourceOptions(const std::string& text);
  const std::string& path() const { return path_; }
  /// Leaves `value` as it is where the key is absent. Throws ConfigError for what is no number.
  void read(const std::string& key, double& value);
  void read(const std::string& key, int& value);
  /// Throws ConfigError for a key that nobody asked for.
  void finish() const;

 private:
  template <class Number>
  void read_number(const std::string& key, Number& value, const char* what);
  std::string path_;
  std::map<std::string, std::string> given_;
  std::map<std::string, bool> asked_;
};

}  // namespace tactel::host
