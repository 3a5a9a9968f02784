// SPDX-License-Identifier: Apache-2.0

// The USB source on an unmodified libusb, with a device that umockdev pretends. Run under umockdev-wrapper.
#include "hw/usb_source.h"

#include <gmock/gmock.h>

#include <chrono>
#include <thread>

#include "hw/formats.h"
#include "tests/hw/byte_vectors.h"
#include "tests/hw/usb/emulated_device.h"
#include "tests/thrown_message.h"

namespace tactel::hw::tests {
namespace {

using Clock = std::chrono::steady_clock;

const UsbDevice glove{.vendor = 0x04D8, .product = 0x000A, .transport = Transport::cdc_acm};

ByteVector frames(int count, int first = 0) {
  ByteVector stream;
  for (int i = 0; i < count; ++i) append(stream, glove_frame(first + i));
  return stream;
}

/// What arrives, until `count` frames are there or `seconds` are over.
struct Reader {
  Decoder decoder{glove_format()};
  std::vector<double> first_cells;

  void read(FrameSource& source, std::uint64_t count, double seconds = 5) {
    const auto end = Clock::now() + std::chrono::duration<double>(seconds);
    while (decoder.counts().frames < count && Clock::now() < end) {
      const auto packet = source.wait(0.02);
      if (!packet) continue;
      if (packet->after_gap) decoder.interrupt();
      decoder.feed(packet->bytes, [&](const DecodedFrame& frame) { first_cells.push_back(frame.values[0]); });
    }
  }
};

TEST(UsbSource, ReadsEveryFrameAndStopsOrderly) {
  EmulatedDevice device(glove_kind());
  device.send(frames(200));
  Reader reader;
  {
    const auto source = open_usb(glove);
    reader.read(*source, 200);
    EXPECT_EQ(source->counts().packets, 1000u);
    EXPECT_EQ(source->counts().bytes, 64000u);
    // 115200 baud, one stop bit, no parity, 8 data bits; then DTR.
    EXPECT_THAT(device.control_requests(),
                ::testing::ElementsAre(ControlRequest{0x21, 0x20, 0, 0, {0x00, 0xC2, 0x01, 0x00, 0, 0, 8}},
                                       ControlRequest{0x21, 0x22, 1, 0}));
    EXPECT_EQ(device.claimed(), 2u);
  }
  EXPECT_EQ(reader.decoder.counts(), (DecoderCounts{.frames = 200}));
  for (std::size_t i = 0; i < reader.first_cells.size(); ++i)
    ASSERT_EQ(reader.first_cells[i], 4095.0 - static_cast<double>(i));
  EXPECT_EQ(device.most_in_flight(), 16u);
  EXPECT_EQ(device.in_flight(), 0u) << "a transfer was left behind";
  EXPECT_EQ(device.claimed(), 0u);
}

TEST(UsbSource, ADroppedPacketCostsItsFrame) {
  EmulatedDevice device(glove_kind());
  device.send(frames(20));
  device.fault_at(52, Fault::drop);
  const auto source = open_usb(glove);
  Reader reader;
  reader.read(*source, 19);
  EXPECT_EQ(reader.decoder.counts(), (DecoderCounts{.frames = 19, .bad = 1, .resynchronised = 1, .discarded = 256}));
}

TEST(UsbSource, ClearsAHaltAndGoesOnWithoutLoss) {
  EmulatedDevice device(glove_kind());
  device.send(frames(20));
  device.fault_at(50, Fault::stall);  // between two frames
  const auto source = open_usb(glove);
  Reader reader;
  reader.read(*source, 20);
  EXPECT_EQ(reader.decoder.counts().frames, 20u);
  EXPECT_EQ(device.halts_cleared(), 1u);
  EXPECT_EQ(source->counts().stalls, 1u);
}

// A halt that never clears: the device is given up after 8 in a row, and looked for every half second.
TEST(UsbSource, GivesUpADeviceThatStallsForEver) {
  EmulatedDevice device(glove_kind());
  device.send(frames(20));
  device.set_stuck(true);
  device.fault_at(50, Fault::stall);
  const auto source = open_usb(glove);
  Reader reader;
  reader.read(*source, 20, 2.0);
  EXPECT_EQ(reader.decoder.counts().frames, 10u);
  EXPECT_GE(source->counts().errors, 1u) << "nothing says that the device does not work";
  EXPECT_GE(source->counts().stalls, 8u);
  EXPECT_LE(source->counts().stalls, 8u * 5) << "at 0, 0.5, 1, 1.5 and 2 s";
  device.set_stuck(false);
  reader.read(*source, 20);
  EXPECT_EQ(reader.decoder.counts().frames, 20u) << "it works again";
}

TEST(UsbSource, CountsFailedTransfersAndGoesOn) {
  EmulatedDevice device(glove_kind());
  device.send(frames(20));
  device.fault_at(10, Fault::babble);
  device.fault_at(30, Fault::protocol_error);
  const auto source = open_usb(glove);
  Reader reader;
  reader.read(*source, 20);
  EXPECT_EQ(reader.decoder.counts().frames, 20u);
  EXPECT_EQ(source->counts().errors, 2u);
}

TEST(UsbSource, ShortAndEmptyPacketsAreWhatTheyAreAndOverlongOnesAreErrors) {
  EmulatedDevice device(glove_kind());
  const ByteVector stream = frames(4);
  const auto part = [&](int from, int to) { return ByteVector(stream.begin() + from, stream.begin() + to); };
  device.send_packets({part(0, 1),
                       part(1, 64),
                       {},
                       part(64, 65),
                       {},
                       {},
                       part(65, 100),
                       part(100, 164),
                       part(164, 228),
                       part(228, 292),
                       part(292, 320),        // a frame in scraps
                       ByteVector(65, 0x3C),  // more than the endpoint may send
                       part(320, 384),
                       part(384, 448),
                       part(448, 512),
                       part(512, 576),
                       part(576, 640)});
  const auto source = open_usb(glove);
  Reader reader;
  reader.read(*source, 2);
  EXPECT_EQ(reader.decoder.counts(), (DecoderCounts{.frames = 2}));
  EXPECT_EQ(source->counts().errors, 1u);
  EXPECT_EQ(source->counts().bytes, 640u);
  EXPECT_EQ(source->counts().packets, 13u) << "an empty packet is none";
}

TEST(UsbSource, ReadsAnInterruptEndpoint) {
  EmulatedDevice device(interrupt_kind());
  device.send(frames(20));
  const auto source = open_usb({.vendor = 0x1209, .product = 0x0001});
  Reader reader;
  reader.read(*source, 20);
  EXPECT_EQ(reader.decoder.counts(), (DecoderCounts{.frames = 20}));
  EXPECT_GE(device.interrupt_requests(), 100u);
  EXPECT_THAT(device.control_requests(), ::testing::IsEmpty());
}

// AN_120 and FTDI's D2XX guide: request 0 resets, 3 sets the divisor, 4 the framing, 1 DTR (high byte: which lines to
// change), 9 the latency timer in ms; the index names the port, from 1. 921600 baud: 3.25, eighths' code 2 at bit 14.
TEST(UsbSource, PreparesAnFtdiBridgeAndStripsItsStatus) {
  EmulatedDevice device(ftdi_kind());
  device.send(frames(20));
  const auto source = open_usb(
      {.vendor = 0x0403, .product = 0x6001, .transport = Transport::ftdi, .baud = 921600, .start = {'g', 'o'}});
  Reader reader;
  reader.read(*source, 20);
  EXPECT_EQ(reader.decoder.counts(), (DecoderCounts{.frames = 20}));
  EXPECT_EQ(source->counts().bytes, 6400u) << "without the status bytes";
  EXPECT_THAT(device.control_requests(),
              ::testing::ElementsAre(ControlRequest{0x40, 0, 0, 1}, ControlRequest{0x40, 3, 0x8003, 0},
                                     ControlRequest{0x40, 4, 8, 1}, ControlRequest{0x40, 1, 0x0101, 1},
                                     ControlRequest{0x40, 9, 1, 1}));
  EXPECT_EQ(device.received(), (ByteVector{'g', 'o'}));
  const std::uint64_t before = source->counts().packets;
  device.send_packets({{0x01, 0x60}, {0x01, 0x60}});  // an idle bridge
  EXPECT_FALSE(source->wait(0.1));
  EXPECT_EQ(source->counts().packets, before);
}

TEST(UsbSource, WhenNobodyReadsTheOldestPacketsGoAndAreCounted) {
  EmulatedDevice device(fast_kind());
  constexpr int sent = 5000, kept = 4096;  // the ring's length
  std::vector<ByteVector> packets;
  for (int i = 0; i < sent; ++i) packets.push_back({static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i >> 8)});
  device.send_packets(packets);
  const auto source = open_usb({.vendor = 0x1209, .product = 0x0002});
  for (const auto end = Clock::now() + std::chrono::seconds(20); source->counts().packets < sent && Clock::now() < end;)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  ASSERT_EQ(source->counts().packets, static_cast<std::uint64_t>(sent));
  EXPECT_EQ(source->counts().overruns, static_cast<std::uint64_t>(sent - kept));
  int expected = sent - kept;
  while (const auto packet = source->wait(0.02)) {
    ASSERT_EQ(packet->bytes[0] | packet->bytes[1] << 8, expected);
    EXPECT_EQ(packet->after_gap, expected == sent - kept);
    ++expected;
  }
  EXPECT_EQ(expected, sent);
}

// libusb sleeps until the device has something: a packet takes a submit, a reap, and a reap that finds no more.
TEST(UsbSource, SleepsBetweenPackets) {
  EmulatedDevice device(glove_kind());
  const auto source = open_usb(glove);
  const std::size_t before = device.ioctls();
  device.send_by_clock(std::chrono::milliseconds(1), 1000, [](std::size_t i, ByteVector& packet) {
    packet = glove_frame(static_cast<int>(i / 5));
    packet.erase(packet.begin(), packet.begin() + static_cast<std::ptrdiff_t>(64 * (i % 5)));
    packet.resize(64);
  });
  Reader reader;
  reader.read(*source, 60);
  EXPECT_EQ(device.lost(), 0u);
  EXPECT_EQ(reader.decoder.counts(), (DecoderCounts{.frames = 60}));
  EXPECT_LE(device.ioctls() - before, 4 * source->counts().packets + 100);
}

TEST(UsbSource, SilenceIsNoPacketAndNoError) {
  EmulatedDevice device(glove_kind());
  const auto source = open_usb(glove);
  EXPECT_FALSE(source->wait(0.1));
  EXPECT_FALSE(source->finished());
  device.send(frames(1));
  Reader reader;
  reader.read(*source, 1);
  EXPECT_EQ(reader.decoder.counts().frames, 1u);
}

TEST(UsbSource, GoesOnByItselfAfterUnplugAndReturn) {
  EmulatedDevice device(glove_kind());
  device.send(frames(10));
  const auto source = open_usb(glove);
  Reader reader;
  reader.read(*source, 10);
  device.unplug();
  EXPECT_FALSE(source->wait(0.3));
  device.send(frames(10, 100));
  device.plug_in();
  reader.read(*source, 20);
  EXPECT_EQ(reader.decoder.counts().frames, 20u);
  EXPECT_EQ(reader.first_cells.back(), 4095 - 109);
  EXPECT_EQ(source->counts().reconnects, 1u);
}

std::string refusal(const UsbDevice& wanted) {
  return thrown_message<SourceError>([&] { open_usb(wanted); });
}

UsbDevice glove_at(const std::string& port) {
  UsbDevice wanted = glove;
  wanted.port = port;
  return wanted;
}

UsbDevice glove_with(const std::string& serial) {
  UsbDevice wanted = glove;
  wanted.serial = serial;
  return wanted;
}

/// Two gloves, of which the second's frames begin at 1000.
class TwoGloves : public ::testing::Test {
 protected:
  TwoGloves() { send(); }
  void send() {
    left_.send(frames(10));
    right_.send(frames(10, 1000));
  }
  /// The number that its first frame carries.
  static double first_frame(FrameSource& source) {
    Reader reader;
    reader.read(source, 10);
    return reader.first_cells.empty() ? -1 : 4095 - reader.first_cells[0];
  }
  EmulatedDevice left_{glove_kind(), 1, "L-7"}, right_{glove_kind(), 2, "R-8"};
};

TEST_F(TwoGloves, WithoutAChoiceTheFirstIsTakenAndTheOtherNamed) {
  const auto source = open_usb(glove);
  EXPECT_EQ(first_frame(*source), 0);
  EXPECT_EQ(source->choice().taken.port, "1-1");
  EXPECT_EQ(source->choice().taken.serial, "L-7");
  ASSERT_EQ(source->choice().others.size(), 1u);
  EXPECT_EQ(source->choice().others[0].place.port, "1-2");
  EXPECT_EQ(source->choice().others[0].place.serial, "R-8");
  EXPECT_EQ(source->choice().others[0].refusal, "");
  EXPECT_EQ(right_.claimed(), 0u);
}

TEST_F(TwoGloves, AreChosenBySerialNumberAndByPort) {
  EXPECT_EQ(first_frame(*open_usb(glove_with("R-8"))), 1000);
  EXPECT_EQ(first_frame(*open_usb(glove_with("L-7"))), 0);
  send();
  EXPECT_EQ(first_frame(*open_usb(glove_at("1-2"))), 1000);
  EXPECT_EQ(first_frame(*open_usb(glove_at("1-1"))), 0);
}

TEST_F(TwoGloves, TheFreeOneIsTakenWhereTheFirstIsBusy) {
  left_.set_busy(true);
  const auto source = open_usb(glove);
  EXPECT_EQ(first_frame(*source), 1000);
  ASSERT_EQ(source->choice().others.size(), 1u);
  EXPECT_THAT(source->choice().others[0].refusal, ::testing::HasSubstr("BUSY"));
}

TEST_F(TwoGloves, ARefusalNamesAllThatArePluggedIn) {
  using ::testing::AllOf;
  using ::testing::HasSubstr;
  const auto all = AllOf(HasSubstr("1-1 (serial number L-7)"), HasSubstr("1-2 (serial number R-8)"));
  EXPECT_THAT(refusal(glove_with("X-9")), AllOf(HasSubstr("X-9"), all));
  EXPECT_THAT(refusal(glove_at("3-4")), AllOf(HasSubstr("3-4"), all));
  left_.set_busy(true), right_.set_busy(true);
  EXPECT_THAT(refusal(glove), AllOf(HasSubstr("none is free"), HasSubstr("BUSY"), all));
}

// The first of them comes back second: it is known by its number, wherever it is plugged in.
TEST_F(TwoGloves, TheSameOneIsWaitedForAfterAnUnplug) {
  const auto source = open_usb(glove);
  ASSERT_EQ(first_frame(*source), 0);
  left_.unplug();
  EXPECT_FALSE(source->wait(1.2)) << "the other one, which was not asked for, was taken";
  EXPECT_EQ(right_.claimed(), 0u);
  left_.plug_in_at(3);
  left_.send(frames(10, 100));
  EXPECT_EQ(first_frame(*source), 100);
}

// Without serial numbers the port tells them apart.
TEST(UsbSource, KnowsADeviceWithoutANumberByItsPort) {
  EmulatedDevice left(glove_kind(), 1), right(glove_kind(), 2);
  left.send(frames(10)), right.send(frames(10, 1000));
  const auto source = open_usb(glove);
  Reader reader;
  reader.read(*source, 10);
  left.unplug();
  EXPECT_FALSE(source->wait(1.2));
  left.plug_in();
  left.send(frames(10, 100));
  reader.read(*source, 20);
  EXPECT_EQ(reader.first_cells.back(), 4095 - 109);
}

// As long as there is no other, it may be plugged in elsewhere.
TEST(UsbSource, ALoneDeviceWithoutANumberMayChangeItsPort) {
  EmulatedDevice device(glove_kind());
  device.send(frames(10));
  const auto source = open_usb(glove);
  Reader reader;
  reader.read(*source, 10);
  device.unplug();
  EXPECT_FALSE(source->wait(0.1));
  device.plug_in_at(4);
  device.send(frames(10, 100));
  reader.read(*source, 20);
  EXPECT_EQ(reader.first_cells.back(), 4095 - 109);
}

TEST(UsbSource, ASerialNumberHoldsNothingThatATerminalObeys) {
  EmulatedDevice device(glove_kind(), 1, "A\x1b[2J B");
  EXPECT_EQ(open_usb(glove)->choice().taken.serial, "A[2JB");
}

TEST(UsbSource, SaysWhatToCheckWhenNothingIsThere) {
  EmulatedDevice device(glove_kind());
  EXPECT_THAT(refusal({.vendor = 0x04D8, .product = 0x000B}), ::testing::HasSubstr("lsusb -d 04d8:000b"));
  EXPECT_THROW(open_usb({.vendor = 0x04D8, .product = 0x000A, .endpoint = 0x8F}), SourceError);
}

}  // namespace
}  // namespace tactel::hw::tests
