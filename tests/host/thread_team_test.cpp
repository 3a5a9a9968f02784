#include "host/thread_team.h"

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>

namespace tactel::host {
namespace {

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
    try {
      team.run(body);
      FAIL();
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(error.what(), "from " + std::to_string(thrower));
    }
  }
  EXPECT_NO_THROW(team.run([](int) {}));
}

}  // namespace
}  // namespace tactel::host
