// SPDX-License-Identifier: Apache-2.0
#include "hw/serial_source.h"

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace tactel::hw {
namespace {

constexpr std::array<std::pair<int, speed_t>, 12> rates = {{{9600, B9600},
                                                            {19200, B19200},
                                                            {38400, B38400},
                                                            {57600, B57600},
                                                            {115200, B115200},
                                                            {230400, B230400},
                                                            {460800, B460800},
                                                            {921600, B921600},
                                                            {1000000, B1000000},
                                                            {2000000, B2000000},
                                                            {3000000, B3000000},
                                                            {4000000, B4000000}}};

speed_t rate_of(const std::string& place, int baud) {
  std::string allowed;
  for (const auto& [number, speed] : rates) {
    if (number == baud) return speed;
    allowed += (allowed.empty() ? "" : ", ") + std::to_string(number);
  }
  throw SourceError(place + ": a rate of " + std::to_string(baud) + " baud; give one of " + allowed);
}

std::string why_not_open(int error) {
  if (error == EACCES) return "; add yourself to its group: sudo usermod -aG dialout $USER, then log in again";
  if (error == ENOENT) return "; is it plugged in? tactel devices lists what is";
  return "";
}

}  // namespace

SerialPort::SerialPort(const std::string& path, int baud) {
  const std::string place = "serial:" + path;
  const speed_t rate = rate_of(place, baud);
  file_ = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (file_ < 0) throw SourceError(place + ": cannot be opened: " + std::strerror(errno) + why_not_open(errno));
  termios settings{};
  const bool terminal = ::tcgetattr(file_, &settings) == 0;
  if (terminal) {
    ::cfmakeraw(&settings);
    settings.c_cflag = (settings.c_cflag & ~static_cast<tcflag_t>(CSTOPB | CRTSCTS)) | CLOCAL | CREAD;
  }
  if (terminal && ::cfsetspeed(&settings, rate) == 0 && ::tcsetattr(file_, TCSANOW, &settings) == 0 &&
      ::tcflush(file_, TCIFLUSH) == 0)
    return;
  const int error = errno;
  ::close(file_);
  throw SourceError(place + ": " + (terminal ? "cannot be set up: " : "is no serial port: ") + std::strerror(error));
}

SerialPort::~SerialPort() { ::close(file_); }

SerialSource::SerialSource(const std::string& path, int baud, Bytes start) : path_(path), port_(path, baud) {
  if (!start.empty() && ::write(port_.fd(), start.data(), start.size()) != static_cast<ssize_t>(start.size()))
    throw SourceError("serial:" + path + ": what starts the device cannot be sent: " + std::strerror(errno));
}

std::optional<Packet> SerialSource::wait(double timeout) {
  pollfd wanted{port_.fd(), POLLIN, 0};
  if (::poll(&wanted, 1, static_cast<int>(std::clamp(timeout, 0.0, 3600.0) * 1e3)) <= 0) return std::nullopt;
  const ssize_t size = ::read(port_.fd(), bytes_.data(), bytes_.size());
  if (size < 0 && (errno == EINTR || errno == EAGAIN)) return std::nullopt;
  if (size <= 0)
    throw SourceError("serial:" + path_ + ": the line hung up: is the device unplugged? plug it in and start again");
  ++counts_.packets, counts_.bytes += static_cast<std::uint64_t>(size);
  return Packet{Bytes(bytes_).first(static_cast<std::size_t>(size)), now()};
}

}  // namespace tactel::hw
