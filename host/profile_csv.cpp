#include "host/profile_csv.h"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string_view>

#include "host/errors.h"

namespace tactel::host {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";  // spreadsheets write it before UTF-8

/// The file being read, line by line, and errors about its current line.
struct CsvLines {
  std::string file;
  std::ifstream in;
  std::string line;
  int number = 0;

  explicit CsvLines(const std::filesystem::path& path) : file(path.string()), in(path) {
    if (!in || std::filesystem::is_directory(path)) {
      throw ConfigError(file, "indenter.file", file,
                        std::string("a readable CSV file (") + std::strerror(in ? EISDIR : errno) + ")");
    }
  }
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
    throw ConfigError(file, key, std::string(value), allowed, number);
  }
};

double number(const CsvLines& lines, const std::string& column, std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
  if (!whole) lines.refuse(column, text, "a finite number of mm, with a decimal point");
  return value;
}

void read_header(CsvLines& lines) {
  const std::string_view header = lines.next();
  const auto comma = header.find(',');
  const bool known = comma != std::string_view::npos && trimmed(header.substr(0, comma)) == "x" &&
                     trimmed(header.substr(comma + 1)) == "y";
  if (!known) lines.refuse("header", header.empty() ? "(missing)" : header, "x,y");
}

}  // namespace

void read_profile_csv(const std::filesystem::path& path, fem::Profile& profile) {
  CsvLines lines(path);
  read_header(lines);
  profile.x.clear();
  profile.y.clear();
  for (std::string_view text = lines.next(); !text.empty(); text = lines.next()) {
    const auto comma = text.find(',');
    if (comma == std::string_view::npos || text.find(',', comma + 1) != std::string_view::npos) {
      lines.refuse("line", text, "two columns, x,y, both in mm");
    }
    const double x = number(lines, "x", trimmed(text.substr(0, comma)));
    const double y = number(lines, "y", trimmed(text.substr(comma + 1)));
    if (!profile.x.empty() && x <= profile.x.back()) {
      lines.refuse("x", trimmed(text.substr(0, comma)), "greater than the x on the line before");
    }
    profile.x.push_back(x);
    profile.y.push_back(y);
  }
  if (profile.x.size() < 2) {
    throw ConfigError(lines.file, "points", std::to_string(profile.x.size()), "at least 2 lines x,y below the header");
  }
}

}  // namespace tactel::host
