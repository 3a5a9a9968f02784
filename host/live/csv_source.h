// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/support/seconds.h"
#include "hw/frame_source.h"
#include "hw/pace.h"

namespace tactel::host {

/// Lines of numbers, separated by commas, semicolons or tabs. A first line whose first field is no number is a header:
/// where its first name is `time`, the first number of each line is a time in s. Empty lines do not count.
class CsvLines {
 public:
  /// `name`: of errors, "csv:FILE". `channels`: numbers of a line, but for the time.
  CsvLines(std::string name, std::size_t channels) : name_(std::move(name)), channels_(channels) {}

  /// Reads a line without its end. Returns false for a header and an empty line. Throws hw::RecordingError, with
  /// "NAME:NUMBER: problem; fix", for every other line that has not `channels` finite numbers.
  bool read(std::string_view line, std::uint64_t number);
  [[noreturn]] void refuse(std::uint64_t number, const std::string& what) const;

  std::size_t longest() const { return 64 * (channels_ + 2); }  ///< bytes of a line
  std::optional<double> time() const { return has_time_ ? std::optional(numbers_.front()) : std::nullopt; }
  std::span<const double> values() const { return std::span(numbers_).last(channels_); }

 private:
  std::string expected() const;
  bool is_header(std::uint64_t number);

  std::string name_;
  std::size_t channels_;
  bool begun_ = false, has_time_ = false;
  std::vector<std::string_view> fields_;  ///< of the line at hand
  std::vector<double> numbers_;           ///< [channels, one more with a time]
};

/// Frames of hw::csv_format from lines of numbers in a file, a pipe or standard input.
///
/// A file is read as fast as its frames are taken. With a column `time` they arrive at its times, from 0 on, else when
/// they are read. A pipe is live: its frames arrive when they are read, and wait in the pipe until then. A last line
/// without its end is left out, and cut_short() says so.
class CsvSource final : public hw::FrameSource {
 public:
  /// `path`: "-" is standard input. `paced`: a file with times, at its pace. Throws hw::RecordingError.
  CsvSource(const std::string& path, std::size_t channels, bool paced);
  ~CsvSource() override;
  CsvSource(const CsvSource&) = delete;
  CsvSource& operator=(const CsvSource&) = delete;

  /// Throws hw::RecordingError for a line that is no frame, once those in front of it are taken, and at the end of a
  /// source without a frame.
  std::optional<hw::Packet> wait(double timeout) override;
  bool finished() const override { return ended_ && !held_ && line_end_ == std::string::npos; }
  bool live() const override { return live_; }
  double now() const override { return live_ ? seconds_since(opened_) : pace_.now(); }
  hw::TransportCounts counts() const override { return counts_; }
  bool cut_short() const override { return cut_short_; }
  int fd() const override { return live_ ? file_ : -1; }

 private:
  void fill(double timeout);
  void find_line();
  bool take_line();
  void set_arrival();

  std::string name_;
  CsvLines lines_;
  int file_ = -1;
  bool live_ = false, paced_ = false, ended_ = false, cut_short_ = false;
  std::string text_;                          ///< what was read and is not yet taken
  std::size_t line_end_ = std::string::npos;  ///< in text_, of its first line; npos: that is not whole
  std::uint64_t line_ = 1, frames_ = 0;       ///< number of the first line of text_; frames so far
  double first_time_ = 0, arrival_ = 0;       ///< s
  bool held_ = false;                         ///< the frame in packet_ waits for its time
  std::vector<std::uint8_t> packet_;
  hw::Pace pace_;
  Clock::time_point opened_ = Clock::now();
  hw::TransportCounts counts_;
};

}  // namespace tactel::host
