// SPDX-License-Identifier: Apache-2.0
#include "host/live/csv_source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "hw/csv_format.h"

namespace tactel::host {
namespace {

constexpr std::size_t bytes_of_file = 1 << 16;
constexpr std::size_t bytes_of_pipe = 1 << 12;  // few: what waits in the pipe has not arrived yet, and is not late
constexpr double latest_arrival = 1e9;          // s, as of recordings

std::string_view trimmed(std::string_view text) {
  const auto outer = [](char c) { return c == ' ' || c == '\r'; };
  while (!text.empty() && outer(text.front())) text.remove_prefix(1);
  while (!text.empty() && outer(text.back())) text.remove_suffix(1);
  return text;
}

/// A number in all of `text`, also one that is not finite; none for other texts.
std::optional<double> number_in(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || end != text.data() + text.size()) return std::nullopt;
  return error == std::errc{} ? value : std::numeric_limits<double>::infinity();
}

/// For a message: no control characters, and not too long.
std::string shown(std::string_view text) {
  std::string result(text.substr(0, 40));
  for (char& c : result)
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '?';
  return result + (text.size() > 40 ? "..." : "");
}

/// "time", also as numpy ("# time") and programs that quote have it.
bool is_time(std::string_view name) {
  std::string bare;
  for (const char c : name)
    if (c != '"' && c != '\'' && c != '#' && c != ' ') bare += static_cast<char>(c | ('A' <= c && c <= 'Z' ? 0x20 : 0));
  return bare == "time";
}

}  // namespace

void CsvLines::refuse(std::uint64_t number, const std::string& what) const {
  throw hw::RecordingError(fmt::format("{}:{}: {}", name_, number, what));
}

std::string CsvLines::expected() const {
  return fmt::format("a line has {} numbers, one for each of the profile's channels{}", channels_ + has_time_,
                     has_time_ ? ", behind the time" : "");
}

/// Whether the first line is a header. Its names say whether lines have a time.
bool CsvLines::is_header(std::uint64_t number) {
  if (number_in(fields_.front())) return false;
  has_time_ = is_time(fields_.front());
  if (fields_.size() == channels_ + has_time_) return true;
  refuse(number, fmt::format("the header has {} names; {}, and a time is first and called \"time\"", fields_.size(),
                             expected()));
}

bool CsvLines::read(std::string_view line, std::uint64_t number) {
  if (line.size() > longest()) refuse(number, fmt::format("longer than {} bytes; {}", longest(), expected()));
  if (number == 1 && line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
  line = trimmed(line);
  if (line.empty()) return false;
  fields_.clear();
  for (std::size_t from = 0; from <= line.size();) {
    const std::size_t end = std::min(line.find_first_of(",;\t", from), line.size());
    fields_.push_back(trimmed(line.substr(from, end - from)));
    from = end + 1;
  }
  if (!begun_ && is_header(number)) {
    begun_ = true;
    return false;
  }
  if (fields_.size() != channels_ + has_time_) refuse(number, fmt::format("{} fields; {}", fields_.size(), expected()));
  numbers_.resize(fields_.size());
  for (std::size_t column = 0; column < fields_.size(); ++column) {
    const auto value = number_in(fields_[column]);
    if (!value || !(std::abs(*value) <= std::numeric_limits<float>::max()))
      refuse(number, fmt::format("column {} is \"{}\"; write a finite number such as -1.5", column + 1,
                                 shown(fields_[column])));
    numbers_[column] = *value;
  }
  if (has_time_ && !(numbers_[0] >= 0 && numbers_[0] <= hw::csv_latest_time))
    refuse(number, fmt::format("the time is {}; write s, 0 to {:g}", numbers_[0], hw::csv_latest_time));
  return begun_ = true;
}

CsvSource::CsvSource(const std::string& path, std::size_t channels, bool paced)
    : name_("csv:" + path), lines_(name_, channels), paced_(paced), pace_(paced) {
  // Without O_NONBLOCK a named pipe would wait for its writer here, and no signal could end that.
  file_ = path == "-" ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  struct stat status {};
  if (file_ < 0 || ::fstat(file_, &status) != 0)
    throw hw::RecordingError(name_ + ": cannot be read: " + std::strerror(errno));
  live_ = !S_ISREG(status.st_mode);
  if (live_ && paced) throw hw::RecordingError(name_ + ": has a pace of its own; leave paced=1 out");
}

CsvSource::~CsvSource() {
  if (file_ > STDIN_FILENO) ::close(file_);
}

/// Reads more text, of a pipe once and within `timeout` s.
void CsvSource::fill(double timeout) {
  if (live_) {
    pollfd wanted{file_, POLLIN, 0};
    if (::poll(&wanted, 1, static_cast<int>(std::clamp(timeout, 0.0, 3600.0) * 1e3)) <= 0) return;
  }
  std::array<char, bytes_of_file> bytes;
  const ssize_t size = ::read(file_, bytes.data(), live_ ? bytes_of_pipe : bytes_of_file);
  if (size < 0 && (errno == EINTR || errno == EAGAIN)) return;
  if (size < 0) throw hw::RecordingError(name_ + ": cannot be read: " + std::strerror(errno));
  if (live_) arrival_ = now();
  counts_.bytes += static_cast<std::uint64_t>(size);
  ended_ = size == 0;
  text_.append(bytes.data(), static_cast<std::size_t>(size));
  find_line();
  if (!ended_) return;
  cut_short_ = !trimmed(text_).empty();
  if (frames_ == 0) throw hw::RecordingError(name_ + ": ended without a line of numbers; write a line for each frame");
}

void CsvSource::find_line() {
  line_end_ = text_.find('\n');
  if (line_end_ == std::string::npos && text_.size() > lines_.longest()) lines_.read(text_, line_);  // refuses it
}

/// s, of the frame at hand: of a file by its times, else when it was read.
void CsvSource::set_arrival() {
  if (live_) return;
  if (!lines_.time()) {
    if (paced_) lines_.refuse(line_, "no time; write a header whose first name is \"time\", or leave paced=1 out");
    arrival_ = seconds_since(opened_);
    return;
  }
  if (frames_ == 0) first_time_ = *lines_.time();
  const double arrival = *lines_.time() - first_time_;
  if (!(arrival >= arrival_ && arrival <= latest_arrival))
    lines_.refuse(line_, fmt::format("the time {} is earlier than that of a line above, or {:g} s later than the "
                                     "first; sort the lines by time",
                                     *lines_.time(), latest_arrival));
  arrival_ = arrival;
}

/// Takes the first line of the text. Returns false where it is no frame and others wait in front of it.
bool CsvSource::take_line() {
  try {
    if (lines_.read(std::string_view(text_).substr(0, line_end_), line_)) {
      set_arrival();
      hw::append_csv_frame(frames_++, lines_.time(), lines_.values(), packet_);
    }
  } catch (const hw::RecordingError&) {
    if (packet_.empty()) throw;
    return false;
  }
  text_.erase(0, line_end_ + 1);
  ++line_;
  find_line();
  return true;
}

std::optional<hw::Packet> CsvSource::wait(double timeout) {
  if (!held_) {
    packet_.clear();
    do {
      if (line_end_ == std::string::npos && !ended_) fill(timeout);
      while (line_end_ != std::string::npos && (live_ || packet_.empty()) && take_line()) {
      }
    } while (!live_ && packet_.empty() && !ended_);
    if (packet_.empty()) return std::nullopt;
  }
  held_ = !pace_.due(arrival_, timeout);
  if (held_) return std::nullopt;
  ++counts_.packets;
  pace_.hand_out(arrival_);
  return hw::Packet{packet_, arrival_};
}

}  // namespace tactel::host
