// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <string>

#include "hw/frame_source.h"
#include "hw/serial_port.h"

namespace tactel::hw {

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
