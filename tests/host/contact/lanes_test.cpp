// SPDX-License-Identifier: Apache-2.0

// The same bits at every number of lanes that a device may have: 1 on a GPU, 4 with SSE, 8 with AVX, 16 with AVX-512.
#include <gtest/gtest.h>

#include "host/contact/lines/gap_sweep.h"
#include "tests/host/contact/contact_cases.h"
#include "tests/host/device/test_device.h"

namespace tactel::host::lanes_test {

template <class Real>
class LanesNightly : public ::testing::Test {};
using Precisions = ::testing::Types<float, double>;
TYPED_TEST_SUITE(LanesNightly, Precisions);

/// Whether all that a step says is the same, bit for bit.
bool same(const fem::ContactStep& a, const fem::ContactStep& b) {
  return a.P == b.P && a.Q == b.Q && a.status == b.status && a.iterations == b.iterations &&
         a.normal_force == b.normal_force && a.tangential_force == b.tangential_force &&
         a.base_force_x == b.base_force_x && a.base_force_y == b.base_force_y && a.sigma_y == b.sigma_y &&
         a.tau_xy == b.tau_xy && a.residual.cone == b.residual.cone && a.residual.drift == b.residual.drift;
}

TYPED_TEST(LanesNightly, OfAnyNumberGiveTheSameBits) {
  for (const bool force : {false, true}) {
    const fem::Sensor sensor = tactel::tests::paper_mesh('B');
    const auto scenes =  // more than one tile of 64 at one lane
        force ? tactel::tests::random_force_scenes(sensor, 67, 5) : tactel::tests::random_scenes(sensor, 67, 5);
    std::vector<fem::ContactSolution> expected;
    for (const Device& device : devices_of_all_lanes()) {
      Executor executor{device, {.threads = 1}};
      auto batch = GapSweep<TypeParam>(executor, sensor, {.most_sweeps = 200}).prepare(scenes);
      batch.run();
      for (std::size_t i = 0; i < scenes.size(); ++i) {
        const fem::ContactSolution found = batch.solution(i);
        if (expected.size() == i) expected.push_back(found);
        ASSERT_EQ(found.steps.size(), expected[i].steps.size());
        for (std::size_t k = 0; k < found.steps.size(); ++k)
          ASSERT_TRUE(same(found.steps[k], expected[i].steps[k]))
              << device.info().lanes_fp32 << " lanes, scene " << i << ", step " << k;
      }
    }
  }
}

}  // namespace tactel::host::lanes_test
