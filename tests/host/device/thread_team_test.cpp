// SPDX-License-Identifier: Apache-2.0
#include "host/device/thread_team.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <stdexcept>

#include "host/device/executor.h"

namespace tactel::host::thread_team_test {

using namespace std::chrono_literals;

TEST(ThreadTeam, OneThreadIsTheCaller) {
  ThreadTeam team(1, 0.0);
  std::thread::id where;
  team.run([&](int index) {
    EXPECT_EQ(index, 0);
    where = std::this_thread::get_id();
  });
  EXPECT_EQ(where, std::this_thread::get_id());
}

// Thousands of short runs, some while the workers listen, some after they went to sleep.
TEST(ThreadTeam, ManyRunsEachThreadAtMostOnce) {
  for (const double spin : {0.0, 50e-6}) {
    ThreadTeam team(3, spin);
    for (int run = 0; run < 3000; ++run) {
      std::atomic<int> calls[3] = {};
      team.run([&](int index) { ++calls[index]; });
      EXPECT_EQ(calls[0], 1);
      EXPECT_LE(calls[1], 1);
      EXPECT_LE(calls[2], 1);
      if (run % 300 == 0) std::this_thread::sleep_for(1ms);
    }
  }
}

// The caller's body goes on until the other has come: a team whose workers never came would hang here.
TEST(ThreadTeam, SleepingWorkersWakeUp) {
  ThreadTeam team(2, 10e-6);
  for (int run = 0; run < 20; ++run) {
    std::this_thread::sleep_for(2ms);
    std::atomic<bool> came = false;
    team.run([&](int index) {
      if (index == 1) came = true;
      while (!came) std::this_thread::yield();
    });
    EXPECT_TRUE(came);
  }
}

// Body 0 ends first: run must still wait for the worker that is inside.
TEST(ThreadTeam, RunWaitsForThoseInside) {
  ThreadTeam team(2, 10e-6);
  for (int run = 0; run < 20; ++run) {
    std::atomic<bool> inside = false, finished = false;
    team.run([&](int index) {
      if (index == 0) {
        while (!inside) std::this_thread::yield();
        return;
      }
      inside = true;
      std::this_thread::sleep_for(1ms);
      finished = true;
    });
    EXPECT_TRUE(finished);
  }
}

TEST(ThreadTeam, ExceptionsOfWorkersReachTheCaller) {
  ThreadTeam team(2, 50e-6);
  for (const int thrower : {0, 1}) {
    std::atomic<bool> came = false;
    const auto body = [&](int index) {
      if (index == 1) came = true;
      while (!came) std::this_thread::yield();
      if (index == thrower) throw std::runtime_error("from " + std::to_string(index));
    };
    EXPECT_THAT([&] { team.run(body); }, testing::ThrowsMessage<std::runtime_error>("from " + std::to_string(thrower)));
  }
  EXPECT_NO_THROW(team.run([](int) {}));
}

/// From here on the process gets `bytes` more memory: room for a few threads, each of which asks for 8 MiB of stack.
void limit_memory(std::size_t bytes) {
  std::ifstream statm("/proc/self/statm");
  std::size_t pages = 0;
  statm >> pages;
  const rlimit limit{pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) + bytes, RLIM_INFINITY};
  setrlimit(RLIMIT_AS, &limit);
}

// Where no more threads can be made, those that could do the work, and none is left behind.
TEST(ThreadTeamDeathTest, GoesOnWithTheThreadsThereAre) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto few_threads = [] {
    limit_memory(100u << 20);
    int made = 0;
    {
      ThreadTeam team(1000, 0.0);
      made = team.threads();
      std::atomic<int> calls = 0;
      team.run([&](int) { ++calls; });
      if (calls < 1 || calls > made) std::exit(2);
    }
    std::exit(made >= 1 && made < 1000 ? 0 : 3);
  };
  EXPECT_EXIT(few_threads(), testing::ExitedWithCode(0), "");
}

TEST(ExecutorDeathTest, AnExecutorSaysThatItHasFewer) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto few_threads = [] {
    const Device device("basic", [](LogLevel level, std::string_view message) {
      if (level == LogLevel::warning) std::cerr << message << "\n";
    });
    limit_memory(200u << 20);
    const Executor executor(device, {.threads = 1000});
    std::exit(executor.threads() < 1000 ? 0 : 1);
  };
  EXPECT_EXIT(few_threads(), testing::ExitedWithCode(0), "only [0-9]+ of 1000 threads could be created");
}

}  // namespace tactel::host::thread_team_test
