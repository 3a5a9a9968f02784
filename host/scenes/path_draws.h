// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "host/scenes/distribution.h"

namespace tactel::host {

/// Reads a table of a sweep file whose keys are numbers or distributions with bounded ends, such as [load.irregular].
/// `name` stands before keys in errors. Throws ConfigError.
class DrawTable {
 public:
  DrawTable(const TomlFile& file, const toml::table& table, std::string name)
      : file_(file), table_(table), name_(std::move(name)) {}

  /// Numbers from `least` to `most`, as `allowed` says.
  Distribution distribution(const char* key, Distribution otherwise, double least, double most, const char* allowed);
  double probability(const char* key, double otherwise);
  double number(const char* key, double otherwise, double least, double most, const char* allowed);
  int whole(const char* key, int otherwise, int least, int most, const char* allowed);
  /// Returns the place of the one of two words.
  bool second(const char* key, const char* first, const char* second, bool otherwise);
  /// Throws for a key that was not read.
  void finish() const;

 private:
  const toml::node* find(const char* key);
  std::string full(const char* key) const { return name_ + "." + key; }

  const TomlFile& file_;
  const toml::table& table_;
  std::string name_;
  std::vector<std::string> known_;
};

/// A number that does not differ between contacts.
inline Distribution always(double value) { return ChoiceDraw{{value}, {1}}; }

/// The numbers of one contact, drawn one after the other.
class PathDraws {
 public:
  explicit PathDraws(const DrawKey& key, std::uint32_t first = 0) : key_(key) {
    key_.stream = nn::RandomStream::path, key_.draw = first;
  }

  double number(const Distribution& from) {
    const double drawn = draw(from, key_);
    ++key_.draw;
    return drawn;
  }
  int count(const Distribution& from) { return static_cast<int>(std::lround(number(from))); }
  bool happens(double probability) { return number(UniformDraw{}) < probability; }

 private:
  DrawKey key_;
};

}  // namespace tactel::host
