// SPDX-License-Identifier: Apache-2.0

// Structs that host and device share have the same layout on both.
#include "kernels/shared/layout.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>

#include "host/device/buffer.h"
#include "tests/host/device/test_device.h"

namespace tactel::host::layout_test {

struct LayoutEntry {
  std::string name;
  std::uint32_t number;      ///< bytes: size of a struct, offset of a field
  std::uint32_t field_size;  ///< bytes; 0 for a struct
};

std::vector<LayoutEntry> host_layout() {
#define STRUCT_ENTRY(S) {"size of " #S, sizeof(S), 0},
#define FIELD_ENTRY(S, field) {"offset of " #S "." #field, offsetof(S, field), sizeof(S::field)},
  return {SHARED_LAYOUT(STRUCT_ENTRY, FIELD_ENTRY)};
}

class Layout : public testing::TestWithParam<std::string> {};

TEST_P(Layout, DeviceSeesWhatTheHostSees) {
  const auto expected = host_layout();
  // Room for more than expected: a device that writes more numbers than the host lists is noticed.
  const std::uint32_t poison = 0xdeadbeef;
  std::vector<std::uint32_t> numbers(expected.size() + 16, poison);
  Executor executor(device(GetParam()));
  Buffer<std::uint32_t> out(executor.device(), std::span<const std::uint32_t>(numbers));
  executor.run(Program(executor.device(), "layout_probe.cl", {}), "layout_probe", 1,
               [&](KernelArguments& kernel) { kernel.set(1, out); });
  out.read(numbers);
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(numbers[i], expected[i].number) << expected[i].name;
  for (std::size_t i = expected.size(); i < numbers.size(); ++i) EXPECT_EQ(numbers[i], poison);
}

// A field that is missing in the list, or padding that compilers might place differently.
TEST(LayoutList, FieldsFillTheirStruct) {
  const auto entries = host_layout();
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (entries[i].field_size != 0) continue;
    std::uint32_t sum = 0;
    for (std::size_t k = i + 1; k < entries.size() && entries[k].field_size != 0; ++k) sum += entries[k].field_size;
    EXPECT_EQ(sum, entries[i].number) << entries[i].name;
  }
}

INSTANTIATE_TEST_SUITE_P(Devices, Layout, testing::ValuesIn(tested_devices()));

}  // namespace tactel::host::layout_test
