// SPDX-License-Identifier: Apache-2.0
#include "host/device/program.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include "host/device/buffer.h"
#include "host/device/opencl.h"
#include "host/support/stop_scope.h"
#include "tests/host/device/test_device.h"

namespace tactel::host::program_test {

const char* const text =
    "#include \"shared/group.h\"\n"
    "kernel void without(uint first_group, global int *out) { out[first_group + get_global_id(0)] = 7; }\n"
    "kernel void scale(uint first_group, global int *out) { TAKE_GROUP(group); out[group] = FACTOR * (int)group; }\n";

Program program(const std::string& factor) {
  return Program::from_text(device(), "scale.cl", text, {{"FACTOR", factor}});
}

/// out[5] of `scale`.
int fifth(const Program& program) {
  Executor executor(device());
  Buffer<int> out(device(), std::span<const int>(std::vector<int>(6, -1000)));
  executor.run(program, "scale", 6, [&](KernelArguments& kernel) { kernel.set(1, out); });
  return out.map()[5];
}

TEST(Program, DefinesMakeDifferentPrograms) {
  const Program three = program("3"), four = program("4");
  EXPECT_EQ(fifth(three), 15);
  EXPECT_EQ(fifth(four), 20);
  EXPECT_EQ(fifth(program("3")), 15);
  EXPECT_EQ(three.options(), "-cl-std=CL1.2 -cl-denorms-are-zero -DFACTOR=3");
}

TEST(Program, KnowsWhichKernelsTakeTheirGroup) {
  EXPECT_TRUE(program("1").takes_group("scale"));
  EXPECT_FALSE(program("1").takes_group("without"));
  EXPECT_FALSE(program("1").takes_group("nonesuch"));
}

TEST(Program, AnUnknownKernelIsADeviceError) {
  EXPECT_THAT([] { program("1").kernel("nonesuch"); }, throws_device_error("clCreateKernel", "CL_INVALID_KERNEL_NAME"));
}

TEST(Program, OutlivesItsDeviceHandle) {
  const Program kept = [] {
    const Device passing("basic");
    return Program::from_text(passing, "scale.cl", text, {{"FACTOR", "2"}});
  }();
  EXPECT_NO_THROW(kept.kernel("scale"));
}

// Whoever builds a kernel for nothing hears why.
TEST(Program, TheLogSinkHearsOfBuildsAndOfKernelsThatCannotBeCompiledAhead) {
  std::vector<std::string> heard;
  const Device logging("basic", [&](LogLevel level, std::string_view message) {
    if (level != LogLevel::busy) heard.emplace_back(message);
  });
  const Program built = Program::from_text(logging, "scale.cl", text, {{"FACTOR", "2"}});
  ASSERT_EQ(heard.size(), 1u) << ::testing::PrintToString(heard);
  EXPECT_EQ(heard[0], "scale.cl built, -cl-std=CL1.2 -cl-denorms-are-zero -DFACTOR=2");
  Executor executor(logging);
  Buffer<int> out(logging, 1);
  executor.run(built, "without", 1, [&](KernelArguments& kernel) { kernel.set(1, out); });
  ASSERT_EQ(heard.size(), 2u);
  EXPECT_EQ(heard[1], "without lacks TAKE_GROUP: compiled at its first use, run group by group");
}

using Heard = std::vector<std::string>;

/// A program that no cache holds.
std::string new_text() {
  static int made = 0;
  const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
  return text + fmt::format("// {} {} {}\n", getpid(), now, ++made);
}

Heard busy_messages(const std::function<void(const Device&)>& job) {
  Heard heard;
  const Device logging("basic", [&](LogLevel level, std::string_view message) {
    if (level == LogLevel::busy) heard.emplace_back(message);
  });
  job(logging);
  return heard;
}

const std::string compiling = "compiling scale.cl for this device (once)";

TEST(Program, TheLogSinkHearsThatItIsCompiledAndWhenThatIsOver) {
  const Heard heard = busy_messages([source = new_text()](const Device& device) {
    for (const Device& of :
         {device, Device("basic", [&](LogLevel level, std::string_view message) { device.log(level, message); })}) {
      const Program program = Program::from_text(of, "scale.cl", source, {{"FACTOR", "2"}});
      Executor executor(of);
      Buffer<int> out(of, 1);
      const Launch launch = executor.prepare(program, "scale", [&](KernelArguments& kernel) { kernel.set(1, out); });
      executor.run_here(launch);
    }
  });
  EXPECT_EQ(heard, (Heard{compiling, ""}));  // the second context takes it from the cache
}

TEST(Program, AStopLeavesItsCompilationBehind) {
  static std::atomic<bool> compiles = false;
  const Device watched("basic", [](LogLevel level, std::string_view message) {
    if (level == LogLevel::busy && message.starts_with("compiling")) compiles = true;
  });
  const auto build = [&, source = new_text()] {
    return Program::from_text(watched, "scale.cl", source, {{"FACTOR", "2"}});
  };
  {
    const StopScope::Asked asked = [] { return compiles.load(); };
    const StopScope scope(&asked);
    EXPECT_THROW(build(), Stopped);
  }
  EXPECT_TRUE(build().takes_group("scale"));
}

// A failed build is tried again.
TEST(Program, IsBuiltOnceAContext) {
  const Heard heard = busy_messages([source = new_text()](const Device& device) {
    for (const Device& of : {device, device, device.with_lanes(4)})
      Program::from_text(of, "scale.cl", source, {{"FACTOR", "2"}});
    Program::from_text(device, "scale.cl", source + "\n", {{"FACTOR", "2"}});
    for (int i = 0; i < 2; ++i) EXPECT_THROW(Program::from_text(device, "bad.cl", "kernel", {}), KernelBuildError);
  });
  const std::string bad = "compiling bad.cl for this device (once)";
  EXPECT_EQ(heard, (Heard{compiling, "", compiling, "", bad, "", bad, ""}));
}

TEST(Program, TheLogSinkHearsThatAFailedBuildIsOver) {
  const Heard heard = busy_messages([](const Device& device) {
    EXPECT_THROW(Program::from_text(device, "bad.cl", "kernel void bad( {", {}), KernelBuildError);
  });
  EXPECT_EQ(heard, (Heard{"compiling bad.cl for this device (once)", ""}));
}

// A compiler in this process would not survive it.
TEST(ProgramDeathTest, IsNotCompiledInTooLittleAddressSpace) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto compile = [] {
    const Device basic("basic");
    rlimit limit{};
    getrlimit(RLIMIT_AS, &limit);
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    limit.rlim_cur = pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) + (std::size_t{600} << 20);
    setrlimit(RLIMIT_AS, &limit);
    try {
      Program::from_text(basic, "scale.cl", new_text(), {{"FACTOR", "2"}});
    } catch (const DeviceError& error) {
      std::cerr << error.what();
      std::exit(3);
    }
  };
  EXPECT_EXIT(compile(), testing::ExitedWithCode(3), "the address space is limited to");
}

TEST(Device, LogsToTheDefaultWithoutASinkOfItsOwn) {
  Heard heard, own;
  set_default_log([&](LogLevel, std::string_view message) { heard.emplace_back(message); });
  Device("basic").log(LogLevel::info, "to the default");
  Device("basic", [&](LogLevel, std::string_view message) {
    own.emplace_back(message);
  }).log(LogLevel::info, "to mine");
  set_default_log({});
  Device("basic").log(LogLevel::info, "to none");
  EXPECT_EQ(heard, Heard{"to the default"});
  EXPECT_EQ(own, Heard{"to mine"});
}

}  // namespace tactel::host::program_test
