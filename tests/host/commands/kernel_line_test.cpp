// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <pty.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "host/commands/program.h"

namespace tactel::host::kernel_line_test {

/// Each message lasts longer than the half second that a shorter one is not worth a line.
void hear(const std::vector<const char*>& messages) {
  const LogSink line = kernel_line();
  for (const char* message : messages) {
    line(LogLevel::busy, message);
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    line(LogLevel::busy, "");
  }
}

TEST(KernelLine, OfALogNamesTablesAndKernelsOnce) {
  testing::internal::CaptureStderr();
  hear({"tables of sensors, 0 of 3", "tables of sensors, 1 of 3", "compiling a.cl", "compiling b.cl"});
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "tables of sensors, 0 of 3 ...\ncompiling kernels for this device (once) ...\n");
}

TEST(KernelLine, OfATerminalNumbersKernels) {
  int terminal = -1, end = -1;
  ASSERT_EQ(openpty(&terminal, &end, nullptr, nullptr, nullptr), 0);
  const int before = dup(STDERR_FILENO);
  dup2(end, STDERR_FILENO);
  hear({"compiling a.cl", "compiling b.cl"});
  dup2(before, STDERR_FILENO);
  std::string shown(4096, ' ');
  shown.resize(static_cast<std::size_t>(std::max<ssize_t>(0, read(terminal, shown.data(), shown.size()))));
  for (const int each : {before, end, terminal}) close(each);
  EXPECT_THAT(shown, testing::HasSubstr("compiling kernels for this device (once), number 1 ..."));
  EXPECT_THAT(shown, testing::HasSubstr("compiling kernels for this device (once), number 2 ..."));
}

}  // namespace tactel::host::kernel_line_test
