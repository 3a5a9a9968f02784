// The USB source on an unmodified libusb, with a device that umockdev pretends. Run under umockdev-wrapper.
#include "hw/usb_source.h"

#include <gmock/gmock.h>

#include <chrono>

#include "hw/formats.h"
#include "tests/hw/byte_vectors.h"
#include "tests/hw/usb/emulated_glove.h"

namespace tactel::hw::testing {
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
  EmulatedGlove device;
  device.send(frames(200));
  Reader reader;
  {
    const auto source = open_usb(glove);
    reader.read(*source, 200);
    EXPECT_EQ(source->counts().packets, 1000u);
    EXPECT_EQ(source->counts().bytes, 64000u);
    EXPECT_TRUE(device.has_dtr());
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
  EmulatedGlove device;
  device.send(frames(20));
  device.fault_at(52, Fault::drop);
  const auto source = open_usb(glove);
  Reader reader;
  reader.read(*source, 19);
  EXPECT_EQ(reader.decoder.counts(), (DecoderCounts{.frames = 19, .bad = 1, .resynchronised = 1, .discarded = 256}));
}

TEST(UsbSource, ClearsAHaltAndGoesOnWithoutLoss) {
  EmulatedGlove device;
  device.send(frames(20));
  device.fault_at(50, Fault::stall);  // between two frames
  const auto source = open_usb(glove);
  Reader reader;
  reader.read(*source, 20);
  EXPECT_EQ(reader.decoder.counts().frames, 20u);
  EXPECT_EQ(device.halts_cleared(), 1u);
  EXPECT_EQ(source->counts().stalls, 1u);
}

TEST(UsbSource, CountsFailedTransfersAndGoesOn) {
  EmulatedGlove device;
  device.send(frames(20));
  device.fault_at(10, Fault::babble);
  device.fault_at(30, Fault::protocol_error);
  const auto source = open_usb(glove);
  Reader reader;
  reader.read(*source, 20);
  EXPECT_EQ(reader.decoder.counts().frames, 20u);
  EXPECT_EQ(source->counts().errors, 2u);
}

TEST(UsbSource, SilenceIsNoPacketAndNoError) {
  EmulatedGlove device;
  const auto source = open_usb(glove);
  EXPECT_FALSE(source->wait(0.1));
  EXPECT_FALSE(source->finished());
  device.send(frames(1));
  Reader reader;
  reader.read(*source, 1);
  EXPECT_EQ(reader.decoder.counts().frames, 1u);
}

TEST(UsbSource, GoesOnByItselfAfterUnplugAndReturn) {
  EmulatedGlove device;
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

TEST(UsbSource, SaysWhatToCheckWhenNothingIsThere) {
  EmulatedGlove device;
  try {
    open_usb({.vendor = 0x04D8, .product = 0x000B});
    FAIL();
  } catch (const SourceError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("lsusb -d 04d8:000b"));
  }
  EXPECT_THROW(open_usb({.vendor = 0x04D8, .product = 0x000A, .endpoint = 0x8F}), SourceError);
}

}  // namespace
}  // namespace tactel::hw::testing
