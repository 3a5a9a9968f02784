// SPDX-License-Identifier: Apache-2.0

// Exit codes of exceptions, before and after Ctrl-C; no command is run, no device is needed.
#include <gmock/gmock.h>

#include <csignal>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <system_error>

#include "host/commands/program.h"
#include "host/figures/plot.h"
#include "host/support/errors.h"
#include "host/support/interrupt.h"
#include "hw/frame_source.h"

namespace tactel::host::guarded_test {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

struct Outcome {
  int code;
  std::string err;
};

Outcome outcome(const Action& action) {
  testing::internal::CaptureStderr();
  const int code = guarded(action);
  return {code, testing::internal::GetCapturedStderr()};
}

/// What a device does when the stop reaches its compiler, its queue, its threads or its cable.
const std::vector<std::pair<const char*, Action>> device_errors = {
    {"program", []() -> int { throw KernelBuildError("gap_sweep.cl", "-DLANES=8", "unable to remove a file"); }},
    {"call", []() -> int { throw DeviceError("clFinish", "CL_OUT_OF_RESOURCES", "cpu"); }},
    {"cable", []() -> int { throw hw::SourceError("libusb_bulk_transfer: LIBUSB_ERROR_INTERRUPTED"); }},
    {"thread", []() -> int { throw std::system_error(EAGAIN, std::generic_category(), "thread"); }},
    {"other", []() -> int { throw std::runtime_error("unable to do it"); }}};

TEST(Guarded, AnErrorOfTheDeviceEndsWithThree) {
  { const Interrupt none; }
  for (const auto& [name, action] : device_errors) {
    const Outcome result = outcome(action);
    EXPECT_EQ(result.code, 3) << name;
    EXPECT_THAT(result.err, HasSubstr("error: ")) << name;
  }
}

TEST(Guarded, AnErrorOfTheDeviceAfterCtrlCEndsAsInterrupted) {
  const Interrupt interrupt;
  std::raise(SIGINT);
  ASSERT_TRUE(Interrupt::seen());
  for (const auto& [name, action] : device_errors) {
    const Outcome result = outcome(action);
    EXPECT_EQ(result.code, 130) << name;
    EXPECT_THAT(result.err, AllOf(HasSubstr("stopped"), Not(HasSubstr("error: ")))) << name;
  }
}

// The command's Interrupt is gone when its exception arrives.
TEST(Guarded, TheStopIsKnownAfterTheCommandHasUnwound) {
  const Outcome result = outcome([]() -> int {
    const Interrupt interrupt;
    std::raise(SIGTERM);
    throw DeviceError("clEnqueueNDRangeKernel", "CL_OUT_OF_RESOURCES", "cpu");
  });
  EXPECT_EQ(result.code, 130);
}

// rsvg-convert belongs to the terminal's group, too, and ends by the same signal.
TEST(Guarded, APlotThatTheStopPreventedEndsAsInterrupted) {
  const Interrupt interrupt;
  const Action plot = []() -> int { throw PlotError("rsvg-convert ended with 130"); };
  EXPECT_EQ(outcome(plot).code, 2);
  std::raise(SIGINT);
  EXPECT_EQ(outcome(plot).code, 130);
}

// Wrong input stays wrong after Ctrl-C: the same command fails in the same way again.
TEST(Guarded, WrongInputEndsWithTwoAlsoAfterCtrlC) {
  const Interrupt interrupt;
  for (const bool after : {false, true}) {
    if (after) std::raise(SIGINT);
    EXPECT_EQ(outcome([]() -> int { throw ConfigError("a.toml", "key", "1", "2"); }).code, 2);
    EXPECT_EQ(outcome([]() -> int { throw ValueError("key", "1", "2"); }).code, 2);
    EXPECT_EQ(outcome([]() -> int { throw hw::RecordingError("a.tactel: damaged"); }).code, 2);
    EXPECT_EQ(outcome([]() -> int { throw std::bad_alloc(); }).code, 2);
    EXPECT_EQ(outcome([]() -> int {
                throw std::filesystem::filesystem_error("copy", "a.h5", std::make_error_code(std::errc::io_error));
              }).code,
              2);
  }
}

TEST(Guarded, WhatTheCommandReturnsStays) {
  const Interrupt interrupt;
  for (const int code : {0, 2, 3, 4, 130}) EXPECT_EQ(outcome([=] { return code; }).code, code);
  EXPECT_EQ(outcome([]() -> int { throw Stopped("stopped after 3 scenes"); }).err, "stopped after 3 scenes\n");
}

}  // namespace tactel::host::guarded_test
