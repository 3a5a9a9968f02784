// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/support/number_lines.h"
#include "host/support/seconds.h"
#include "hw/frame_source.h"
#include "hw/serial_port.h"

namespace tactel::host {

/// Frames of hw::csv_format from lines of numbers in a file, a pipe or standard input.
///
/// A file is read as fast as its frames are taken. With a column `time` they arrive at its times, from 0 on, else when
/// they are read. A pipe is live: its frames arrive when they are read, and wait in the pipe until then. A last line
/// without its end is left out, and cut_short() says so.
///
/// A line that is no frame is an error in a file. A pipe goes on: a field that is no number is NaN, a line without any
/// or with others too many counts as bad, and it fails where none of its first 100 lines is a frame.
///
/// A log may hold the lines of several sensors, told apart by a column "sensor_id": `sensor` chooses those of one.
class CsvSource final : public hw::FrameSource {
 public:
  /// The lines of a serial port; path: of errors.
  CsvSource(std::unique_ptr<hw::SerialPort> port, const std::string& path, std::size_t channels);
  /// `path`: "-" is standard input. `paced`: a file with times, at its pace. Throws hw::RecordingError.
  CsvSource(const std::string& path, std::size_t channels, bool paced, std::optional<int> sensor = std::nullopt);
  ~CsvSource() override;

  /// Throws hw::RecordingError for a line that is no frame, once those in front of it are taken, and at the end of a
  /// source without a frame; hw::SourceError where a terminal's line hangs up, as that of an unplugged board.
  std::optional<hw::Packet> wait(double timeout) override;
  bool finished() const override { return ended_ && !held_ && !has_line(); }
  bool live() const override { return live_; }
  bool timed() const override { return live_ || lines_.has_time(); }
  double now() const override { return live_ ? seconds_since(opened_) : pace_.now(); }
  hw::TransportCounts counts() const override;
  bool cut_short() const override { return cut_short_; }
  std::string first_bad() const override { return first_bad_; }
  int fd() const override { return port_ ? port_->fd() : live_ ? file_ : -1; }

 private:
  bool has_line() const { return line_end_ != std::string::npos || text_.size() - line_begin_ > lines_.longest(); }
  std::optional<double> time() const {
    return lines_.has_time() ? std::optional(lines_.numbers().front()) : std::nullopt;
  }
  void fill(double timeout);
  void fill_from_port(double timeout);
  void take_line();
  bool is_of_sensor();
  void set_arrival();
  void count_bad(const std::string& why);

  std::string name_;
  NumberLines lines_;
  std::optional<double> sensor_;          ///< whose lines are taken; without a choice that of the first
  std::unique_ptr<hw::SerialPort> port_;  ///< none: file_ is read
  int file_ = -1;
  bool live_ = false, paced_ = false, ended_ = false, cut_short_ = false, chosen_ = false;
  bool device_ = false;                       ///< a terminal that nobody types at
  bool gap_ = false;                          ///< a device was away before the next packet
  bool dropping_ = false;                     ///< text_ goes on with the rest of a line that was too long
  std::string text_;                          ///< what was read last, with the rest of what was read before
  std::size_t line_begin_ = 0;                ///< in text_, of the line at hand
  std::size_t line_end_ = std::string::npos;  ///< npos: that line is not whole
  std::uint64_t line_ = 1, frames_ = 0;       ///< its number; frames so far
  double first_time_ = 0, arrival_ = 0;       ///< s
  bool held_ = false;                         ///< the frame in packet_ waits for its time
  std::vector<std::uint8_t> packet_;
  hw::Pace pace_;
  Clock::time_point opened_ = Clock::now();
  hw::TransportCounts counts_;
  std::string first_bad_;
};

}  // namespace tactel::host
