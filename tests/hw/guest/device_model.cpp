// SPDX-License-Identifier: Apache-2.0
#include "tests/hw/guest/device_model.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>

namespace tactel::hw::tests {
namespace {

// USB 2.0, 9.6.1: 04D8:000A, one configuration. Class CDC for the serial port, given by the interfaces else.
ByteVector device_of(Face face) {
  const std::uint8_t kind = face == Face::serial_port ? 2 : 0;
  return {18, 1, 0x00, 0x02, kind, 0, 0, 64, 0xD8, 0x04, 0x0A, 0x00, 0x00, 0x01, 0, 0, 0, 1};
}

// Interface 0: CDC with its interrupt endpoint 82, 8 B. Interface 1: data, endpoints 03 OUT and 83 IN, 64 B.
const ByteVector serial_port = {9, 2,  67,   0,    2,    1,  0,  0x80, 50,                                     //
                                9, 4,  0,    0,    1,    2,  2,  1,    0,                                      //
                                5, 36, 0,    0x10, 0x01, 5,  36, 1,    0,  1,    4, 36, 2, 2, 5, 36, 6, 0, 1,  //
                                7, 5,  0x82, 3,    8,    0,  16,                                               //
                                9, 4,  1,    0,    2,    10, 0,  0,    0,                                      //
                                7, 5,  0x03, 2,    64,   0,  0,  7,    5,  0x83, 2, 64, 0, 0};
// One interface of the vendor's own class, endpoint 81 interrupt IN, 64 B each millisecond.
const ByteVector interrupt_endpoint = {9, 2,    25, 0, 1, 1, 0, 0x80, 50, 9,  4, 0, 0,
                                       1, 0xFF, 0,  0, 0, 7, 5, 0x81, 3,  64, 0, 1};

ByteVector first(const ByteVector& bytes, std::size_t length) {
  return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(std::min(length, bytes.size()))};
}

}  // namespace

DeviceModel::DeviceModel(Face face)
    : device_(device_of(face)),
      configuration_(face == Face::serial_port ? serial_port : interrupt_endpoint),
      data_endpoint_(face == Face::serial_port ? 0x83 : 0x81),
      ready_fd_(eventfd(0, EFD_NONBLOCK)) {}

DeviceModel::~DeviceModel() { close(ready_fd_); }

void DeviceModel::queue(InPacket packet) {
  const std::lock_guard lock(mutex_);
  queue_.push_back(std::move(packet));
  eventfd_write(ready_fd_, 1);
}

void DeviceModel::send_packet(ByteVector bytes) { queue({.bytes = std::move(bytes)}); }
void DeviceModel::fail_once(Answer answer) { queue({.answer = answer}); }

void DeviceModel::send(const ByteVector& stream, std::size_t packet) {
  for (std::size_t at = 0; at < stream.size(); at += packet) {
    const Bytes part = Bytes(stream).subspan(at, std::min(packet, stream.size() - at));
    send_packet({part.begin(), part.end()});
  }
}

void DeviceModel::forget() {
  const std::lock_guard lock(mutex_);
  queue_.clear();
  halted_ = dtr_ = false;
}

std::optional<InPacket> DeviceModel::next() {
  const std::lock_guard lock(mutex_);
  if (halted_) return InPacket{.answer = Answer::stall};
  if (queue_.empty()) {
    eventfd_t sent;
    eventfd_read(ready_fd_, &sent);
    return std::nullopt;
  }
  InPacket packet = std::move(queue_.front());
  queue_.pop_front();
  halted_ = packet.answer == Answer::stall;
  return packet;
}

// USB 2.0, 9.4, as far as Linux asks a full-speed device; CDC PSTN 1.2, 6.3.
std::optional<ByteVector> DeviceModel::control(const Setup& setup, Bytes data) {
  const std::lock_guard lock(mutex_);
  switch (setup.type << 8 | setup.request) {
    case 0x8006:  // GET_DESCRIPTOR; it has no strings and no other speed
      if (setup.value >> 8 == 1) return first(device_, setup.length);
      if (setup.value >> 8 == 2) return first(configuration_, setup.length);
      return std::nullopt;
    case 0x8000:  // GET_STATUS of the device
      return ByteVector{0, 0};
    case 0x0009:  // SET_CONFIGURATION
    case 0x010B:  // SET_INTERFACE
      return ByteVector{};
    case 0x0201:  // CLEAR_FEATURE: the endpoint's halt
      if (setup.index == data_endpoint_) halted_ = false;
      return ByteVector{};
    case 0x2120:  // SET_LINE_CODING
      return data.size() == 7 ? std::optional<ByteVector>(ByteVector{}) : std::nullopt;
    case 0x2122:  // SET_CONTROL_LINE_STATE
      dtr_ = setup.value & 1;
      return ByteVector{};
    default:
      return std::nullopt;
  }
}

}  // namespace tactel::hw::tests
