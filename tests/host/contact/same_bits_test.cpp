// SPDX-License-Identifier: Apache-2.0

// What a lane computes depends on the lane alone: not on the batch's size, its place, its neighbours, what unused
// memory holds, the number of threads, or how groups are dealt out to them. Compared by hashes of all that a contact's
// solution says.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

#include "host/contact/lines/gap_sweep.h"
#include "kernels/shared/contact_layout.h"
#include "tests/host/contact/contact_cases.h"
#include "tests/host/contact/one_launch.h"

namespace same_bits_test {

using namespace tactel;
using tactel::tests::hash;
using tactel::tests::hashes;
using tactel::tests::Hashes;
using tactel::tests::paper_mesh;

constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();

struct Case {
  const char* name;
  bool fp32, force, friction = true;
};

class SameBits : public ::testing::TestWithParam<Case> {
 protected:
  static constexpr std::size_t count = 150;  ///< four groups in fp32, seven in fp64, the last one ragged
  const std::vector<fem::Scene> scenes_ = random_scenes(7);

  static std::vector<fem::Scene> random_scenes(std::uint64_t seed) {
    auto scenes = GetParam().force ? tactel::tests::random_force_scenes(paper_mesh('B'), count, seed)
                                   : tactel::tests::random_scenes(paper_mesh('B'), count, seed);
    for (fem::Scene& scene : scenes) {
      if (GetParam().friction) continue;
      scene.friction = 0;
      scene.load.angle.reset();
    }
    return scenes;
  }

  const host::GapSweepOptions options_{.most_sweeps = 500};  ///< no need to solve all strangers

  /// body(sweep) with a GapSweep of this case's precision.
  template <class Body>
  void with_sweep(host::Executor& executor, const Body& body) const {
    if (GetParam().fp32)
      body(host::GapSweep<float>(executor, scenes_.front().sensor, options_));
    else
      body(host::GapSweep<double>(executor, scenes_.front().sensor, options_));
  }

  Hashes plain() const {
    host::Executor executor{host::Device(), {.threads = 1}};
    Hashes found;
    with_sweep(executor, [&](const auto& sweep) { found = hashes(sweep, scenes_); });
    return found;
  }
};

TEST_P(SameBits, AnyThreadsAnyChunksAnyDevice) {
  const Hashes expected = plain();
  for (const char* device : {"basic", "pthread"})
    for (int threads : {1, 2, 3})
      for (std::size_t chunk : {1, 4096}) {
        host::Executor executor{host::Device(device), {.threads = threads}};
        with_sweep(executor, [&](const auto& sweep) {
          EXPECT_EQ(hashes(sweep, scenes_, chunk), expected)
              << device << ", " << threads << " threads, chunks of " << chunk;
        });
      }
}

TEST_P(SameBits, Permuted) {
  const Hashes expected = plain();
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937_64(1));
  std::vector<fem::Scene> permuted;
  permuted.reserve(order.size());
  for (std::size_t i : order) permuted.push_back(scenes_[i]);
  host::Executor executor{host::Device()};
  with_sweep(executor, [&](const auto& sweep) {
    const Hashes found = hashes(sweep, permuted);
    for (std::size_t k = 0; k < count; ++k) ASSERT_EQ(found[k], expected[order[k]]) << "scene " << order[k];
  });
}

/// Up to one vector of scenes (16 in fp32, 8 in fp64) takes a program of its own, with that vector alone.
TEST_P(SameBits, SplitIntoBatchesOfAnySize) {
  const Hashes expected = plain();
  host::Executor executor{host::Device()};
  with_sweep(executor, [&](const auto& sweep) {
    std::size_t from = 0;
    for (std::size_t size : {1, 2, 8, 9, 15, 16, 17, 41, 41}) {
      const Hashes found = hashes(sweep, std::span(scenes_).subspan(from, size));
      ASSERT_TRUE(std::equal(found.begin(), found.end(), expected.begin() + from)) << "a batch of " << size;
      from += size;
    }
    ASSERT_EQ(from, count);
  });
}

/// Other scenes before, between and behind: longer paths, deeper, softer, and such as are no scenes at all.
TEST_P(SameBits, AmongStrangersAndBrokenNeighbours) {
  const Hashes expected = plain();
  auto strangers = random_scenes(70);
  for (std::size_t i = 0; i < count; ++i) {
    fem::Scene& s = strangers[i];
    const auto& goal = GetParam().force ? s.load.normal_force : s.load.indentation;
    if (i % 4 == 0) s.sensor.young = i % 8 ? 1e-30 : infinity;
    if (i % 4 == 1 && GetParam().friction) s.friction = i % 8 == 1 ? nan : 1e30;
    if (i % 4 == 1 && !GetParam().friction) (i % 8 == 1 ? s.sensor.young : s.indenter.position) = nan;
    if (i % 4 == 2 && !s.load.angle) s.load.tangential.assign(12, 1e3);
    if (i % 4 == 3)
      s.indenter.shape = fem::Profile{{-30, 0, 30}, {goal.front(), i % 8 == 3 ? nan : 0.0, 1e30}, 0.0, ""};
  }
  std::vector<fem::Scene> mixed;
  for (std::size_t i = 0; i < count; ++i) mixed.insert(mixed.end(), {strangers[i], scenes_[i]});
  host::Executor executor{host::Device()};
  with_sweep(executor, [&](const auto& sweep) {
    auto batch = sweep.prepare(mixed);
    batch.run();
    std::size_t invalid = 0;
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_EQ(hash(batch.solution(2 * i + 1)), expected[i]) << "scene " << i;
      const fem::ContactSolution stranger = batch.solution(2 * i);
      invalid += batch.result(2 * i, 0, RESULT_STATUS) == double(LANE_INVALID);
      // Never NaN in disguise: what counts as solved is a number.
      for (const fem::ContactStep& step : stranger.steps)
        ASSERT_TRUE(!step.converged || (std::isfinite(step.P) && std::isfinite(step.Q) && step.sigma_y.allFinite()))
            << i;
    }
    EXPECT_GE(invalid, count / 4);  // E infinite, mu or a height not a number: an eighth each
  });
}

const auto name_of = [](const auto& info) { return info.param.name; };
INSTANTIATE_TEST_SUITE_P(GapSweep, SameBits,
                         ::testing::Values(Case{"fp32_depth", true, false}, Case{"fp64_force", false, true},
                                           Case{"fp32_frictionless", true, false, false}),
                         name_of);
INSTANTIATE_TEST_SUITE_P(Nightly, SameBits,
                         ::testing::Values(Case{"fp64_depth", false, false}, Case{"fp32_force", true, true},
                                           Case{"fp64_frictionless_force", false, true, false}),
                         name_of);

}  // namespace same_bits_test
