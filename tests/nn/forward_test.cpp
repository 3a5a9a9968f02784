// SPDX-License-Identifier: Apache-2.0
#include "nn/forward.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "fem/numbers/value_error.h"

namespace forward_test {

using namespace tactel;
using namespace tactel::nn;

constexpr float inf = std::numeric_limits<float>::infinity();

Weights<double> small_network() {
  Weights<double> weights(Topology({2, 2, 1}));
  weights.values = {0.5, -0.25, 0.1, 1.0, 0.75, -0.2, 0.8, -0.6, 0.05};
  return weights;
}

// Half the squared error of one pattern, what the rule descends.
double half_square(const Weights<double>& weights, const Vector<double>& x, double target) {
  const double error = target - forward(weights, x).back()(0);
  return 0.5 * error * error;
}

TEST(Activation, EqualsThePapersFormAndSaturates) {
  for (const double z : {-20.0, -1.0, -1e-9, 0.0, 0.5, 2.0, 30.0})
    EXPECT_NEAR(activation(z), 0.5 * (1 - std::exp(-z)) / (1 + std::exp(-z)), 1e-16);  // an ulp of 0.5
  EXPECT_EQ(activation(-1000.0f), -0.5f);
  EXPECT_EQ(activation(-inf), -0.5f);
  EXPECT_EQ(activation(inf), 0.5f);
  EXPECT_TRUE(std::isnan(activation(inf - inf)));
}

// The numbers come from a separate program (Python) that writes the sums out; a few ulp of 0.5.
TEST(Forward, MatchesANetworkWorkedByHand) {
  const Activations<double> o = forward(small_network(), Vector<double>{{0.4, -0.8}});
  EXPECT_NEAR(o[1](0), 0.12245933120185457, 1e-15);
  EXPECT_NEAR(o[1](1), -0.09868766011245203, 1e-15);
  EXPECT_NEAR(o[2](0), 0.051610538111932835, 1e-15);
  const Deltas<double> delta = backward(small_network(), o, 0.3 - o[2](0));
  EXPECT_NEAR(delta[1](0), 0.06143574346701372, 1e-15);
  EXPECT_NEAR(delta[0](0), 0.011550102221290466, 1e-15);
  EXPECT_NEAR(delta[0](1), -0.008856358524341997, 1e-15);
}

// Leaky rectifiers by hand: sums 0.5 and -0.4 (x0 / 2 - x1 / 4 + 0.1, x0 + 3/4 x1 - 0.2), hence 0.5 and -0.004; the
// output's sum is 0.4 + 0.0024 + 0.05. An ulp of 0.01f: the leak is the float.
TEST(Forward, MatchesLeakyRectifiersWorkedByHand) {
  Weights<double> weights(Topology({2, 2, 1}, Activation::leaky_relu));
  weights.values = small_network().values;
  const Activations<double> o = forward(weights, Vector<double>{{0.4, -0.8}});
  EXPECT_NEAR(o[1](0), 0.5, 1e-15);
  EXPECT_NEAR(o[1](1), -0.004, 1e-9);
  EXPECT_NEAR(o[2](0), 0.5 * std::tanh(0.2262), 1e-9);
  const Deltas<double> delta = backward(weights, o, 1.0);
  EXPECT_NEAR(delta[1](0), 0.25 - o[2](0) * o[2](0), 1e-15);
  EXPECT_NEAR(delta[0](0), 0.8 * delta[1](0), 1e-15);
  EXPECT_NEAR(delta[0](1), -0.006 * delta[1](0), 1e-9);
}

class Gradient : public testing::TestWithParam<const char*> {};

TEST_P(Gradient, MatchesFiniteDifferences) {
  const Topology topology = Topology::parse(GetParam());
  Weights<double> weights(initial_weights(topology, 4));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Vector<double> x(topology.inputs());
  for (double& value : x) value = uniform(random);
  const double target = 0.4;
  const Activations<double> o = forward(weights, x);
  Weights<double> descent(topology);
  add_outer(o, backward(weights, o, target - o.back()(0)), 1.0, descent);
  double largest = 0;
  for (const double value : descent.values) largest = std::max(largest, std::abs(value));
  // Central differences with h = 1e-5: truncation h^2 E''' / 6 ~ 1e-11, rounding 1e-17 / h ~ 1e-12, both over a largest
  // of ~0.01.
  const double h = 1e-5;
  for (std::size_t i = 0; i < weights.values.size(); ++i) {
    const double w = weights.values[i];
    weights.values[i] = w + h;
    const double above = half_square(weights, x, target);
    weights.values[i] = w - h;
    const double below = half_square(weights, x, target);
    weights.values[i] = w;
    ASSERT_NEAR(descent.values[i], -(above - below) / (2 * h), 1e-8 * largest) << "weight " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Topologies, Gradient,
                         testing::Values("42-42-1", "42-84-1", "42-21-1", "42-42-42-1", "42-42-82-1", "42-42-21-1",
                                         "16-16-8-1", "2-1-1", "16-16-8-1_leaky-relu", "16-9-1_leaky-relu"));

TEST(Recall, NeverAnswersNaNWithoutAStatus) {
  Weights<float> weights = initial_weights(Topology({4, 3, 1}), 1);
  const RowMatrix<float> frames{{1e4, -1e4, 1e4, 1e4},         {0, 0, 0, 0}, {NAN, 0, 0, 0}, {0, 0, 0, -inf},
                                {3e38f, 3e38f, -3e38f, 3e38f}, {1, 2, 3, 4}};
  for (const float saturation : {1.0f, 1e10f, 1e30f, 3e38f}) {
    for (const ScalingKind kind : {ScalingKind::set, ScalingKind::frame}) {
      Weights<float> saturated = weights;
      for (float& w : saturated.values) w *= saturation;
      const Recall<float> answer = recall(saturated, {kind, 1.0f}, frames);
      for (int row = 0; row < frames.rows(); ++row) {
        const bool none = answer.status[row] == FrameStatus::not_finite || answer.status[row] == FrameStatus::overflow;
        EXPECT_EQ(std::isnan(answer.slip_index(row)), none) << name(kind) << ' ' << saturation << " row " << row;
        EXPECT_TRUE(none || (answer.slip_index(row) >= 0 && answer.slip_index(row) <= 1));
      }
      EXPECT_EQ(answer.status[1], kind == ScalingKind::frame ? FrameStatus::no_stress : FrameStatus::ok);
      EXPECT_EQ(answer.status[2], FrameStatus::not_finite);
      EXPECT_EQ(answer.status[3], FrameStatus::not_finite);
    }
  }
}

TEST(Recall, RefusesFramesOfAnotherWidth) {
  EXPECT_THROW(recall(initial_weights(Topology({4, 3, 1}), 1), {}, RowMatrix<float>(2, 6)), ValueError);
}

}  // namespace forward_test
