// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <chrono>
#include <cstdint>
#include <string>

#include "hw/frame_source.h"

namespace tactel::hw {

/// A serial port that is open: raw, 8 data bits, no parity, one stop bit, no flow control. Others may open it, too; its
/// settings stay while one of them has it open.
class SerialPort {
 public:
  /// Throws SourceError, with what to do, where there is no such port, it may not be opened, or knows no such rate.
  SerialPort(const std::string& path, int baud);
  ~SerialPort();
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;
  int fd() const { return file_; }

 private:
  int file_;
};

/// The bytes of a serial port as they come.
class SerialSource final : public FrameSource {
 public:
  /// start: sent once the port is open, as UsbDevice::start. Throws SourceError as SerialPort, and where it is not
  /// sent.
  SerialSource(const std::string& path, int baud, Bytes start = {});
  /// Throws SourceError where the port hangs up, as that of an unplugged board.
  std::optional<Packet> wait(double timeout) override;
  bool finished() const override { return false; }
  bool live() const override { return true; }
  double now() const override {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - opened_).count();
  }
  TransportCounts counts() const override { return counts_; }
  int fd() const override { return port_.fd(); }

 private:
  std::string path_;
  SerialPort port_;
  std::array<std::uint8_t, 4096> bytes_{};  ///< of the last packet
  std::chrono::steady_clock::time_point opened_ = std::chrono::steady_clock::now();
  TransportCounts counts_;
};

}  // namespace tactel::hw
