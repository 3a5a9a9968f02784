// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/toml_table.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "host/support/bounded_file.h"
#include "host/support/nearest_word.h"

namespace tactel::host {
namespace {

constexpr std::size_t longest_quote = 60;
constexpr std::uintmax_t largest_file = std::uintmax_t{16} << 20;
constexpr int deepest =
    16;  // parts of a key; arrays and tables within each other. The parser would go as deep as asked

std::string read_text(const std::filesystem::path& path) try {
  return read_bounded_file(path, largest_file);
} catch (const UnreadableFile& error) {
  throw ConfigError(path.string(), "file", path.string(), std::string("a readable TOML file (") + error.what() + ")");
}

std::string trimmed_text(std::string text) {
  const auto blank = [](unsigned char c) { return std::isspace(c) != 0; };
  text.erase(text.begin(), std::find_if_not(text.begin(), text.end(), blank));
  text.erase(std::find_if_not(text.rbegin(), text.rend(), blank).base(), text.end());
  return text;
}

std::string shortened(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }, ' ');
  return text.size() > longest_quote ? text.substr(0, longest_quote) + "..." : text;
}

/// Line `number`, from 1.
std::string line_of(const std::string& text, std::size_t number) {
  std::istringstream lines(text);
  std::string line;
  for (std::size_t i = 0; i < number && std::getline(lines, line); ++i) {
  }
  return line;
}

/// Where a place in the file, line and column from 1, lies in its text. Columns count code points: continuation bytes
/// of UTF-8 do not.
std::size_t offset_of(const std::string& text, toml::source_position place) {
  std::size_t at = 0;
  for (std::size_t line = 1; line < place.line && at < text.size(); ++at) line += text[at] == '\n';
  for (std::size_t column = 1; column < place.column && at < text.size(); ++column) {
    do ++at;
    while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0) == 0x80);
  }
  return at;
}

/// TOML's own complaint, as key and value of the line it is about.
ConfigError syntax_error(const std::string& file, const std::string& text, const toml::parse_error& error) {
  const auto line = error.source().begin.line;
  const std::string written = trimmed_text(line_of(text, line));
  const std::size_t equals = written.find('=');
  const bool pair = equals != std::string::npos;
  const std::string key = pair ? trimmed_text(written.substr(0, equals)) : "line " + std::to_string(line);
  const std::string value = pair ? trimmed_text(written.substr(equals + 1)) : written;
  return ConfigError(file, key, value.empty() ? "(missing)" : shortened(value),
                     "valid TOML (" + std::string(error.description()) + ")", static_cast<int>(line));
}

/// Walks over TOML without understanding it: skips texts and comments, counts brackets and the dots of a key.
class DepthScan {
 public:
  explicit DepthScan(const std::string& text) : text_(text) {}
  /// The first line, from 1, that goes deeper than `deepest`; 0 where none does.
  std::size_t too_deep() {
    for (; at_ < text_.size(); ++at_)
      if (!step(text_[at_])) return line_;
    return 0;
  }

 private:
  bool step(char c) {
    if (c == '"' || c == '\'') skip_text(c);
    if (c == '#') at_ = std::min(text_.find('\n', at_), text_.size()) - 1;
    if (c == '\n') ++line_;
    if (c == '[' || c == '{') ++open_;
    if ((c == ']' || c == '}') && open_ > 0) --open_;
    if (std::string_view("=,[]{}#\n").find(c) != std::string_view::npos) dots_ = 0;
    if (c == '.') ++dots_;
    return open_ <= deepest && dots_ < deepest;
  }
  /// From the opening quote to the closing one; to the end of the line where a text of one line lacks it.
  void skip_text(char quote) {
    const bool lines = text_.compare(at_, 3, std::string(3, quote)) == 0;
    const std::size_t width = lines ? 3 : 1;
    for (at_ += width; at_ < text_.size(); ++at_) {
      if (quote == '"' && text_[at_] == '\\')
        ++at_;
      else if (text_.compare(at_, width, std::string(width, quote)) == 0)
        break;
      else if (text_[at_] == '\n' && lines)
        ++line_;
      else if (text_[at_] == '\n')
        return --at_, void();
    }
    at_ += width - 1;
  }

  const std::string& text_;
  std::size_t at_ = 0, line_ = 1;
  int open_ = 0, dots_ = 0;
};

void check_depth(const std::string& file, const std::string& text) {
  const std::size_t line = DepthScan(text).too_deep();
  if (line > 0)
    throw ConfigError(file, "line " + std::to_string(line), shortened(trimmed_text(line_of(text, line))),
                      "keys of at most 16 parts, and arrays and tables at most 16 within each other",
                      static_cast<int>(line));
}

}  // namespace

std::optional<double> toml_number(const toml::node& node) {
  if (const auto* whole = node.as_integer()) return static_cast<double>(whole->get());
  if (const auto* number = node.as_floating_point()) return number->get();
  return std::nullopt;
}

TomlFile::TomlFile(const std::filesystem::path& path) : TomlFile(path, read_text(path)) {}

TomlFile::TomlFile(const std::filesystem::path& path, std::string text) : path_(path), text_(std::move(text)) {
  check_depth(path.string(), text_);
  try {
    root_ = std::make_unique<toml::table>(toml::parse(text_, path.string()));
  } catch (const toml::parse_error& error) {
    throw syntax_error(path.string(), text_, error);
  }
}

std::string TomlFile::as_written(const toml::node& node) const {
  if (node.is_table()) return "(a table)";
  const std::size_t begin = offset_of(text_, node.source().begin);
  const std::size_t end = offset_of(text_, node.source().end);
  return shortened(trimmed_text(text_.substr(begin, end > begin ? end - begin : 0)));
}

TomlFile::~TomlFile() = default;
TomlFile::TomlFile(TomlFile&&) noexcept = default;

ConfigError TomlFile::error(const std::string& key, const toml::node* node, const std::string& allowed) const {
  if (node == nullptr) return ConfigError(path_.string(), key, "(missing)", allowed);
  return ConfigError(path_.string(), key, as_written(*node), allowed, static_cast<int>(node->source().begin.line));
}

ConfigError TomlFile::error(const ValueError& error) const {
  const toml::node* node = root_->at_path(error.key).node();
  const int line = node != nullptr ? static_cast<int>(node->source().begin.line) : 0;
  const bool quotable = node != nullptr && node->is_value() && !node->is_string();
  return ConfigError(path_.string(), error.key, quotable ? as_written(*node) : error.value, error.allowed, line);
}

TomlTable::TomlTable(const TomlFile& file, const std::string& name) : file_(file), name_(name) {
  const toml::node* node = name.empty() ? &file.root() : file.root().get(name);
  if (node == nullptr) return;
  table_ = node->as_table();
  if (table_ == nullptr) throw file.error(name, node, "a table, written [" + name + "]");
}

bool TomlTable::has(const std::string& key) const { return table_ != nullptr && table_->contains(key); }

bool TomlTable::has_text(const std::string& key) const { return has(key) && table_->get(key)->is_string(); }

const toml::node* TomlTable::find(const std::string& key) {
  asked_.insert(key);
  return table_ != nullptr ? table_->get(key) : nullptr;
}

std::vector<TomlTable> TomlTable::read_tables(const std::string& key, const std::string& what) {
  std::vector<TomlTable> all;
  const toml::node* node = find(key);
  if (node == nullptr) return all;
  const toml::array* array = node->as_array();
  if (array == nullptr || array->empty() || !array->is_homogeneous<toml::table>()) refuse(key, what);
  for (const toml::node& entry : *array)
    all.push_back({file_, full(key) + "[" + std::to_string(all.size()) + "]", entry.as_table()});
  return all;
}

void TomlTable::refuse(const std::string& key, const std::string& allowed) const {
  throw file_.error(full(key), table_ != nullptr ? table_->get(key) : nullptr, allowed);
}

void TomlTable::refuse_missing(const std::string& key, const std::string& allowed) const {
  throw file_.error(full(key), nullptr, allowed);
}

template <class T>
void TomlTable::take(const toml::node& node, const std::string& key, T& value, const std::string& what) const {
  const auto expect = [&](bool good) {
    if (!good) throw file_.error(full(key), &node, what);
  };
  if constexpr (std::is_same_v<T, double>) {
    const std::optional<double> number = toml_number(node);
    expect(number.has_value());
    if (!std::isfinite(*number)) throw file_.error(full(key), &node, "finite, " + what);
    value = *number;
  } else if constexpr (std::is_same_v<T, int>) {
    constexpr std::int64_t most = std::numeric_limits<int>::max();
    std::int64_t whole = 0;
    take(node, key, whole, what);
    expect(whole <= most && whole >= -most);
    value = static_cast<int>(whole);
  } else if constexpr (toml::is_value<T>) {
    expect(node.is<T>());
    value = **node.as<T>();
  } else if constexpr (std::is_same_v<T, std::array<double, 2>>) {
    const toml::array* both = node.as_array();
    expect(both != nullptr && both->size() == 2);
    for (std::size_t i : {0, 1}) take(*both->get(i), key, value[i], what);
  } else {
    expect(node.is_array());
    value.clear();
    for (const toml::node& entry : *node.as_array()) take(entry, key, value.emplace_back(), what);
  }
}

template <class T>
bool TomlTable::read(const std::string& key, T& value, const std::string& what) {
  const toml::node* node = find(key);
  if (node != nullptr) take(*node, key, value, what);
  return node != nullptr;
}

template bool TomlTable::read(const std::string&, double&, const std::string&);
template bool TomlTable::read(const std::string&, int&, const std::string&);
template bool TomlTable::read(const std::string&, std::int64_t&, const std::string&);
template bool TomlTable::read(const std::string&, std::string&, const std::string&);
template bool TomlTable::read(const std::string&, bool&, const std::string&);
template bool TomlTable::read(const std::string&, std::vector<double>&, const std::string&);
template bool TomlTable::read(const std::string&, std::vector<int>&, const std::string&);
template bool TomlTable::read(const std::string&, std::array<double, 2>&, const std::string&);
template bool TomlTable::read(const std::string&, std::vector<std::array<double, 2>>&, const std::string&);
template bool TomlTable::read(const std::string&, std::vector<std::vector<double>>&, const std::string&);

bool TomlTable::read_one_or_more(const std::string& key, std::vector<double>& value, const std::string& what) {
  const toml::node* node = find(key);
  if (node == nullptr) return false;
  if (node->is_array() && !node->as_array()->empty()) return read(key, value, what);
  value.resize(1);
  take(*node, key, value[0], what);
  return true;
}

std::optional<std::size_t> TomlTable::read_choice(const std::string& key, const std::vector<std::string>& words) {
  const std::string allowed = "one of " + listed(words);
  std::string word;
  if (!read(key, word, allowed)) return std::nullopt;
  const auto found = std::find(words.begin(), words.end(), word);
  if (found != words.end()) return static_cast<std::size_t>(found - words.begin());
  refuse(key, allowed + did_you_mean(word, words));
}

void TomlTable::expect_table(const std::string& key) { asked_.insert(key); }

std::vector<std::string> TomlTable::keys() const {
  if (table_ == nullptr) return {};
  std::vector<std::pair<toml::source_position, std::string>> found;
  for (const auto& [key, node] : *table_) found.emplace_back(key.source().begin, std::string(key.str()));
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> names;
  names.reserve(found.size());
  for (const auto& [place, name] : found) names.push_back(name);
  return names;
}

void TomlTable::refuse_unknown(std::vector<std::string> known) const {
  std::ranges::sort(known);
  for (const std::string& key : keys()) {
    if (!std::ranges::binary_search(known, key))
      refuse(key, "a known key, one of " + listed(known) + did_you_mean(key, known));
  }
}

void TomlTable::refuse_any(const std::vector<std::string>& keys, const std::string& allowed) const {
  for (const std::string& key : this->keys())
    if (std::ranges::find(keys, key) != keys.end()) refuse(key, allowed);
}

std::string TomlTable::only_one(const std::vector<std::string>& keys) const {
  std::string present;
  for (const std::string& key : keys) {
    if (!has(key)) continue;
    if (!present.empty())
      refuse(key, "left out, because " + full(present) + " is given too: only one of " + listed(keys) + " can be");
    present = key;
  }
  return present;
}

void TomlTable::finish() const { refuse_unknown({asked_.begin(), asked_.end()}); }

}  // namespace tactel::host
