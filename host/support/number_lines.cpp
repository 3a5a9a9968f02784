// SPDX-License-Identifier: Apache-2.0
#include "host/support/number_lines.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>

#include "host/support/bounded_file.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";  // spreadsheets write it before UTF-8
constexpr std::size_t least_numbered = 4;                     // fields: fewer may well be numbers

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// A number in all of `text`, also one that is not finite; none for other texts.
std::optional<double> number_in(std::string_view text, char separator) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  std::string point;
  if (const auto comma = text.find(','); separator != ',' && comma != std::string_view::npos && comma + 1 < text.size())
    text = (point = std::string(text).replace(comma, 1, "."));
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || end != text.data() + text.size()) return std::nullopt;
  return error == std::errc{} ? value : std::numeric_limits<double>::infinity();
}

/// Letters and digits of a name, in lower case: "X [mm]" is "xmm".
std::string bare(std::string_view name) {
  std::string letters;
  for (const unsigned char c : name)
    if (std::isalnum(c)) letters += static_cast<char>(std::tolower(c));
  return letters;
}

/// Whether the fields from one on count up by one, from 0 or 1 for the first column.
bool count_up(std::span<const std::string_view> fields, std::size_t from) {
  std::size_t first = 0;
  for (std::size_t i = from; i < fields.size(); ++i) {
    std::size_t value = 0;
    const char* const end = fields[i].data() + fields[i].size();
    if (std::from_chars(fields[i].data(), end, value).ptr != end || fields[i].empty()) return false;
    if (i == from) first = value;
    if (first > from + 1 || value != first + i - from) return false;
  }
  return true;
}

}  // namespace

std::size_t NumberLines::longest() const {
  return columns_.count > 0 ? 64 * (columns_.count + 2) : std::size_t{1} << 20;
}

void NumberLines::refuse(const std::string& key, std::string_view value, const std::string& allowed) const {
  const std::string cut = std::string(value.substr(0, 40)) + (value.size() > 40 ? "..." : "");
  constexpr std::uint64_t most = std::numeric_limits<int>::max();
  throw ConfigError(file_, key, columns_.quotes ? cut : "(not shown)", allowed,
                    static_cast<int>(std::min(number_, most)));
}

void NumberLines::split(std::string_view line) {
  if (!begun_) {
    separator_ = ' ';
    for (const char separator : {',', '\t', ';'})
      if (line.find(separator) != std::string_view::npos) separator_ = separator;
  }
  fields_.clear();
  for (std::size_t from = 0; from <= line.size();) {
    const std::size_t end = std::min(line.find(separator_, from), line.size());
    const std::string_view field = trimmed(line.substr(from, end - from));
    if (separator_ != ' ' || !field.empty()) fields_.push_back(field);
    from = end + 1;
  }
}

bool NumberLines::is_header() const {
  const auto is_number = [&](std::string_view field) { return number_in(field, separator_).has_value(); };
  if (is_number(fields_.front())) return false;
  return std::none_of(fields_.begin() + 1, fields_.end(), is_number) || (fields_.size() > 2 && count_up(fields_, 1));
}

/// As pandas numbers them, from 0 on, or others from 1. A map of heights may begin with 0,1.
bool NumberLines::numbers_columns() const {
  const std::size_t least = fields_.front() == "0" && columns_.count > 0 ? 2 : least_numbered;
  return fields_.size() >= least && count_up(fields_, 0);
}

void NumberLines::check_count(const char* key) const {
  const std::size_t count = columns_.count + has_time_;
  if (columns_.count == 0 || fields_.size() == count) return;
  const bool were_time = key == std::string_view("names") && columns_.may_have_time;
  throw ConfigError(file_, key, std::to_string(fields_.size()),
                    fmt::format("{}: {}{}{}", count, columns_.meaning, has_time_ ? ", behind the time" : "",
                                were_time ? "; a time is first and called \"time\"" : ""),
                    static_cast<int>(number_));
}

void NumberLines::take_header() {
  header_.resize(fields_.size());
  std::ranges::transform(fields_, header_.begin(), bare);
  has_time_ = columns_.may_have_time && header_.front() == "time";
  check_count("names");
  for (std::size_t i = 0; i < columns_.names.size(); ++i)
    if (header_[i] != columns_.names[i] && header_[i] != columns_.names[i] + "mm")
      refuse("header", fields_[i],
             fmt::format("the names {} of {}, or numbers", fmt::join(columns_.names, ","), columns_.meaning));
  if (columns_.count == 0) columns_.count = fields_.size();
  begun_ = true;
  columns_.quotes |= !columns_.names.empty();
}

bool NumberLines::read(std::string_view line, std::uint64_t number) {
  number_ = number;
  if (!begun_) has_time_ = false;
  if (number == 1 && line.starts_with(byte_order_mark)) line.remove_prefix(byte_order_mark.size());
  line = trimmed(line);
  const bool remark = line.starts_with('#');
  if (line.empty() || (remark && (begun_ || !columns_.may_have_time))) return false;
  if (line.size() > longest())
    refuse("line", "(long)", fmt::format("at most {} bytes: {}", longest(), columns_.meaning));
  split(remark ? trimmed(line.substr(1)) : line);
  if (remark && (fields_.empty() || bare(fields_.front()) != "time")) return false;
  if (!begun_ && is_header()) {
    take_header();
    return false;
  }
  if (!begun_ && numbers_columns())
    refuse("line", line, "numbers, or names: this numbers the columns; leave it out, or write 0.0 where it is a 0");
  if (columns_.count == 0) columns_.count = fields_.size();
  check_count("fields");
  numbers_.resize(fields_.size());
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    const auto value = number_in(fields_[i], separator_);
    numbers_[i] = value && std::abs(*value) <= columns_.largest ? *value : std::nan("");
  }
  const auto is_number = [](double number) { return !std::isnan(number); };
  const bool gaps = gaps_ && std::ranges::any_of(std::span(numbers_).subspan(has_time_), is_number);
  for (std::size_t i = 0; i < fields_.size(); ++i)
    if (!is_number(numbers_[i]) && !(gaps && i >= has_time_))
      refuse(i < columns_.names.size() ? columns_.names[i] : fmt::format("column {}", i + 1), fields_[i],
             "a finite number such as -1.5" +
                 (columns_.largest < 1e30 ? fmt::format(", {:g} at most", columns_.largest) : ""));
  return begun_ = columns_.quotes = true;
}

void read_number_file(const std::filesystem::path& path, std::uintmax_t most, const std::string& key,
                      NumberLines& lines, const std::function<void(std::span<const double>)>& take) {
  std::string text;
  try {
    text = read_bounded_file(path, most);
  } catch (const UnreadableFile& error) {
    throw ConfigError(path.string(), key, path.string(), fmt::format("a readable CSV file ({})", error.what()));
  }
  std::uint64_t number = 0;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t end = std::min(text.find('\n', from), text.size());
    if (lines.read(std::string_view(text).substr(from, end - from), ++number)) take(lines.numbers());
    from = end + 1;
  }
}

}  // namespace tactel::host
