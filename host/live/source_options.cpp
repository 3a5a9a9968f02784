// SPDX-License-Identifier: Apache-2.0
#include <charconv>
#include <cmath>
#include <sstream>
#include <vector>

#include "host/live/open_source.h"
#include "host/support/errors.h"
#include "host/support/nearest_word.h"

namespace tactel::host {

SourceOptions::SourceOptions(const std::string& text) : path_(text.substr(0, text.find('?'))) {
  if (path_.size() == text.size()) return;
  std::istringstream pairs(text.substr(path_.size() + 1));
  for (std::string pair; std::getline(pairs, pair, '&');) {
    const auto equals = pair.find('=');
    if (equals == std::string::npos) throw ConfigError("command line", "--source", pair, "key=value behind the ?");
    given_[pair.substr(0, equals)] = pair.substr(equals + 1);
  }
}

template <class Number>
bool SourceOptions::read_number(const std::string& key, Number& value, const char* what) {
  asked_[key] = true;
  const auto found = given_.find(key);
  if (found == given_.end()) return false;
  const std::string& text = found->second;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(static_cast<double>(value)))
    throw ConfigError("--source", key, text, what);
  return true;
}

bool SourceOptions::read(const std::string& key, double& value) { return read_number(key, value, "a finite number"); }
bool SourceOptions::read(const std::string& key, int& value) { return read_number(key, value, "a whole number"); }

void SourceOptions::read(const std::string& key, std::string& value) {
  asked_[key] = true;
  const auto found = given_.find(key);
  if (found == given_.end()) return;
  if (found->second.empty()) throw ConfigError("--source", key, "(empty)", "a text");
  value = found->second;
}

void SourceOptions::finish() const {
  std::vector<std::string> names;
  for (const auto& [key, asked] : asked_) names.push_back(key);
  for (const auto& [key, value] : given_) {
    if (!asked_.contains(key))
      throw ConfigError("--source", key, value, "left out; known are " + listed(names) + did_you_mean(key, names));
  }
}

}  // namespace tactel::host
