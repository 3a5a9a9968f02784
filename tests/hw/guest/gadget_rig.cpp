// SPDX-License-Identifier: Apache-2.0

// A USB gadget made of FunctionFS files (kernel: Documentation/usb/functionfs.rst), its cable dummy_hcd's. The kernel
// answers the requests that are the same for every device; to us come those of the class, and the data.
#include <endian.h>
#include <fcntl.h>
#include <linux/usb/functionfs.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/mount.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>

#include "tests/hw/guest/rig.h"

namespace tactel::hw::tests {
namespace {

namespace fs = std::filesystem;

const fs::path configfs = "/sys/kernel/config", gadget = configfs / "usb_gadget/glove", files = "/run/glove";

void write_text(const fs::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text << std::flush;
  if (!out) throw std::runtime_error(file.string() + " does not take " + text);
}

int open_file(const std::string& name, int flags = 0) {
  const int file = open((files / name).c_str(), O_RDWR | flags);
  if (file < 0) throw std::runtime_error("FunctionFS has no " + name);
  return file;
}

void write_bytes(int file, const ByteVector& bytes) {
  if (write(file, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
    throw std::runtime_error("FunctionFS does not take the descriptors");
}

/// Interfaces and endpoints of the model's configuration, as FunctionFS takes them for full speed; it knows no class's
/// own.
ByteVector descriptors(const ByteVector& configuration) {
  ByteVector kept;
  std::uint32_t count = 0;
  for (std::size_t at = configuration[0]; at < configuration.size(); at += configuration[at]) {
    const std::uint8_t kind = configuration[at + 1];
    if (kind != 4 && kind != 5) continue;
    for (std::size_t i = 0; i < configuration[at]; ++i) kept.push_back(configuration[at + i]);
    ++count;
  }
  ByteVector all;
  for (const std::size_t word : {std::size_t{FUNCTIONFS_DESCRIPTORS_MAGIC_V2}, 16 + kept.size(),
                                 std::size_t{FUNCTIONFS_HAS_FS_DESC}, std::size_t{count}})
    put(all, word, 4);
  append(all, kept);
  return all;
}

ByteVector no_strings() {
  ByteVector all;
  for (const std::uint64_t word :
       {std::uint64_t{FUNCTIONFS_STRINGS_MAGIC}, std::uint64_t{16}, std::uint64_t{0}, std::uint64_t{0}})
    put(all, word, 4);
  return all;
}

class GadgetRig final : public Rig {
 public:
  explicit GadgetRig(DeviceModel& model) : model_(model), stop_(eventfd(0, 0)) {
    compose();
    control_ = open_file("ep0");
    write_bytes(control_, descriptors(model.configuration()));
    write_bytes(control_, no_strings());
    // In the order of their descriptors: 82, 03, 83 of the serial port. Linux gives them numbers of its own.
    // Not to wait for an endpoint of a device that is unplugged; what is on its way is waited for all the same.
    data_ = open_file(model.data_endpoint() == 0x83 ? "ep3" : "ep1", O_NONBLOCK);
    threads_[0] = std::thread([this] { serve_control(); });
  }

  ~GadgetRig() override {
    if (plugged_) unplug();
    eventfd_write(stop_, 1);
    threads_[0].join();
    for (const int file : {data_, control_, stop_}) close(file);
    dissolve();
  }

  void plug_in() override {
    plugged_ = true;
    write_text(gadget / "UDC", "dummy_udc.0");
    wait_for_device(true);
    threads_[1] = std::thread([this] { send_data(); });
  }

  // What is being written comes back with an error then.
  void unplug() override {
    plugged_ = false;
    write_text(gadget / "UDC", "\n");
    model_.fail_once(Answer::data);  // wakes the sender; forgotten below
    threads_[1].join();
    model_.forget();
    wait_for_device(false);
  }

 private:
  static void compose() {
    if (!fs::exists(configfs / "usb_gadget")) mount("none", configfs.c_str(), "configfs", 0, nullptr);
    fs::create_directory(gadget);
    write_text(gadget / "idVendor", "0x04d8");
    write_text(gadget / "idProduct", "0x000a");
    fs::create_directory(gadget / "configs/c.1");
    fs::create_directory(gadget / "functions/ffs.glove");
    fs::create_symlink(gadget / "functions/ffs.glove", gadget / "configs/c.1/ffs.glove");
    fs::create_directories(files);
    if (mount("glove", files.c_str(), "functionfs", 0, nullptr) != 0)
      throw std::runtime_error("FunctionFS cannot be mounted");
  }

  static void dissolve() {
    umount(files.c_str());
    fs::remove(gadget / "configs/c.1/ffs.glove");
    for (const char* folder : {"configs/c.1", "functions/ffs.glove", ""}) rmdir((gadget / folder).c_str());
  }

  void serve_control() {
    std::array<pollfd, 2> wanted{pollfd{stop_, POLLIN, 0}, pollfd{control_, POLLIN, 0}};
    while (poll(wanted.data(), wanted.size(), -1) > 0 && wanted[0].revents == 0) {
      usb_functionfs_event event;
      if (read(control_, &event, sizeof event) != sizeof event) continue;
      if (event.type == FUNCTIONFS_SETUP) answer(event.u.setup);
    }
  }

  void answer(const usb_ctrlrequest& in) {
    const Setup setup{in.bRequestType, in.bRequest, le16toh(in.wValue), le16toh(in.wIndex), le16toh(in.wLength)};
    ByteVector data(setup.length);
    const bool to_host = setup.type & 0x80;
    if (!to_host && read(control_, data.data(), data.size()) < 0) return;  // with no data it ends the request
    const auto reply = model_.control(setup, to_host ? Bytes{} : Bytes(data));
    if (to_host && reply && write(control_, reply->data(), reply->size()) < 0) return;
  }

  void send_data() {
    pollfd wanted{model_.ready_fd(), POLLIN, 0};
    while (plugged_ && poll(&wanted, 1, -1) > 0) {
      for (auto packet = model_.next(); packet && plugged_; packet = model_.next()) put_packet(*packet);
    }
  }

  // Reading from an endpoint that writes halts it.
  void put_packet(const InPacket& packet) {
    std::uint8_t nothing;
    if (packet.answer == Answer::stall) {
      if (read(data_, &nothing, 1) < 0 && errno == EBADMSG)
        model_.control({0x02, 0x01, 0, model_.data_endpoint(), 0}, {});
    } else if (write(data_, packet.bytes.data(), packet.bytes.size()) < 0 && plugged_) {
      std::perror("writing a packet to FunctionFS");
    }
  }

  DeviceModel& model_;
  int stop_, control_ = -1, data_ = -1;
  std::atomic<bool> plugged_{false};
  std::array<std::thread, 2> threads_;
};

}  // namespace

std::unique_ptr<Rig> gadget_rig(DeviceModel& model) { return std::make_unique<GadgetRig>(model); }

}  // namespace tactel::hw::tests
