// SPDX-License-Identifier: Apache-2.0

// Ctrl-C once, twice in a row, and again later. Each case runs in a process of its own, which it may end.
#include "host/support/interrupt.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <thread>

namespace tactel::host::interrupt_test {

void wait_ms(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

/// Ends the process: 0 where a stop was requested, else 1.
[[noreturn]] void report(const Interrupt& interrupt) { ::_exit(interrupt.requested() && Interrupt::seen() ? 0 : 1); }

TEST(InterruptDeathTest, NothingIsRequestedWithoutASignal) {
  EXPECT_EXIT(report(Interrupt()), testing::ExitedWithCode(1), "");
}

// As coreutils' `timeout -s INT` does: one to the program, one to its process group.
TEST(InterruptDeathTest, SignalsInARowAreOneRequest) {
  for (const auto& [first, second] :
       {std::pair{SIGINT, SIGINT}, {SIGTERM, SIGTERM}, {SIGINT, SIGTERM}, {SIGHUP, SIGHUP}})
    EXPECT_EXIT(
        {
          std::signal(SIGHUP, SIG_DFL);  // which nohup has changed
          const Interrupt interrupt;
          std::raise(first);
          std::raise(second);
          wait_ms(50);
          std::raise(second);
          report(interrupt);
        },
        testing::ExitedWithCode(0), "");
}

// As nohup does.
TEST(InterruptDeathTest, ASignalOfAClosedTerminalMayBeIgnored) {
  EXPECT_EXIT(
      {
        std::signal(SIGHUP, SIG_IGN);
        const Interrupt interrupt;
        std::raise(SIGHUP);
        report(interrupt);
      },
      testing::ExitedWithCode(1), "");
}

TEST(InterruptDeathTest, ALaterSignalEndsTheProgram) {
  for (const int second : {SIGINT, SIGTERM, SIGHUP})
    EXPECT_EXIT(
        {
          std::signal(SIGHUP, SIG_DFL);
          const Interrupt interrupt;
          std::raise(SIGINT);
          wait_ms(600);
          std::raise(second);
          report(interrupt);
        },
        testing::KilledBySignal(second), "");
}

// Each stage of `reproduce` has an Interrupt of its own: the first signal of each is a request.
TEST(InterruptDeathTest, ANewOneBeginsAnew) {
  EXPECT_EXIT(
      {
        {
          const Interrupt earlier;
          std::raise(SIGINT);
        }
        wait_ms(600);
        const Interrupt interrupt;
        if (interrupt.requested()) ::_exit(2);
        std::raise(SIGINT);
        report(interrupt);
      },
      testing::ExitedWithCode(0), "");
}

TEST(InterruptDeathTest, AfterItsLifeASignalEndsTheProgram) {
  EXPECT_EXIT(
      {
        { const Interrupt interrupt; }
        std::raise(SIGTERM);
        ::_exit(0);
      },
      testing::KilledBySignal(SIGTERM), "");
}

// A compilation is not disturbed by the first Ctrl-C; once a stop is requested, the next one ends the program.
TEST(InterruptDeathTest, SignalsAreHeldUntilAStopIsRequested) {
  EXPECT_EXIT(
      {
        const Interrupt interrupt;
        {
          const HeldSignals held(HeldSignals::handled);
          std::raise(SIGINT);
          if (interrupt.requested()) ::_exit(2);
        }
        if (!interrupt.requested()) ::_exit(3);
        wait_ms(600);
        const HeldSignals held(HeldSignals::handled);
        std::raise(SIGINT);
        ::_exit(4);
      },
      testing::KilledBySignal(SIGINT), "");
}

}  // namespace tactel::host::interrupt_test
