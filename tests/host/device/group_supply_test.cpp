// SPDX-License-Identifier: Apache-2.0

// How groups are dealt out to threads, without threads or clocks: every group once, and a balance that survives any
// order of heavy and light groups.
#include "host/device/group_supply.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <thread>

namespace tactel::host::group_supply_test {

TEST(GroupSupply, EveryGroupOfEveryJobOnce) {
  const std::vector<std::size_t> groups{3, 0, 1000, 1};
  GroupSupply supply(groups);
  EXPECT_EQ(supply.total(), 1004u);
  std::set<std::pair<std::size_t, std::size_t>> seen;
  std::size_t want = 1;
  while (const auto chunk = supply.draw([&](std::size_t) { return want; })) {
    for (std::size_t i = 0; i < chunk->count; ++i) EXPECT_TRUE(seen.emplace(chunk->job, chunk->first + i).second);
    EXPECT_LE(chunk->count, want);
    want = want % 7 + 1;
  }
  EXPECT_EQ(seen.size(), 1004u);
  for (const auto& [job, group] : seen) EXPECT_LT(group, groups[job]);
  EXPECT_EQ(supply.remaining(), 0u);
}

TEST(GroupSupply, ThreadsNeverShareAGroup) {
  const std::vector<std::size_t> groups{20000, 30001};
  GroupSupply supply(groups);
  std::vector<std::atomic<int>> drawn(50001);
  const auto draw_all = [&](std::size_t most) {
    while (const auto chunk = supply.draw([&](std::size_t) { return most; }))
      for (std::size_t i = 0; i < chunk->count; ++i) ++drawn[chunk->job * 20000 + chunk->first + i];
  };
  std::thread other(draw_all, 3);
  draw_all(2);
  other.join();
  EXPECT_TRUE(std::ranges::all_of(drawn, [](const std::atomic<int>& times) { return times == 1; }));
}

TEST(GroupSupply, StoppedHasNothingMore) {
  GroupSupply supply(std::vector<std::size_t>{10});
  supply.draw([](std::size_t) { return 4; });
  supply.stop();
  EXPECT_FALSE(supply.draw([](std::size_t) { return 1; }));
}

constexpr double launch_seconds = 0.5e-6;

/// Time until the last of `threads` is done, when each draws as ChunkPace says. cost: [groups] s.
double simulated(const std::vector<double>& cost, int threads, double expected) {
  GroupSupply supply(std::vector<std::size_t>{cost.size()});
  std::vector<double> clock(threads, 0.0);
  std::vector<ChunkPace> pace(threads, ChunkPace(4096, threads, expected));
  while (true) {
    const std::size_t thread = std::ranges::min_element(clock) - clock.begin();
    const auto chunk = supply.draw([&](std::size_t) { return pace[thread].next(supply.remaining()); });
    if (!chunk) return std::ranges::max(clock);
    const auto first = cost.begin() + static_cast<std::ptrdiff_t>(chunk->first);
    const double seconds = std::accumulate(first, first + static_cast<std::ptrdiff_t>(chunk->count), launch_seconds);
    clock[thread] += seconds;
    pace[thread].measured(chunk->count, seconds);
  }
}

struct Work {
  std::size_t groups, heavy;
  double light_seconds, heavy_seconds;
};

class Balance : public testing::TestWithParam<Work> {
 protected:
  // Heavy groups side by side, beginning at `first`.
  std::vector<double> costs(std::size_t first) const {
    std::vector<double> cost(GetParam().groups, GetParam().light_seconds);
    for (std::size_t i = 0; i < GetParam().heavy; ++i) cost[first + i] = GetParam().heavy_seconds;
    return cost;
  }
  // Of the best that could be: the work shared evenly, but no group split.
  static double loss(const std::vector<double>& cost, int threads, bool known) {
    const double sum = std::accumulate(cost.begin(), cost.end(), 0.0);
    const double ideal = std::max(sum / threads, std::ranges::max(cost));
    return simulated(cost, threads, known ? sum / static_cast<double>(cost.size()) : 0.0) / ideal;
  }
};

// Consecutive dealing loses a factor 2 here. 1.25: half the smallest of these works is 120 us and a chunk of 20 us may
// be drawn by one thread at the end; launches add 5 %.
TEST_P(Balance, HeavyGroupsAnywhereCostLittleOnceTheKernelIsKnown) {
  const Work work = GetParam();
  for (const int threads : {1, 2, 4, 16})
    for (const std::size_t first : {std::size_t{0}, work.groups / 3, work.groups / 2, work.groups - work.heavy})
      EXPECT_LT(loss(costs(first), threads, true), 1.25) << threads << " threads, heavy from " << first;
}

// Of groups a thousand times heavier than those before it a first run may draw three at once (3 us of light ones).
TEST_P(Balance, AFirstRunOnTwoThreadsStaysFarFromConsecutiveDealing) {
  const Work work = GetParam();
  for (const std::size_t first : {std::size_t{0}, work.groups / 3, work.groups / 2, work.groups - work.heavy})
    EXPECT_LT(loss(costs(first), 2, false), 1.4) << "heavy from " << first;
}

INSTANTIATE_TEST_SUITE_P(Works, Balance,
                         testing::Values(Work{8, 4, 1e-6, 1e-3}, Work{64, 8, 1e-6, 1e-3}, Work{1024, 16, 1e-6, 1e-3},
                                         Work{2048, 64, 1e-6, 1e-4}, Work{1024, 100, 12e-6, 120e-6},
                                         Work{4096, 400, 1e-6, 10e-6}),
                         [](const auto& work) {
                           return std::to_string(work.param.heavy) + "_of_" + std::to_string(work.param.groups);
                         });

// 0.3 us a group is the finest that the networks have: launching must not dominate. 30 ms of work.
TEST(Pace, LightEqualGroupsCostFewLaunches) {
  const std::vector<double> cost(100000, 0.3e-6);
  for (const int threads : {1, 2, 4}) {
    const double ideal = 0.03 / threads;
    EXPECT_LT(simulated(cost, threads, 0.3e-6), 1.04 * ideal);  // chunks of 20 us: 2.5 %
    EXPECT_LT(simulated(cost, threads, 0.0), 1.06 * ideal);     // the same after the first ms of each thread
  }
}

TEST(Pace, AShortRunIsSplitOnce) {
  EXPECT_EQ(ChunkPace(4096, 2, 0.5e-6).next(16), 8u);
  EXPECT_EQ(ChunkPace(5, 2, 0.5e-6).next(16), 5u);
}

// 128 groups of 1.2 us, a batch of 4096 frames, in half of each thread's share at a time: 32, 24, 18, 14, 10, 8; then
// the rest, below 30 us, in its halves: 11, 6, 3, 1, 1. No chunk takes more than 100 us.
TEST(Pace, EqualGroupsCostFewerLaunches) {
  std::size_t launches = 0;
  for (std::size_t rest = 128; rest > 0; ++launches) rest -= ChunkPace(4096, 2, 1.2e-6, true).next(rest);
  EXPECT_LE(launches, 11u);
  EXPECT_EQ(ChunkPace(4096, 2, 1.2e-6, true).next(128), 32u);
  EXPECT_EQ(ChunkPace(4096, 2, 1.2e-6, true).next(100000), 83u);
}

TEST(Pace, BeginsWithOneGroupAndDoublesAtMost) {
  ChunkPace pace(4096, 2, 0);
  EXPECT_EQ(pace.next(100000), 1u);
  for (std::size_t last = 1; last <= 8; last *= 2) {
    pace.measured(last, 1e-9 * static_cast<double>(last));
    EXPECT_EQ(pace.next(100000), 2 * last);
  }
  pace.measured(8, 1.0);
  EXPECT_EQ(pace.next(100000), 1u);
}

}  // namespace tactel::host::group_supply_test
