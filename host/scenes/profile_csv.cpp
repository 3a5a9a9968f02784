// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/profile_csv.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>
#include <string_view>

#include "host/support/bounded_file.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t largest_table = std::uintmax_t{16} << 20;
constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";  // spreadsheets write it before UTF-8
constexpr const char* example =
    "two columns, x and y in mm, separated by comma, semicolon or tab, with or without a header, such as the three "
    "lines `x,y` `-1.0,0.05` `0.0,0.0`";

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::string csv_text(const fs::path& path) try {
  return read_bounded_file(path, largest_table);
} catch (const UnreadableFile& error) {
  throw ConfigError(path.string(), "indenter.file", path.string(),
                    std::string("a readable CSV file (") + error.what() + ")");
}

/// The file being read, line by line, and errors about its current line. Its content is quoted only once it has proved
/// to be a profile: the name of the file may come from a stranger's scene.
struct CsvLines {
  std::string file;
  std::istringstream in;
  std::string line;
  int number = 0;
  bool proved = false;
  char separator = ',';

  explicit CsvLines(const fs::path& path) : file(path.string()), in(csv_text(path)) {}
  /// The next line that holds something; empty at the end.
  std::string_view next() {
    while (std::getline(in, line)) {
      std::string_view text = line;
      if (++number == 1 && text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
      text = trimmed(text);
      if (!text.empty() && text.front() != '#') return text;
    }
    return {};
  }
  [[noreturn]] void refuse(const std::string& key, std::string_view value, const std::string& allowed) const {
    throw ConfigError(file, key, proved ? std::string(value) : "(not shown)", allowed, number);
  }
};

/// The two fields of a line; none where it has more or fewer.
std::optional<std::array<std::string_view, 2>> fields(std::string_view line, char separator) {
  const auto between = line.find(separator);
  if (between == std::string_view::npos || line.find(separator, between + 1) != std::string_view::npos) return {};
  return {{trimmed(line.substr(0, between)), trimmed(line.substr(between + 1))}};
}

/// A finite number. A comma stands for the decimal point where it does not separate columns.
std::optional<double> number_in(std::string_view text, char separator) {
  std::string digits(text);
  if (separator != ',') std::ranges::replace(digits, ',', '.');
  double value = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(value)) return {};
  return value;
}

double number(const CsvLines& lines, const std::string& column, std::string_view text) {
  const auto value = number_in(text, lines.separator);
  if (!value) lines.refuse(column, text, "a finite number of mm, with a decimal point");
  return *value;
}

/// Whether a header's field names this column: "x", "X [mm]", "x (mm)", "x_mm".
bool names_column(std::string_view field, char column) {
  std::string letters;
  for (const unsigned char c : field)
    if (std::isalnum(c)) letters += static_cast<char>(std::tolower(c));
  return letters == std::string(1, column) || letters == std::string(1, column) + "mm";
}

/// Takes the separator from the first line. Returns that line where it is one of numbers, else (a header) the next.
std::string_view begin(CsvLines& lines) {
  const std::string_view first = lines.next();
  if (first.empty()) throw ConfigError(lines.file, "points", "(missing)", example);
  for (const char separator : {';', '\t', ','})
    if (first.find(separator) != std::string_view::npos) {
      lines.separator = separator;
      break;
    }
  const auto columns = fields(first, lines.separator);
  if (!columns) lines.refuse("line", first, example);
  const bool numbers = number_in((*columns)[0], lines.separator) && number_in((*columns)[1], lines.separator);
  lines.proved = numbers || (names_column((*columns)[0], 'x') && names_column((*columns)[1], 'y'));
  if (!lines.proved) lines.refuse("header", first, example);
  return numbers ? first : lines.next();
}

}  // namespace

void read_profile_csv(const fs::path& path, fem::Profile& profile) {
  CsvLines lines(path);
  profile.x.clear();
  profile.y.clear();
  for (std::string_view text = begin(lines); !text.empty(); text = lines.next()) {
    const auto columns = fields(text, lines.separator);
    if (!columns) lines.refuse("line", text, "two columns, x and y in mm, separated as on the first line");
    const double x = number(lines, "x", (*columns)[0]);
    const double y = number(lines, "y", (*columns)[1]);
    if (!profile.x.empty() && x <= profile.x.back())
      lines.refuse("x", (*columns)[0], "greater than the x on the line before");
    profile.x.push_back(x);
    profile.y.push_back(y);
  }
  if (profile.x.size() < 2)
    throw ConfigError(lines.file, "points", std::to_string(profile.x.size()), "at least 2 lines of x and y");
}

namespace {

constexpr double highest = 1e6;  // mm
constexpr const char* height_example =
    "heights in mm, separated by comma, semicolon or tab: a line for each y, such as the two lines `0.1,0,0.1` `0,0,0`";

/// The numbers of a line of heights.
std::vector<double> heights_in(const CsvLines& lines, std::string_view text) {
  std::vector<double> heights;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(lines.separator, at), text.size());
    const std::string_view field = trimmed(text.substr(at, end - at));
    const auto height = number_in(field, lines.separator);
    if (!height || std::abs(*height) > highest) lines.refuse("height", field, "a finite number of mm, 1e6 at most");
    if (heights.size() == longest_height_map) lines.refuse("line", "(long)", "at most 1000 heights");
    heights.push_back(*height);
    at = end + 1;
  }
  return heights;
}

}  // namespace

void read_heights_csv(const fs::path& path, fem::HeightMap& map) {
  CsvLines lines(path);
  std::vector<std::vector<double>> rows;
  for (std::string_view text = lines.next(); !text.empty(); text = lines.next()) {
    if (rows.empty())
      for (const char separator : {';', '\t', ','})
        if (text.find(separator) != std::string_view::npos) {
          lines.separator = separator;
          break;
        }
    rows.push_back(heights_in(lines, text));
    lines.proved = true;
    if (rows.back().size() < 2) lines.refuse("line", text, height_example);
    if (rows.back().size() != rows.front().size())
      lines.refuse("heights", std::to_string(rows.back().size()),
                   std::to_string(rows.front().size()) + ", as on the first line");
    if (rows.size() > longest_height_map) lines.refuse("lines", "(more)", "at most 1000");
  }
  if (rows.size() < 2) throw ConfigError(lines.file, "lines", std::to_string(rows.size()), height_example);
  map.heights.resize(static_cast<Eigen::Index>(rows.front().size()), static_cast<Eigen::Index>(rows.size()));
  for (std::size_t j = 0; j < rows.size(); ++j)
    map.heights.col(static_cast<Eigen::Index>(j)) =
        Eigen::Map<const Eigen::VectorXd>(rows[j].data(), static_cast<Eigen::Index>(rows[j].size()));
  map.heights.array() -= map.heights.minCoeff();
}

}  // namespace tactel::host
