// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <deque>
#include <mutex>
#include <optional>

#include "tests/hw/byte_vectors.h"

namespace tactel::hw::tests {

/// What the device does when it is asked for a packet.
enum class Answer { data, stall, babble, protocol_error };
struct InPacket {
  Answer answer = Answer::data;
  ByteVector bytes{};
};

/// Of a control transfer, as on the wire (USB 2.0, 9.3).
struct Setup {
  std::uint8_t type = 0, request = 0;
  std::uint16_t value = 0, index = 0, length = 0;
};

/// How the glove presents itself: as CDC serial port (bulk endpoint), or with one interrupt endpoint.
enum class Face { serial_port, interrupt_endpoint };

/// A glove without a transport: its descriptors, what it answers to control requests, and the packets it will send. A
/// test fills it and a transport empties it, in threads of their own.
class DeviceModel {
 public:
  explicit DeviceModel(Face face = Face::serial_port);
  ~DeviceModel();
  DeviceModel(const DeviceModel&) = delete;
  DeviceModel& operator=(const DeviceModel&) = delete;

  /// Queues a stream, cut into packets; these come in the order of the calls.
  void send(const ByteVector& stream, std::size_t packet = full_packet);
  void send_packet(ByteVector bytes);  ///< as it is; may be empty
  void fail_once(Answer answer);       ///< instead of a packet; what comes after a stall waits until it is cleared
  void forget();                       ///< the power went

  bool has_dtr() const { return dtr_; }

  /// For a transport: the next packet, none while the device is silent. A halted endpoint stalls.
  std::optional<InPacket> next();
  /// What an IN request answers, empty for an OUT request with its data; none: the device stalls it.
  std::optional<ByteVector> control(const Setup& setup, Bytes data);
  /// Readable from each send on until `next` has been asked.
  int ready_fd() const { return ready_fd_; }

  const ByteVector& device_descriptor() const { return device_; }
  const ByteVector& configuration() const { return configuration_; }  ///< with interfaces and endpoints
  std::uint8_t data_endpoint() const { return data_endpoint_; }       ///< its address

  static constexpr std::size_t full_packet = 64;

 private:
  void queue(InPacket packet);
  std::mutex mutex_;
  std::deque<InPacket> queue_;
  bool halted_ = false;
  std::atomic<bool> dtr_{false};
  ByteVector device_, configuration_;
  std::uint8_t data_endpoint_;
  int ready_fd_;
};

}  // namespace tactel::hw::tests
