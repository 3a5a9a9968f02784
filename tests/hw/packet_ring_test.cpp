#include "hw/packet_ring.h"

#include <gtest/gtest.h>

#include <thread>

#include "hw/ftdi.h"

namespace tactel::hw {
namespace {

TEST(PacketRing, RefusesWhatDoesNotFitAndKeepsTheRest) {
  PacketRing ring(4, 8);
  const std::uint8_t bytes[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  EXPECT_EQ(ring.front(), nullptr);
  for (std::size_t i = 1; i <= 4; ++i) EXPECT_TRUE(ring.push({Bytes(bytes).first(i), static_cast<double>(i)}));
  EXPECT_FALSE(ring.push({Bytes(bytes), 5}));
  for (std::size_t i = 1; i <= 4; ++i, ring.pop()) {
    ASSERT_NE(ring.front(), nullptr);
    EXPECT_EQ(ring.front()->bytes.size(), i);
    EXPECT_EQ(ring.front()->bytes[i - 1], i);
  }
  EXPECT_EQ(ring.front(), nullptr);
  EXPECT_TRUE(ring.push({Bytes(bytes), 6}));
  EXPECT_EQ(ring.front()->bytes.size(), 8u) << "a packet is cut at the slot's end, never written beyond";
}

TEST(PacketRing, HandsPacketsFromThreadToThreadInOrder) {
  PacketRing ring(16, 4);
  constexpr std::uint32_t count = 200000;
  std::thread producer([&] {
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint8_t bytes[] = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i >> 8),
                                    static_cast<std::uint8_t>(i >> 16), 0};
      while (!ring.push({bytes, static_cast<double>(i)})) std::this_thread::yield();
    }
  });
  std::uint32_t wrong = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Packet* packet;
    while ((packet = ring.front()) == nullptr) std::this_thread::yield();
    wrong += packet->arrival != i || packet->bytes[0] != (i & 0xFF) || packet->bytes[1] != (i >> 8 & 0xFF);
    ring.pop();
  }
  producer.join();
  EXPECT_EQ(wrong, 0u);
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

}  // namespace
}  // namespace tactel::hw
