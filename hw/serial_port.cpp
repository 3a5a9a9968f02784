// SPDX-License-Identifier: Apache-2.0
#include "hw/serial_port.h"

#include <asm/termbits.h>  // any rate, which <termios.h> has not; the two exclude each other
#include <fcntl.h>
#include <sys/epoll.h>
#include <sys/ioctl.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

namespace tactel::hw {
namespace {

constexpr long look_every = 200'000'000;  // ns, while the device is away or has not answered
constexpr auto call_every = std::chrono::seconds(1);
constexpr double rate_error = 0.03;  // of which eight bits and a stop are read right

std::string why_not_open(int error) {
  if (error == EACCES) return "; add yourself to its group: sudo usermod -aG dialout $USER, then log in again";
  if (error == ENOENT) return "; is it plugged in? tactel devices lists what is";
  return "";
}

/// Makes the port raw, at a rate. Returns what is wrong, or nothing.
std::string set_up(int file, int baud) {
  termios2 settings{};
  if (::ioctl(file, TCGETS2, &settings) != 0) return std::string("is no serial port: ") + std::strerror(errno);
  settings.c_iflag = 0, settings.c_oflag = 0, settings.c_lflag = 0;
  settings.c_cflag = CS8 | CLOCAL | CREAD | BOTHER | (BOTHER << IBSHIFT);
  settings.c_cc[VMIN] = 1, settings.c_cc[VTIME] = 0;
  settings.c_ispeed = settings.c_ospeed = static_cast<speed_t>(baud);
  if (::ioctl(file, TCSETS2, &settings) != 0 || ::ioctl(file, TCFLSH, TCIFLUSH) != 0 ||
      ::ioctl(file, TCGETS2, &settings) != 0)
    return std::string("cannot be set up: ") + std::strerror(errno);
  if (std::abs(settings.c_ospeed - static_cast<double>(baud)) <= rate_error * baud) return "";
  return "makes no " + std::to_string(baud) + " baud but " + std::to_string(settings.c_ospeed) +
         "; give that of the device";
}

int watched(int events, int file) {
  epoll_event event{};
  event.events = EPOLLIN;
  return ::epoll_ctl(events, EPOLL_CTL_ADD, file, &event);
}

void arm(int timer, long every) {
  const itimerspec times{.it_interval = {0, every}, .it_value = {0, every}};
  ::timerfd_settime(timer, 0, &times, nullptr);
}

}  // namespace

SerialPort::SerialPort(std::string path, SerialSettings settings)
    : path_(std::move(path)),
      settings_(std::move(settings)),
      events_(::epoll_create1(EPOLL_CLOEXEC)),
      timer_(::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC)) {
  std::string wrong =
      settings_.baud > 0 ? "" : "a rate of " + std::to_string(settings_.baud) + " baud; give one above 0";
  if (wrong.empty() && (events_ < 0 || timer_ < 0 || watched(events_, timer_) != 0))
    wrong = std::string("no descriptor: ") + std::strerror(errno);
  if (wrong.empty()) wrong = open_port();
  if (!wrong.empty()) throw SourceError("serial:" + path_ + ": " + wrong);
}

/// Opens the port. Returns what is wrong, or nothing.
std::string SerialPort::open_port() {
  Descriptor file(::open(path_.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (file < 0) return std::string("cannot be opened: ") + std::strerror(errno) + why_not_open(errno);
  std::string wrong = set_up(file, settings_.baud);
  if (wrong.empty() && watched(events_, file) != 0) wrong = std::string("cannot be watched: ") + std::strerror(errno);
  if (!wrong.empty()) return wrong;
  file_ = std::move(file), answered_ = settings_.start.empty();
  next_call_ =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(settings_.wait));
  arm(timer_, answered_ ? 0 : look_every);
  call();
  return "";
}

/// Closes the port at once, so that its name is free for the device when it is back.
void SerialPort::hang_up() {
  file_.close();
  gap_ = true;
  arm(timer_, look_every);
}

/// Sends what starts the device where it is time to. One that takes it but in part, or not, hears it again.
void SerialPort::call() {
  if (answered_) return arm(timer_, 0);
  if (Clock::now() < next_call_) return;
  [[maybe_unused]] const auto sent = ::write(file_, settings_.start.data(), settings_.start.size());
  next_call_ = Clock::now() + call_every;
}

Bytes SerialPort::read(double timeout) {
  epoll_event event{};
  if (::epoll_wait(events_, &event, 1, static_cast<int>(std::clamp(timeout, 0.0, 3600.0) * 1e3)) <= 0) return {};
  std::uint64_t ticks = 0;
  const bool ticked = ::read(timer_, &ticks, sizeof ticks) > 0;
  if (file_ < 0) {
    if (ticked && open_port().empty()) ++reconnects_;
    return {};
  }
  if (ticked) call();
  const ssize_t size = ::read(file_, bytes_.data(), bytes_.size());
  if (size > 0) return Bytes(bytes_).first(static_cast<std::size_t>(size));
  if (size == 0 || (errno != EINTR && errno != EAGAIN)) hang_up();
  return {};
}

std::optional<Packet> SerialSource::wait(double timeout) {
  const Bytes bytes = port_.read(timeout);
  if (bytes.empty()) return std::nullopt;
  ++counts_.packets, counts_.bytes += bytes.size();
  return Packet{bytes, now(), port_.take_gap()};
}

TransportCounts SerialSource::counts() const {
  TransportCounts counts = counts_;
  counts.reconnects = port_.reconnects();
  return counts;
}

}  // namespace tactel::hw
