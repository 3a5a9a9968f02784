// SPDX-License-Identifier: Apache-2.0
#include "host/commands/kernel_line.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace tactel::host {
namespace {

// Each of the messages lasts longer than the half second that a shorter one is not worth a line.
TEST(KernelLine, OfALogNamesTablesAndKernelsOnce) {
  testing::internal::CaptureStderr();
  {
    const LogSink line = kernel_line();
    for (const char* message :
         {"tables of sensors, 0 of 3", "tables of sensors, 1 of 3", "compiling a.cl", "compiling b.cl"}) {
      line(LogLevel::busy, message);
      std::this_thread::sleep_for(std::chrono::milliseconds(700));
      line(LogLevel::busy, "");
    }
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "tables of sensors, 0 of 3 ...\ncompiling kernels for this device (once) ...\n");
}

}  // namespace
}  // namespace tactel::host
