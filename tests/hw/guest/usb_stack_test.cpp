// SPDX-License-Identifier: Apache-2.0

// The USB source on a real kernel's USB stack: usbfs, hubs, drivers. Runs in the guest that run_guest starts.
#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <numeric>

#include "hw/formats.h"
#include "hw/usb_source.h"
#include "tests/hw/guest/rig.h"
#include "tests/thrown_message.h"

namespace tactel::hw::tests {
namespace {

using Clock = std::chrono::steady_clock;
using ::testing::HasSubstr;

constexpr double patience = 30;  // s: the guest may be slow; only what has gone wrong takes so long

const UsbDevice serial_glove{.vendor = 0x04D8, .product = 0x000A, .transport = Transport::cdc_acm};
const UsbDevice interrupt_glove{.vendor = 0x04D8, .product = 0x000A, .transport = Transport::bulk};

ByteVector frames(int count, int first = 0) {
  ByteVector stream;
  for (int i = 0; i < count; ++i) append(stream, glove_frame(first + i));
  return stream;
}

/// The first cells of frames `first` and on, as glove_frame numbers them.
std::vector<double> cells(int count, int first = 0) {
  std::vector<double> numbers(static_cast<std::size_t>(count));
  std::iota(numbers.begin(), numbers.end(), first);
  for (double& number : numbers) number = 4095 - number;
  return numbers;
}

std::vector<double> operator+(std::vector<double> a, const std::vector<double>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

struct Reader {
  Decoder decoder{glove_format()};
  std::vector<double> first_cells;

  /// Until `count` frames are there.
  void read(FrameSource& source, std::uint64_t count) {
    read_until(source, [&] { return decoder.counts().frames >= count; });
  }
  template <class Done>
  void read_until(FrameSource& source, Done done) {
    const auto end = Clock::now() + std::chrono::duration<double>(patience);
    while (!done() && Clock::now() < end) {
      const auto packet = source.wait(0.02);
      if (!packet) continue;
      if (packet->after_gap) decoder.interrupt();
      decoder.feed(packet->bytes, [&](const DecodedFrame& frame) { first_cells.push_back(frame.values[0]); });
    }
  }
};

/// Whether the device hears of DTR; the gadget's thread reads the request some time after the host has sent it.
bool hears_dtr(const DeviceModel& model) {
  const auto end = Clock::now() + std::chrono::duration<double>(patience);
  while (!model.has_dtr() && Clock::now() < end) usleep(1000);
  return model.has_dtr();
}

using MakeRig = std::unique_ptr<Rig> (*)(DeviceModel&);

/// A glove that is plugged in.
struct Plugged {
  explicit Plugged(MakeRig make, Face face = Face::serial_port) : model(face), rig(make(model)) { rig->plug_in(); }
  DeviceModel model;
  std::unique_ptr<Rig> rig;
};

struct RigCase {
  MakeRig make;
  int returns;  ///< how often the device is plugged in again and again
};

class UsbStack : public ::testing::TestWithParam<RigCase> {};
INSTANTIATE_TEST_SUITE_P(Vhci, UsbStack, ::testing::Values(RigCase{vhci_rig, 10}));  // a second each, on eight ports
INSTANTIATE_TEST_SUITE_P(NightlyVhci, UsbStack, ::testing::Values(RigCase{vhci_rig, 50}));
INSTANTIATE_TEST_SUITE_P(Gadget, UsbStack, ::testing::Values(RigCase{gadget_rig, 10}));

TEST_P(UsbStack, Clean) {
  Plugged glove(GetParam().make);
  Reader reader;
  const auto source = open_usb(serial_glove);
  EXPECT_TRUE(hears_dtr(glove.model));
  glove.model.send(frames(200));
  reader.read(*source, 200);
  EXPECT_EQ(reader.decoder.counts(), (DecoderCounts{.frames = 200}));
  EXPECT_EQ(reader.first_cells, cells(200));
  EXPECT_EQ(source->counts().packets, 1000u);
  EXPECT_EQ(source->counts().bytes, 64000u);
}

TEST_P(UsbStack, Interrupt) {
  Plugged glove(GetParam().make, Face::interrupt_endpoint);
  Reader reader;
  const auto source = open_usb(interrupt_glove);
  glove.model.send(frames(60));
  reader.read(*source, 60);
  EXPECT_EQ(reader.first_cells, cells(60));
  EXPECT_EQ(source->counts().packets, 300u);
}

TEST_P(UsbStack, ShortPackets) {
  Plugged glove(GetParam().make);
  Reader reader;
  const auto source = open_usb(serial_glove);
  glove.model.send(frames(20), 33);  // no divisor of a frame's 320 B
  glove.model.send_packet({});
  glove.model.send(frames(2, 20), 1);
  reader.read(*source, 22);
  EXPECT_EQ(reader.decoder.counts(), (DecoderCounts{.frames = 22}));
  EXPECT_EQ(reader.first_cells, cells(22));
  EXPECT_EQ(source->counts().packets, 194u + 640u);  // 20 320 / 33 rounded up; what is empty is none
}

TEST_P(UsbStack, Dropped) {
  Plugged glove(GetParam().make);
  Reader reader;
  const auto source = open_usb(serial_glove);
  ByteVector stream = frames(20);
  stream.erase(stream.begin() + 52 * 64, stream.begin() + 53 * 64);  // packet 52: of frame 10
  glove.model.send(stream);
  reader.read(*source, 19);
  EXPECT_EQ(reader.decoder.counts(), (DecoderCounts{.frames = 19, .bad = 1, .resynchronised = 1, .discarded = 256}));
  EXPECT_EQ(reader.first_cells, cells(10) + cells(9, 11));
}

TEST_P(UsbStack, Corrupt) {
  Plugged glove(GetParam().make);
  Reader reader;
  const auto source = open_usb(serial_glove);
  ByteVector stream = frames(20);
  stream[10 * 320 + 160] ^= 0x40;  // the id of cell 32 of frame 10
  glove.model.send(stream);
  reader.read(*source, 19);
  EXPECT_EQ(reader.decoder.counts(), (DecoderCounts{.frames = 19, .bad = 1, .resynchronised = 1, .discarded = 320}));
  EXPECT_EQ(reader.first_cells, cells(10) + cells(9, 11));
}

TEST_P(UsbStack, Stall) {
  Plugged glove(GetParam().make);
  Reader reader;
  const auto source = open_usb(serial_glove);
  glove.model.send(frames(10));
  glove.model.fail_once(Answer::stall);  // between two frames
  glove.model.send(frames(10, 10));
  reader.read(*source, 20);
  EXPECT_EQ(reader.first_cells, cells(20));
  EXPECT_EQ(source->counts().stalls, 1u);
  EXPECT_EQ(source->counts().reconnects, 0u);
}

TEST_P(UsbStack, Silence) {
  Plugged glove(GetParam().make);
  Reader reader;
  const auto source = open_usb(serial_glove);
  EXPECT_FALSE(source->wait(0.2));
  EXPECT_FALSE(source->finished());
  glove.model.send(frames(1));
  reader.read(*source, 1);
  EXPECT_FALSE(source->wait(0.2));
  EXPECT_EQ(reader.first_cells, cells(1));
  EXPECT_EQ(source->counts().errors, 0u);
}  // and the transfers that wait for a silent device are taken back

TEST_P(UsbStack, Unplug) {
  Plugged glove(GetParam().make);
  Reader reader;
  const auto source = open_usb(serial_glove);
  glove.model.send(frames(10));
  reader.read(*source, 10);
  glove.rig->unplug();
  EXPECT_FALSE(source->wait(0.6));  // over one look for the device
  EXPECT_FALSE(source->finished());
  EXPECT_EQ(source->counts().reconnects, 0u);
  EXPECT_THROW(open_usb(serial_glove), SourceError);
}

TEST_P(UsbStack, Replug) {
  Plugged glove(GetParam().make);
  Reader reader;
  const auto source = open_usb(serial_glove);
  const ByteVector first = frames(1);
  glove.model.send(frames(10));
  glove.model.send_packet(ByteVector(first.begin(), first.begin() + 50));  // the beginning of a frame that never ends
  reader.read(*source, 10);
  reader.read_until(*source, [&] { return source->counts().bytes == 10 * 320 + 50; });
  glove.rig->unplug();
  glove.rig->plug_in();
  glove.model.send(frames(10, 100));
  reader.read(*source, 20);
  EXPECT_EQ(reader.decoder.counts().bad, 0u);
  EXPECT_EQ(reader.first_cells, cells(10) + cells(10, 100));
  EXPECT_EQ(source->counts().reconnects, 1u);
}

TEST_P(UsbStack, ManyReplugs) {
  Plugged glove(GetParam().make);
  Reader reader;
  const auto source = open_usb(serial_glove);
  std::vector<double> expected;
  for (int i = 0; i <= GetParam().returns; ++i) {
    if (i > 0) glove.rig->unplug(), glove.rig->plug_in();
    glove.model.send(frames(2, 10 * i));
    expected = expected + cells(2, 10 * i);
    reader.read(*source, 2 * static_cast<std::uint64_t>(i) + 2);
    ASSERT_EQ(reader.first_cells, expected) << "after return " << i;
  }
  EXPECT_EQ(source->counts().reconnects, static_cast<std::uint64_t>(GetParam().returns));
}

TEST_P(UsbStack, Restart) {
  Plugged glove(GetParam().make);
  for (int i = 0; i < 5; ++i) {
    Reader reader;
    const auto source = open_usb(serial_glove);
    glove.model.send(frames(5, 10 * i));
    reader.read(*source, 5);
    ASSERT_EQ(reader.first_cells, cells(5, 10 * i)) << "opening " << i;
    EXPECT_EQ(source->counts().packets, 25u);
  }
}

std::string refusal() {
  return thrown_message<SourceError>([] { open_usb(serial_glove); });
}

TEST_P(UsbStack, InUse) {
  Plugged glove(GetParam().make);
  const auto source = open_usb(serial_glove);
  EXPECT_THAT(refusal(), HasSubstr("another program may use it"));
  Reader reader;  // who has it keeps it
  glove.model.send(frames(5));
  reader.read(*source, 5);
  EXPECT_EQ(reader.first_cells, cells(5));
}

TEST_P(UsbStack, NoRight) {
  Plugged glove(GetParam().make);
  const pid_t child = fork();
  if (child == 0) _exit(setuid(65534) == 0 && refusal().find("70-tactel.rules") != std::string::npos ? 0 : 1);
  int status = -1;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
}

/// What an error on the wire does: one failed transfer, and no frame lost.
void one_error(Answer answer) {
  Plugged glove(vhci_rig);
  Reader reader;
  const auto source = open_usb(serial_glove);
  glove.model.send(frames(10));
  glove.model.fail_once(answer);
  glove.model.send(frames(10, 10));
  reader.read(*source, 20);
  EXPECT_EQ(reader.first_cells, cells(20));
  EXPECT_EQ(source->counts().errors, 1u);
  EXPECT_EQ(source->counts().stalls, 0u);
}

TEST(Vhci, Babble) { one_error(Answer::babble); }
TEST(Vhci, ProtocolError) { one_error(Answer::protocol_error); }

TEST(Vhci, KernelDriverStandsAside) {
  Plugged glove(vhci_rig);
  const auto driver = [] {
    const std::filesystem::path link =
        device_folder() + "/" + std::filesystem::path(device_folder()).filename().string() + ":1.1/driver";
    return std::filesystem::exists(link) ? std::filesystem::read_symlink(link).filename().string() : "none";
  };
  EXPECT_EQ(driver(), "cdc_acm");
  {
    const auto source = open_usb(serial_glove);
    EXPECT_EQ(driver(), "usbfs");
  }
  EXPECT_EQ(driver(), "cdc_acm");
}

}  // namespace
}  // namespace tactel::hw::tests
