// SPDX-License-Identifier: Apache-2.0

// Kernels of networks at every number of lanes that a device may have.
#include <gtest/gtest.h>

#include "host/networks/forward.h"
#include "host/networks/train_batch.h"
#include "host/networks/train_online.h"
#include "tests/host/networks/network_cases.h"

namespace tactel::host::lanes_test {

using tactel::tests::bumps;
using tactel::tests::largest_difference;

const std::vector<int> all_lanes = {16, 1, 2, 4, 8};

template <class Real>
class NetworkLanes : public ::testing::Test {
 protected:
  const nn::Topology topology_ = nn::Topology::parse("16-16-8-1");
  const nn::FrameSet set_ = bumps(77, 16, 4);
  const nn::InputScaling scaling_{nn::ScalingKind::set, 1.3f};
  void expect_recall_of_the_same_bits(const std::vector<int>& several) const {
    const std::vector<nn::Weights<Real>> network{nn::Weights<Real>(nn::initial_weights(topology_, 3))};
    nn::Vector<Real> expected;
    for (const int lanes : several) {
      Executor executor{Device("basic").with_lanes(lanes), {.threads = 1}};
      const auto found = Forward<Real>(executor, network, scaling_).recall(set_.frames).slip_index;
      if (lanes == 16) expected = found;
      EXPECT_EQ(found, expected) << lanes << " lanes";
    }
  }
};
using NetworkLanesFp32 = NetworkLanes<float>;
TEST_F(NetworkLanesFp32, RecallGivesTheSameBits) { expect_recall_of_the_same_bits({16, 1, 4}); }

template <class Real>
class NetworkLanesNightly : public NetworkLanes<Real> {};
using Precisions = ::testing::Types<float, double>;
TYPED_TEST_SUITE(NetworkLanesNightly, Precisions);

TYPED_TEST(NetworkLanesNightly, RecallGivesTheSameBits) { this->expect_recall_of_the_same_bits(all_lanes); }

// A network's neurons, or a batch's rows, stand in the lanes: sums run in another order at another number of lanes.
// 20 cycles of 77 rows carry a rounding of 6e-8 or 1e-16 to some hundred times that.
TYPED_TEST(NetworkLanesNightly, TrainingGivesTheSameNetworkWithinRounding) {
  const double tolerance = sizeof(TypeParam) == 4 ? 1e-4 : 1e-12;
  const std::vector<SetVariant> clean{{0, 0}};
  const std::vector<OnlineMember> members{{7, 0}, {8, 0}, {9, 0}};
  std::vector<TypeParam> online, batch;
  for (const int lanes : all_lanes) {
    Executor executor{Device("basic").with_lanes(lanes), {.threads = 1}};
    const LearningInputs<TypeParam> inputs(executor.device(), this->set_, this->scaling_, clean);
    TrainOnline<TypeParam> trained(executor, this->topology_, inputs, members, {});
    trained.run(20);
    TrainBatch<TypeParam> batched(executor, this->topology_, inputs, members, {.batch = 16});
    for (int epoch = 0; epoch < 20; ++epoch) batched.train_epoch();
    const auto one = trained.state(1).weights.values, other = batched.state(1).weights.values;
    if (lanes == 16) online.assign(one.begin(), one.end()), batch.assign(other.begin(), other.end());
    EXPECT_LT(largest_difference(one, online), tolerance) << lanes << " lanes";
    EXPECT_LT(largest_difference(other, batch), tolerance) << lanes << " lanes";
  }
}

// The launches of a GPU, in work-groups of 64 with a ragged end, from memory of its own: the bits of one lane.
TEST(OnAGpu, NetworksTrainToTheSameBits) {
  const nn::Topology topology = nn::Topology::parse("16-129-1");  // too wide for a work-group
  const nn::FrameSet set = bumps(77, 16, 4);
  const nn::InputScaling scaling{nn::ScalingKind::set, 1.3f};
  std::vector<OnlineMember> members;
  for (std::uint64_t seed = 0; seed < 70; ++seed) members.push_back({seed, 0});
  std::vector<float> expected;
  for (const Device& device : {Device("basic").with_lanes(1), Device("basic").as_gpu()}) {
    Executor executor{device, {.threads = 1}};
    const LearningInputs<float> inputs(device, set, scaling, std::vector<SetVariant>{{0, 0}});
    TrainOnline<float> online(executor, topology, inputs, members, {});
    online.run(2);
    TrainBatch<float> batch(executor, topology, inputs, members, {.batch = 16});
    batch.train_epoch();
    std::vector<float> found;
    for (std::size_t i = 0; i < members.size(); ++i)
      for (const auto& weights : {online.state(i).weights.values, batch.state(i).weights.values})
        found.insert(found.end(), weights.begin(), weights.end());
    if (expected.empty()) expected = found;
    EXPECT_EQ(found, expected) << name(device.info().type);
  }
}

}  // namespace tactel::host::lanes_test
