// SPDX-License-Identifier: Apache-2.0
#include "nn/topology.h"

#include <gmock/gmock.h>

#include "tests/fem/expect_error.h"

namespace topology_test {

using namespace tactel;
using namespace tactel::nn;

// Weights counted by hand: (in + 1) out for each layer.
TEST(Topology, KnowsThePapersNetworks) {
  const char* text[] = {"42-42-1", "42-84-1", "42-21-1", "42-42-42-1", "42-42-82-1", "42-42-21-1"};
  const std::size_t weights[] = {1849, 3697, 925, 3655, 5415, 2731};
  for (int number = 1; number <= 6; ++number) {
    const Topology network = Topology::parse(std::to_string(number));
    EXPECT_EQ(network.text(), text[number - 1]);
    EXPECT_EQ(network, Topology::parse(text[number - 1]));
    EXPECT_EQ(network.weight_count(), weights[number - 1]);
    EXPECT_EQ(network.cycle_limit(), number < 4 ? 10000 : 15000);
  }
}

TEST(Topology, TakesAnyWidths) {
  const Topology network = Topology::parse("16-16-8-1");
  EXPECT_EQ(network.inputs(), 16);
  EXPECT_EQ(network.layers(), 3);
  EXPECT_EQ(network.layer_offset(1), 16u * 17);
  EXPECT_EQ(network.layer_offset(2), 16u * 17 + 8 * 17);
}

TEST(Topology, GivesABoundThreeOutputs) {
  const Topology network = Topology::parse("42-42-21-1");
  EXPECT_FALSE(network.has_bound());
  EXPECT_EQ(network.with_bound(), Topology::parse("42-42-21-3"));
  EXPECT_TRUE(network.with_bound().has_bound());
  EXPECT_EQ(network.with_bound().weight_count(), 2731u + 2 * 22);
}

TEST(Topology, NamesHiddenNeuronsOtherThanThePapers) {
  const Topology network = Topology::parse("42-96-96-1_leaky-relu");
  EXPECT_EQ(network.text(), "42-96-96-1_leaky-relu");
  EXPECT_NE(network, Topology::parse("42-96-96-1"));
  EXPECT_EQ(network, Topology::parse("42-96-96-1").with_activation(Activation::leaky_relu));
  EXPECT_EQ(network.activation(0), Activation::leaky_relu);
  EXPECT_EQ(network.activation(2), Activation::logistic);  // the output
  EXPECT_EQ(network.with_bound().text(), "42-96-96-3_leaky-relu");
  EXPECT_EQ(network.with_inputs(168).text(), "168-96-96-1_leaky-relu");
  EXPECT_EQ(Topology::parse("6_leaky-relu").text(), "42-42-21-1_leaky-relu");
  EXPECT_EQ(parse_activation("leaky-relu"), Activation::leaky_relu);
  EXPECT_THROW(parse_activation("relu"), ValueError);
}

TEST(Topology, SaysWhatIsWrong) {
  for (const char* bad : {"", "0", "7", "42", "42-1", "42-42-2", "42-0-1", "42--1", "42-42-1-", "-42-42-1",
                          "42-42-42-42-1", "42-385-1", "42-x-1", "42 -42-1", "99999-42-1", "_leaky-relu",
                          "42-42-1_relu", "42-42-1_leaky-relu_leaky-relu", "42-42-1-leaky-relu"}) {
    expect_value_error([&] { Topology::parse(bad); }, "network", "", "42-42-21-1");
  }
}

}  // namespace topology_test
