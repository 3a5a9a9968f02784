// The online training kernel against its Eigen twin, and against what every training must obey.
#include "host/train_online.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fem/value_error.h"
#include "network_cases.h"

namespace {

using namespace tactel;
using namespace tactel::host;
using tactel::testing::bumps;
using tactel::testing::executor;
using tactel::testing::largest_difference;

constexpr nn::ScalingKind by_set = nn::ScalingKind::set;

/// Networks of one topology on the clean and on a noisy variant of a set, on the device and in the reference.
template <class Real>
struct OnlineCase {
  nn::Topology topology;
  nn::FrameSet set;
  nn::OnlineOptions options;
  nn::InputScaling scaling = nn::fit_scaling(by_set, set);
  std::vector<SetVariant> variants{{0, 0}, {0.1, 5}};
  LearningInputs<Real> inputs{executor().device(), set, scaling, variants};

  TrainOnline<Real> device(const std::vector<OnlineMember>& members) const {
    return {executor(), topology, inputs, members, options};
  }
  template <class Scalar>
  nn::OnlineState<Scalar> reference(const OnlineMember& member, int cycles, nn::CycleErrors* last = nullptr) const {
    const SetVariant& variant = variants[member.variant];
    const auto shown = nn::training_set<Scalar>(nn::with_noise(set, variant.noise, variant.seed), scaling);
    nn::OnlineState<Scalar> state(nn::initial_weights(topology, member.seed));
    const nn::CycleErrors errors = nn::train_online(state, shown, options, member.seed, cycles);
    if (last) *last = errors;
    return state;
  }
};

template <class Real>
OnlineCase<Real> make_case(const char* topology, int rows, nn::OnlineOptions options = {}) {
  const nn::Topology network = nn::Topology::parse(topology);
  return {network, bumps(rows, network.inputs(), 3), options};
}

class TrainOnlineTest : public ::testing::TestWithParam<const char*> {};

// fp64: the block form of the rule differs from the reference in the order of sums alone. 100 cycles of 37 rows are
// 3700 steps, each of some 1e-16; training may carry a difference further, by how much is measured below.
TEST_P(TrainOnlineTest, Fp64WeightsAfter100CyclesMatchReference) {
  const auto c = make_case<double>(GetParam(), 37);
  TrainOnline<double> device = c.device({{7, 0}, {8, 1}});
  device.run(100);
  for (const OnlineMember member : {OnlineMember{7, 0}, OnlineMember{8, 1}}) {
    const nn::OnlineState<double> reference = c.reference<double>(member, 100);
    const nn::OnlineState<double> state = device.state(member.variant);
    EXPECT_EQ(state.cycle, 100u);
    EXPECT_LT(largest_difference(state.weights.values, reference.weights.values), 1e-10);
    EXPECT_LT(largest_difference(state.step.values, reference.step.values), 1e-10);
  }
}

// fp32: how far rounding carries the weights is a matter of the set and the network, so the yardstick is the Eigen
// reference in fp32, which has the same rounding in another order: the kernel may stray from fp64 as far as that does,
// within a factor of 4.
TEST_P(TrainOnlineTest, Fp32WeightsAfter100CyclesMatchReferenceToItsPrecision) {
  const auto c = make_case<float>(GetParam(), 37);
  TrainOnline<float> device = c.device({{7, 0}, {8, 1}});
  device.run(100);
  for (const OnlineMember member : {OnlineMember{7, 0}, OnlineMember{8, 1}}) {
    const nn::Weights<double> truth = c.reference<double>(member, 100).weights;
    const nn::Weights<double> eigen(c.reference<float>(member, 100).weights);
    const nn::Weights<double> kernel(device.state(member.variant).weights);
    const double yardstick = largest_difference(eigen.values, truth.values);
    EXPECT_LT(largest_difference(kernel.values, truth.values), 4 * yardstick);
    EXPECT_LT(yardstick, 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(Topologies, TrainOnlineTest,
                         ::testing::Values("1", "2", "3", "4", "5", "6", "16-16-8-1", "2-1-1", "4-3-5-1", "14-15-16-1",
                                           "30-31-33-1"));

}  // namespace
