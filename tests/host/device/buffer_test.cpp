// SPDX-License-Identifier: Apache-2.0
#include "host/device/buffer.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "host/device/opencl.h"
#include "tests/host/device/test_device.h"

namespace tactel::host::buffer_test {

/// A driver whose blocking writes copy the data and return, as OpenCL allows: the device has them when their queue is
/// finished. Intel's driver for processors is one.
class LateWrites {
 public:
  LateWrites() { current = this; }
  ~LateWrites() { current = nullptr; }
  void write(cl_command_queue queue, cl_mem to, std::size_t offset, std::size_t bytes, const void* from) {
    const char* const data = static_cast<const char*>(from);
    waiting_.push_back({queue, to, offset, {data, data + bytes}});
  }
  void finish(cl_command_queue queue) {
    std::erase_if(waiting_, [&](const Write& late) {
      return late.queue == queue && real_write(queue, late.to, CL_TRUE, late.offset, late.data.size(), late.data.data(),
                                               0, nullptr, nullptr) == CL_SUCCESS;
    });
  }

  inline static LateWrites* current = nullptr;  ///< none: writes are those of the driver
  inline static const auto real_write =
      reinterpret_cast<decltype(&::clEnqueueWriteBuffer)>(::dlsym(RTLD_NEXT, "clEnqueueWriteBuffer"));
  inline static const auto real_finish = reinterpret_cast<decltype(&::clFinish)>(::dlsym(RTLD_NEXT, "clFinish"));

 private:
  struct Write {
    cl_command_queue queue;
    cl_mem to;
    std::size_t offset;
    std::vector<char> data;
  };
  std::vector<Write> waiting_;
};

}  // namespace tactel::host::buffer_test

// Calls of the library under test come here.
extern "C" cl_int clEnqueueWriteBuffer(cl_command_queue queue, cl_mem to, cl_bool blocking, std::size_t offset,
                                       std::size_t bytes, const void* from, cl_uint waits, const cl_event* wait,
                                       cl_event* done) {
  using tactel::host::buffer_test::LateWrites;
  if (!LateWrites::current) return LateWrites::real_write(queue, to, blocking, offset, bytes, from, waits, wait, done);
  LateWrites::current->write(queue, to, offset, bytes, from);
  return CL_SUCCESS;
}

extern "C" cl_int clFinish(cl_command_queue queue) {
  using tactel::host::buffer_test::LateWrites;
  if (LateWrites::current) LateWrites::current->finish(queue);
  return LateWrites::real_finish(queue);
}

namespace tactel::host::buffer_test {

/// PoCL's devices, and one whose memory is its own.
class BufferOn : public testing::TestWithParam<std::string> {
 protected:
  static Device device(const std::string& choice) {
    return choice == "copies" ? host::device().with_copies() : host::device(choice);
  }
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

// Every buffer refers to its context, and so does every queue.
TEST(Buffer, WithMemoryOfItsOwnSharesAQueueAndKeepsWhatWasAllocated) {
  const Device on = Device("basic").with_copies();
  const auto references = [&] { return on.context().getInfo<CL_CONTEXT_REFERENCE_COUNT>(); };
  std::vector<Buffer<int>> ten{Buffer<int>(on, 1)};
  const auto before = references();
  for (int k = 1; k < 10; ++k) ten.emplace_back(on, 1000 + 64 * k);
  EXPECT_EQ(references() - before, 9);
  const auto after = references();
  for (int launch = 0; launch < 3; ++launch) {
    ten.clear();
    for (int k = 0; k < 10; ++k) ten.emplace_back(on, k == 0 ? 1 : 999 + 64 * k);  // as large, about
    EXPECT_EQ(references(), after);
  }
  ten.back().write(std::vector{7}, 1574);
  EXPECT_EQ(ten.back().map(MapFor::reading)[1574], 7);
}

TEST_P(BufferOn, ALaunchSeesWhatWasWritten) {
  const Device on = device(GetParam());
  Executor executor(on);
  const Program program =
      Program::from_text(on, "buffer_test.cl",
                         "#include \"shared/group.h\"\n"
                         "kernel void twice(uint first_group, global const int *in, global int *out) {\n"
                         "  TAKE_GROUP(group);\n"
                         "  out[group] = 2 * in[group];\n"
                         "}\n",
                         lanes_of(on, Precision::fp32));
  Buffer<int> in(on, std::span<const int>(counted(10))), out(on, 10);
  const Launch launch = executor.prepare(program, "twice", [&](KernelArguments& kernel) {
    kernel.set("in", in);
    kernel.set("out", out);
  });
  const LateWrites late;
  for (const int number : {7, 8}) {
    in.write(std::vector{number}, 3);
    executor.run(launch, 10);
    std::vector<int> read(10);
    out.read(read);
    EXPECT_EQ(read, (std::vector{0, 2, 4, 2 * number, 8, 10, 12, 14, 16, 18}));
  }
}

INSTANTIATE_TEST_SUITE_P(Devices, BufferOn, testing::Values("basic", "pthread", "copies"));

}  // namespace tactel::host::buffer_test
