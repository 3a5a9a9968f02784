// SPDX-License-Identifier: Apache-2.0

// The URB protocol of usbip (kernel: Documentation/usb/usbip_protocol.rst) on a socket pair whose other end vhci-hcd
// has.
#include <endian.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "tests/hw/guest/rig.h"

namespace tactel::hw::tests {
namespace {

constexpr std::uint32_t cmd_submit = 1, cmd_unlink = 2, ret_submit = 3, ret_unlink = 4;
constexpr int full_speed = 2;  // enum usb_device_speed

/// Head of each message: 12 big-endian words. 0: command, 1: sequence number, 3: 1 is IN, 4: endpoint; then of a
/// submit 6: length, 10 and 11: the setup bytes; of an unlink 5: whose; of an answer 5: status, 6: length.
using Head = std::array<std::uint32_t, 12>;

bool read_all(int socket, void* to, std::size_t length) {
  return recv(socket, to, length, MSG_WAITALL) == static_cast<ssize_t>(length);
}

int status_of(Answer answer) {
  if (answer == Answer::stall) return -EPIPE;
  if (answer == Answer::babble) return -EOVERFLOW;
  return answer == Answer::protocol_error ? -EPROTO : 0;
}

Setup setup_of(const Head& head) {
  std::array<std::uint8_t, 8> b;
  std::memcpy(b.data(), &head[10], b.size());
  const auto word = [&](std::size_t i) { return static_cast<std::uint16_t>(b[i] | b[i + 1] << 8); };
  return {b[0], b[1], word(2), word(4), word(6)};
}

class VhciRig final : public Rig {
 public:
  explicit VhciRig(DeviceModel& model) : model_(model), stop_(eventfd(0, 0)) {}
  ~VhciRig() override {
    if (thread_.joinable()) unplug();
    close(stop_);
  }

  void plug_in() override {
    int pair[2];
    if (socketpair(AF_UNIX, SOCK_STREAM, 0, pair) != 0) throw std::runtime_error("no socket pair");
    socket_ = pair[0];
    attach(pair[1]);
    close(pair[1]);  // the kernel has its own reference
    thread_ = std::thread([this] { serve(); });
    wait_for_device(true);
  }

  // Without warning: the other end finds the line dead.
  void unplug() override {
    eventfd_write(stop_, 1);
    thread_.join();
    eventfd_t stopped;
    eventfd_read(stop_, &stopped);
    close(socket_);
    pending_.clear();
    unanswered_.clear();
    model_.forget();
    wait_for_device(false);
  }

 private:
  // A port that was just given up is busy for a while.
  static void attach(int socket) {
    for (int tries = 0; tries < 1000; ++tries) {
      std::ofstream file("/sys/devices/platform/vhci_hcd.0/attach");
      file << "0 " << socket << " 65538 " << full_speed << std::flush;
      if (file) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    throw std::runtime_error("vhci-hcd takes no device");
  }

  void serve() {
    std::array<pollfd, 3> wanted{pollfd{socket_, POLLIN, 0}, pollfd{stop_, POLLIN, 0},
                                 pollfd{model_.ready_fd(), POLLIN, 0}};
    while (poll(wanted.data(), wanted.size(), -1) > 0 || errno == EINTR) {
      if (wanted[1].revents != 0) return;
      if (wanted[0].revents != 0 && !take_message()) return;
      answer_pending();
      // Nobody asks: what the model has must not wake us until somebody does.
      wanted[2].fd = pending_.empty() ? -1 : model_.ready_fd();
    }
  }

  bool take_message() {
    Head head;
    if (!read_all(socket_, head.data(), sizeof head)) return false;
    for (std::size_t i = 0; i < 10; ++i) head[i] = be32toh(head[i]);
    if (head[0] == cmd_unlink) {
      unlink(head);
      return true;
    }
    const bool in = head[3] == 1;
    ByteVector data(in ? 0 : head[6]);
    if (!data.empty() && !read_all(socket_, data.data(), data.size())) return false;
    if (head[4] == 0) {
      const auto answer = model_.control(setup_of(head), data);
      answer_submit(head[1], answer ? 0 : -EPIPE, answer.value_or(ByteVector{}), in ? 0 : data.size());
    } else if (in) {
      (head[4] == (model_.data_endpoint() & 0x0Fu) ? pending_ : unanswered_).push_back(head[1]);
    } else {
      answer_submit(head[1], 0, {}, data.size());
    }
    return true;
  }

  void answer_pending() {
    while (!pending_.empty()) {
      const auto packet = model_.next();
      if (!packet) return;
      answer_submit(pending_.front(), status_of(packet->answer), packet->bytes, 0);
      pending_.pop_front();
    }
  }

  void answer_submit(std::uint32_t sequence, int status, const ByteVector& bytes, std::size_t taken) {
    Head head{ret_submit, sequence};
    head[5] = static_cast<std::uint32_t>(status);
    head[6] = static_cast<std::uint32_t>(bytes.size() + taken);
    put(head, bytes);
  }

  // A request that was answered before it was taken back is not here any more: status 0.
  void unlink(const Head& command) {
    const bool here = std::erase(pending_, command[5]) + std::erase(unanswered_, command[5]) > 0;
    Head head{ret_unlink, command[1]};
    head[5] = static_cast<std::uint32_t>(here ? -ECONNRESET : 0);
    put(head, {});
  }

  void put(Head head, const ByteVector& bytes) {
    for (std::uint32_t& word : head) word = htobe32(word);
    ByteVector message(sizeof head);
    std::memcpy(message.data(), head.data(), sizeof head);
    append(message, bytes);
    if (send(socket_, message.data(), message.size(), MSG_NOSIGNAL) < 0) return;  // the kernel has let go of the line
  }

  DeviceModel& model_;
  int socket_ = -1, stop_;
  std::deque<std::uint32_t> pending_;     ///< sequence numbers of requests for the next packet
  std::deque<std::uint32_t> unanswered_;  ///< and to the serial port's interrupt endpoint, which has nothing to say
  std::thread thread_;
};

}  // namespace

std::unique_ptr<Rig> vhci_rig(DeviceModel& model) { return std::make_unique<VhciRig>(model); }

}  // namespace tactel::hw::tests
