// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "hw/descriptor.h"
#include "hw/frame_source.h"

namespace tactel::hw {

struct SerialSettings {
  int baud = 115200;                  ///< any that the port makes within 3 %
  std::vector<std::uint8_t> start{};  ///< sent when the port is open, and each second until the device has answered
  double wait = 0;                    ///< s from opening until `start`: a board that boots hears nothing
};

/// A serial port that is open: raw, 8 data bits, no parity, one stop bit, no flow control. One that hangs up, as that
/// of an unplugged board, is opened again when it is back.
class SerialPort {
 public:
  /// Throws SourceError, with what to do, where there is no such port, it may not be opened, or makes no such rate.
  SerialPort(std::string path, SerialSettings settings);

  /// Returns what came within `timeout` s, valid until the next call; mostly empty where the port waits for its device.
  Bytes read(double timeout);
  /// Tells that a frame came: what starts the device has been heard.
  void answered() { answered_ = true; }
  /// Returns whether the device was away since the last call.
  bool take_gap() { return std::exchange(gap_, false); }
  std::uint64_t reconnects() const { return reconnects_; }
  int fd() const { return events_; }  ///< readable while there is something to do; the same also after a gap

 private:
  using Clock = std::chrono::steady_clock;
  std::string open_port();
  void hang_up();
  void call();

  std::string path_;
  SerialSettings settings_;
  Descriptor events_, timer_, file_;  ///< an epoll of the next two; file_: -1 while the device is away
  Clock::time_point next_call_{};
  bool answered_ = false, gap_ = false;
  std::uint64_t reconnects_ = 0;
  std::array<std::uint8_t, 4096> bytes_{};
};

/// The bytes of a serial port as they come. Waits for an unplugged device.
class SerialSource final : public FrameSource {
 public:
  /// Throws SourceError as SerialPort.
  SerialSource(std::string path, SerialSettings settings) : port_(std::move(path), std::move(settings)) {}
  std::optional<Packet> wait(double timeout) override;
  void answered() override { port_.answered(); }
  bool finished() const override { return false; }
  bool live() const override { return true; }
  double now() const override {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - opened_).count();
  }
  TransportCounts counts() const override;
  int fd() const override { return port_.fd(); }

 private:
  SerialPort port_;
  std::chrono::steady_clock::time_point opened_ = std::chrono::steady_clock::now();
  TransportCounts counts_;
};

}  // namespace tactel::hw
