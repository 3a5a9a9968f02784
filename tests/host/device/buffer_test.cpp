// SPDX-License-Identifier: Apache-2.0
#include "host/device/buffer.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/host/device/test_device.h"

namespace tactel::host {
namespace {

class BufferOn : public testing::TestWithParam<std::string> {
 protected:
  std::vector<int> counted(std::size_t count) const {
    std::vector<int> numbers(count);
    std::iota(numbers.begin(), numbers.end(), 0);
    return numbers;
  }
};

TEST_P(BufferOn, WriteAndReadParts) {
  const auto numbers = counted(1000);
  Buffer<int> buffer(device(GetParam()), std::span(numbers));
  buffer.write(std::vector{-1, -2, -3}, 500);
  std::vector<int> part(5);
  buffer.read(part, 499);
  EXPECT_EQ(part, (std::vector{499, -1, -2, -3, 503}));
  buffer.read(std::span(part).first(1), 999);
  EXPECT_EQ(part[0], 999);
}

TEST_P(BufferOn, TheMapIsTheBuffer) {
  Buffer<int> buffer(device(GetParam()), std::span<const int>(counted(100)));
  {
    const auto map = buffer.map();
    EXPECT_EQ(map.view().size(), 100u);
    EXPECT_EQ(map[42], 42);
    map[42] = -42;
  }
  int number = 0;
  buffer.read({&number, 1}, 42);
  EXPECT_EQ(number, -42);
}

TEST_P(BufferOn, MapsForReadingOrWritingAreTheBufferToo) {
  Buffer<int> buffer(device(GetParam()), 100);
  {
    const auto map = buffer.map(MapFor::writing);
    std::ranges::copy(counted(100), map.view().begin());
  }
  EXPECT_EQ(buffer.map(MapFor::reading)[42], 42);
}

TEST_P(BufferOn, OutsideIsRefused) {
  Buffer<int> buffer(device(GetParam()), 10);
  std::vector<int> numbers(11);
  EXPECT_THROW(buffer.write(numbers), std::out_of_range);
  EXPECT_THROW(buffer.read(std::span(numbers).first(1), 10), std::out_of_range);
  EXPECT_THROW(buffer.read(std::span(numbers).first(1), static_cast<std::size_t>(-1) / 4), std::out_of_range);
  EXPECT_THROW(Buffer<int>().write(numbers), std::out_of_range);
}

TEST_P(BufferOn, EmptyIsAllowed) {
  Buffer<int> buffer(device(GetParam()), 0);
  EXPECT_EQ(buffer.size(), 0u);
  EXPECT_NO_THROW(buffer.write({}));
  EXPECT_TRUE(buffer.map().view().empty());
}

INSTANTIATE_TEST_SUITE_P(Devices, BufferOn, testing::ValuesIn(tested_devices()));

}  // namespace
}  // namespace tactel::host
