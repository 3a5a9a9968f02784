// SPDX-License-Identifier: Apache-2.0
#include "host/live/csv_source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "host/support/errors.h"
#include "hw/formats.h"

namespace tactel::host {
namespace {

constexpr std::size_t bytes_of_file = 1 << 16;
constexpr int most_reads = 32;                  // of a file without frames, until the caller is asked whether to go on
constexpr std::size_t bytes_of_pipe = 1 << 12;  // few: what waits in the pipe has not arrived yet, and is not late
constexpr double latest_arrival = 1e9;          // s, as of recordings
constexpr std::uint64_t most_bad_at_first = 100;  // lines: what a board prints when it starts is less
constexpr const char* meaning = "one for each of the profile's channels";

}  // namespace

CsvSource::CsvSource(const std::string& path, std::size_t channels, bool paced, std::optional<int> sensor)
    : name_("csv:" + path),
      lines_(name_, {.count = channels, .meaning = meaning, .may_have_time = true}),
      sensor_(sensor),
      paced_(paced),
      chosen_(sensor.has_value()),
      pace_(paced) {
  // Without O_NONBLOCK a named pipe would wait for its writer here, and no signal could end that.
  file_ = path == "-" ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  struct stat status {};
  if (file_ < 0 || ::fstat(file_, &status) != 0)
    throw hw::RecordingError(name_ + ": cannot be read: " + std::strerror(errno));
  live_ = !S_ISREG(status.st_mode);
  lines_.take_gaps(live_);
  device_ = ::isatty(file_) != 0 && ::tcgetsid(file_) < 0;
  if (live_ && paced) throw hw::RecordingError(name_ + ": has a pace of its own; leave paced=1 out");
}

CsvSource::CsvSource(std::unique_ptr<hw::SerialPort> port, const std::string& path, std::size_t channels)
    : name_("serial:" + path),
      lines_(name_, {.count = channels, .meaning = meaning, .may_have_time = true}),
      port_(std::move(port)),
      live_(true),
      pace_(false) {}

CsvSource::~CsvSource() {
  if (file_ > STDIN_FILENO) ::close(file_);
}

hw::TransportCounts CsvSource::counts() const {
  hw::TransportCounts counts = counts_;
  if (port_) counts.reconnects = port_->reconnects();
  return counts;
}

/// A line that was cut by a gap is none.
void CsvSource::fill_from_port(double timeout) {
  const hw::Bytes bytes = port_->read(timeout);
  if (port_->take_gap()) gap_ = true, dropping_ = false, text_.clear();
  if (!bytes.empty()) arrival_ = now();
  counts_.bytes += bytes.size();
  text_.append(bytes.begin(), bytes.end());
  line_end_ = text_.find('\n');
}

/// Reads more text, of a pipe once and within `timeout` s.
void CsvSource::fill(double timeout) {
  if (port_) return fill_from_port(timeout);
  if (live_) {
    pollfd wanted{file_, POLLIN, 0};
    if (::poll(&wanted, 1, static_cast<int>(std::clamp(timeout, 0.0, 3600.0) * 1e3)) <= 0) return;
  }
  std::array<char, bytes_of_file> bytes;
  const ssize_t size = ::read(file_, bytes.data(), live_ ? bytes_of_pipe : bytes_of_file);
  if (size < 0 && (errno == EINTR || errno == EAGAIN)) return;
  if (device_ && size <= 0)
    throw hw::SourceError(name_ + ": the line hung up: is the device unplugged? plug it in and start again");
  if (size < 0) throw hw::RecordingError(name_ + ": cannot be read: " + std::strerror(errno));
  if (live_) arrival_ = now();
  counts_.bytes += static_cast<std::uint64_t>(size);
  ended_ = size == 0;
  text_.erase(0, std::exchange(line_begin_, 0));
  text_.append(bytes.data(), static_cast<std::size_t>(size));
  line_end_ = text_.find('\n');
  if (!ended_) return;
  cut_short_ = text_.find_first_not_of(" \t\r") != std::string::npos;
  if (frames_ == 0)
    throw hw::RecordingError(name_ + ": ended without a line of numbers; write a line for each frame" +
                             (first_bad_.empty() ? "" : "; the first line that is none: " + first_bad_));
}

/// s, of the frame at hand: of a file by its times, else when it was read.
void CsvSource::set_arrival() {
  if (time() && !(*time() >= 0 && *time() <= hw::csv_latest_time))
    lines_.refuse("time", fmt::format("{}", *time()), fmt::format("s, 0 to {:g}", hw::csv_latest_time));
  if (live_) return;
  if (!time()) {
    if (paced_) lines_.refuse("time", "none", "given: a header whose first name is \"time\"; or leave paced=1 out");
    arrival_ = seconds_since(opened_);
    return;
  }
  if (frames_ == 0) first_time_ = *time();
  const double arrival = *time() - first_time_;
  if (!(arrival >= arrival_ && arrival <= latest_arrival))
    lines_.refuse("time", fmt::format("{}", *time()),
                  fmt::format("that of the line above or later, within {:g} s of the first; sort the lines by time",
                              latest_arrival));
  arrival_ = arrival;
}

/// Whether the line is of the chosen sensor. Without a choice all lines have to be of one.
bool CsvSource::is_of_sensor() {
  const std::vector<std::string>& names = lines_.header();
  const auto column = std::ranges::find(names, "sensorid");
  if (column == names.end()) {
    if (chosen_) lines_.refuse("sensor", fmt::format("{}", *sensor_), "left out: no column is called sensor_id");
    return true;
  }
  const double id = lines_.numbers()[static_cast<std::size_t>(column - names.begin())];
  if (!sensor_) sensor_ = id;
  if (id != *sensor_ && !chosen_)
    lines_.refuse("sensor_id", fmt::format("{}", id),
                  fmt::format("{}, as above; csv:FILE?sensor={} takes the lines of one sensor", *sensor_, *sensor_));
  return id == *sensor_;
}

void CsvSource::count_bad(const std::string& why) {
  if (first_bad_.empty()) first_bad_ = why;
  if (++counts_.bad >= most_bad_at_first && frames_ == 0)
    throw hw::RecordingError(fmt::format("{}; so were all of the first {} lines", first_bad_, most_bad_at_first));
}

/// Takes the line at hand. One that is too long is dropped in pieces, and counts once.
void CsvSource::take_line() {
  try {
    if (!dropping_ && lines_.read(std::string_view(text_).substr(line_begin_, line_end_ - line_begin_), line_) &&
        is_of_sensor()) {
      set_arrival();
      hw::append_csv_frame(frames_++, time(), lines_.numbers().subspan(lines_.has_time()), packet_);
      if (port_) port_->answered();
    }
  } catch (const ConfigError& error) {
    if (!live_) throw hw::RecordingError(error.what());
    count_bad(error.what());
  }
  dropping_ = line_end_ == std::string::npos;
  if (!dropping_) ++line_;
  line_begin_ = dropping_ ? text_.size() : line_end_ + 1;
  line_end_ = text_.find('\n', line_begin_);
}

std::optional<hw::Packet> CsvSource::wait(double timeout) {
  if (!held_) {
    packet_.clear();
    int reads = 0;
    do {
      if (!has_line() && !ended_) fill(timeout);
      while (has_line() && (live_ || packet_.empty())) take_line();
    } while (!live_ && packet_.empty() && !ended_ && ++reads < most_reads);
    if (packet_.empty()) return std::nullopt;
  }
  held_ = !pace_.due(arrival_, timeout);
  if (held_) return std::nullopt;
  ++counts_.packets;
  pace_.hand_out(arrival_);
  return hw::Packet{packet_, arrival_, std::exchange(gap_, false)};
}

}  // namespace tactel::host
