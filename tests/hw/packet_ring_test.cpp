// SPDX-License-Identifier: Apache-2.0
#include "hw/packet_ring.h"

#include <gtest/gtest.h>
#include <poll.h>

#include <atomic>
#include <chrono>
#include <limits>
#include <thread>
#include <vector>

#include "hw/usb_source.h"

namespace tactel::hw::packet_ring_test {

TEST(PacketRing, KeepsOrderAndBytes) {
  PacketRing ring(4, 8);
  const std::uint8_t bytes[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  EXPECT_FALSE(ring.take());
  for (std::size_t i = 1; i <= 4; ++i) EXPECT_FALSE(ring.push({Bytes(bytes).first(i), static_cast<double>(i)}));
  for (std::size_t i = 1; i <= 4; ++i) {
    const auto packet = ring.take();
    ASSERT_TRUE(packet);
    EXPECT_EQ(packet->bytes.size(), i);
    EXPECT_EQ(packet->bytes[i - 1], i);
    EXPECT_FALSE(packet->after_gap);
  }
  EXPECT_FALSE(ring.take());
  ring.push({Bytes(bytes), 6, true});
  const auto packet = ring.take();
  EXPECT_EQ(packet->bytes.size(), 8u) << "a packet is cut at the slot's end, never written beyond";
  EXPECT_TRUE(packet->after_gap);
}

TEST(PacketRing, WhenFullTheOldestGoesAndLeavesAGap) {
  PacketRing ring(4, 1);
  std::uint8_t byte = 0;
  for (int i = 0; i < 7; ++i, ++byte) EXPECT_EQ(ring.push({{&byte, 1}, static_cast<double>(i)}), i >= 4);
  for (int i = 3; i < 7; ++i) {
    const auto packet = ring.take();
    ASSERT_TRUE(packet);
    EXPECT_EQ(packet->bytes[0], i);
    EXPECT_EQ(packet->arrival, i);
    EXPECT_EQ(packet->after_gap, i == 3);
  }
  EXPECT_FALSE(ring.take());
}

TEST(PacketRing, WhatAReaderHoldsStaysWhileTheRingGoesRound) {
  PacketRing ring(2, 1);
  std::uint8_t byte = 7;
  ring.push({{&byte, 1}, 0});
  const auto held = ring.take();
  for (byte = 10; byte < 20; ++byte) ring.push({{&byte, 1}, 0});
  EXPECT_EQ(held->bytes[0], 7);
}

// The reader pauses now and then, so that the ring overflows under it. Every packet is read or counted as dropped, none
// twice, none torn, and a gap is marked exactly where numbers are missing.
TEST(PacketRing, DropsAndReadsAddUpBetweenThreads) {
  PacketRing ring(16, 64);
  constexpr std::uint32_t count = 100000;
  std::atomic<bool> done{false};
  std::uint32_t dropped = 0, read = 0, wrong = 0, missing = 0;
  std::thread producer([&] {
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::vector<std::uint8_t> bytes(1 + i % 64, static_cast<std::uint8_t>(i));
      dropped += ring.push({bytes, static_cast<double>(i)});
    }
    done = true;
  });
  double expected = 0;
  for (bool last = false; !last;) {
    last = done;  // before the last look: what was pushed until then is seen by it
    while (const auto packet = ring.take()) {
      const auto number = static_cast<std::uint32_t>(packet->arrival);
      wrong += packet->bytes.size() != 1 + number % 64 || packet->arrival < expected ||
               packet->after_gap != (packet->arrival > expected);
      for (const std::uint8_t byte : packet->bytes) wrong += byte != static_cast<std::uint8_t>(number);
      missing += static_cast<std::uint32_t>(packet->arrival - expected);
      expected = packet->arrival + 1;
      if (++read % 1000 == 0) std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
  }
  producer.join();
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(missing, dropped);
  EXPECT_EQ(read + dropped, count);
  EXPECT_GT(dropped, 0u) << "the reader never fell behind: nothing was shown";
}

// A packet at a time to and fro: a wake-up that is lost would cost the whole timeout.
TEST(PacketRing, WakesTheReaderForEveryPacket) {
  PacketRing to(4, 1), back(4, 1);
  constexpr int rounds = 20000;
  const std::uint8_t byte = 1;
  std::thread echo([&] {
    for (int i = 0; i < rounds; ++i)
      if (const auto packet = to.take(10)) back.push({{&byte, 1}, packet->arrival});
  });
  int wrong = 0;
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < rounds; ++i) {
    to.push({{&byte, 1}, static_cast<double>(i)});
    const auto packet = back.take(10);
    wrong += !packet || packet->arrival != i;
  }
  echo.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10)) << "a wake-up was lost";
}

TEST(PacketRing, WaitsNoLongerThanAsked) {
  PacketRing ring(4, 1);
  EXPECT_FALSE(ring.take());
  EXPECT_FALSE(ring.take(0.01));
  EXPECT_FALSE(ring.take(std::nan("")));
  const std::uint8_t byte = 1;
  ring.push({{&byte, 1}, 0});
  EXPECT_TRUE(ring.take(std::numeric_limits<double>::infinity()));
}

TEST(PacketRing, TheWritersFailureReachesTheReaderAfterItsPackets) {
  PacketRing ring(4, 1);
  const std::uint8_t byte = 1;
  ring.push({{&byte, 1}, 0});
  std::thread writer([&] { ring.fail(std::make_exception_ptr(SourceError("no more"))); });
  writer.join();
  EXPECT_TRUE(ring.take(1));
  EXPECT_THROW(ring.take(1), SourceError);
  EXPECT_THROW(ring.take(), SourceError) << "and it stays so";
}

TEST(PacketRing, AFailureWakesAReaderWhoWaits) {
  PacketRing ring(4, 1);
  std::thread writer([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    ring.fail(std::make_exception_ptr(SourceError("no more")));
  });
  EXPECT_THROW(ring.take(60), SourceError);
  writer.join();
}

TEST(PacketRing, ItsDescriptorIsReadableWhilePacketsOrAFailureWait) {
  const auto readable = [](int fd) {
    pollfd wanted{fd, POLLIN, 0};
    return ::poll(&wanted, 1, 0) == 1;
  };
  PacketRing ring(2, 8);
  const std::uint8_t bytes[] = {1, 2, 3};
  ring.push({bytes});
  const int event = ring.event();
  ASSERT_GE(event, 0);
  EXPECT_EQ(ring.event(), event);
  EXPECT_TRUE(readable(event));
  for (int i = 0; i < 3; ++i) ring.push({bytes});  // two stay
  EXPECT_TRUE(ring.take());
  EXPECT_TRUE(readable(event));
  EXPECT_TRUE(ring.take());
  EXPECT_FALSE(readable(event));
  EXPECT_FALSE(ring.take());
  ring.push({bytes});
  EXPECT_TRUE(readable(event));
  EXPECT_TRUE(ring.take());
  EXPECT_FALSE(readable(event));
  ring.fail(std::make_exception_ptr(SourceError("gone")));
  EXPECT_TRUE(readable(event));
  EXPECT_THROW(ring.take(), SourceError);
}

TEST(Ftdi, StripsTheTwoStatusBytes) {
  const std::uint8_t packet[] = {0x01, 0x60, 7, 8};
  EXPECT_EQ(without_ftdi_status(packet).size(), 2u);
  EXPECT_EQ(without_ftdi_status(packet)[0], 7);
  EXPECT_TRUE(without_ftdi_status(Bytes(packet).first(2)).empty());
  EXPECT_TRUE(without_ftdi_status(Bytes(packet).first(1)).empty());
  EXPECT_TRUE(without_ftdi_status({}).empty());
}

TEST(Ftdi, DivisorsOfCommonRates) {
  EXPECT_EQ(ftdi_divisor(9600), 0x4138u);    // 312.5
  EXPECT_EQ(ftdi_divisor(115200), 0x001Au);  // 26
  EXPECT_EQ(ftdi_divisor(921600), 0x8003u);  // 3.25
  EXPECT_EQ(ftdi_divisor(3000000), 0u);
  EXPECT_EQ(ftdi_divisor(2000000), 1u);
}

}  // namespace tactel::hw::packet_ring_test
