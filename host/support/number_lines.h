// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tactel::host {

/// The numbers of a line.
struct NumberColumns {
  std::size_t count = 0;             ///< 0: as many as the first line has
  std::string meaning{};             ///< of them, for errors: "x and y in mm"
  std::vector<std::string> names{};  ///< that a header has to have, with or without "mm"; empty: any
  bool may_have_time = false;        ///< a header whose first name is "time" puts a time in front of the numbers
  double largest = std::numeric_limits<float>::max();
  bool quotes = true;  ///< false: a stranger may have named the file; errors quote it below its first numbers alone
};

/// Lines of numbers, by one set of rules for frames, profiles, heights and answers (docs/profiles.md):
/// - A byte order mark, blank lines and lines that begin with # do not count, but for numpy's header "# time,...".
/// - The first line that counts may be a header: its first field is no number, and the others are none or count up.
///   A line 0,1,2,3 or 1,2,3,4 (four or more) in its place numbers the columns and is refused; so is 0,1 or 0,1,2 where
///   the number of columns is known.
/// - One separator, of the first line: semicolons, else tabs, else commas, else blanks. But for commas, a comma may be
///   the decimal point.
/// - Every line has equally many numbers, all finite decimal ones: no hexadecimals, no text behind them.
class NumberLines {
 public:
  /// `file`: of errors.
  NumberLines(std::string file, NumberColumns columns) : file_(std::move(file)), columns_(std::move(columns)) {}

  /// Whether a field behind the time that is no number is NaN, in a line that has one.
  void take_gaps(bool gaps) { gaps_ = gaps; }
  /// Reads a line without its end. Returns whether it holds numbers. Throws ConfigError, "FILE:NUMBER: ...".
  bool read(std::string_view line, std::uint64_t number);
  std::span<const double> numbers() const { return numbers_; }  ///< of the line read last, a time first
  bool has_time() const { return has_time_; }
  /// Letters and digits of its names, in lower case: "X [mm]" is "xmm". Empty: no header.
  const std::vector<std::string>& header() const { return header_; }
  std::size_t longest() const;  ///< bytes of a line
  /// Throws an error of the line read last.
  [[noreturn]] void refuse(const std::string& key, std::string_view value, const std::string& allowed) const;

 private:
  void split(std::string_view line);
  bool is_header() const;
  bool numbers_columns() const;
  void take_header();
  void check_count(const char* key) const;

  std::string file_;
  NumberColumns columns_;
  bool begun_ = false, has_time_ = false, gaps_ = false;
  char separator_ = ',';
  std::uint64_t number_ = 0;  ///< of the line at hand
  std::vector<std::string> header_;
  std::vector<std::string_view> fields_;  ///< of the line at hand
  std::vector<double> numbers_;
};

/// Reads a regular file of `most` bytes or fewer, and hands each line of numbers to `take`. Throws ConfigError; that of
/// a file that cannot be read has the key `key`.
void read_number_file(const std::filesystem::path& path, std::uintmax_t most, const std::string& key,
                      NumberLines& lines, const std::function<void(std::span<const double>)>& take);

}  // namespace tactel::host
