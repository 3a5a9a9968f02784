// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "fem/numbers/value_error.h"
#include "nn/frame_set.h"
#include "nn/philox.h"
#include "nn/presentation_order.h"
#include "nn/weights.h"

namespace random_test {

using namespace tactel;
using namespace tactel::nn;
using testing::ElementsAre;

// Known answers published with the generator (Random123, kat_vectors, philox4x32 10).
TEST(Philox, GivesThePublishedAnswers) {
  EXPECT_THAT(philox4x32({0, 0, 0, 0}, {0, 0}), ElementsAre(0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8));
  EXPECT_THAT(philox4x32({~0u, ~0u, ~0u, ~0u}, {~0u, ~0u}),
              ElementsAre(0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd));
  EXPECT_THAT(philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
              ElementsAre(0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1));
}

// Quad 2^32 + 5 belongs to row 409 million of a set with 42 inputs. From Python integers, too.
TEST(NoiseWords, GoOnBeyondTheFirst2To32) {
  EXPECT_THAT(noise_words(7, 5), ElementsAre(0xd132512e, 0x6f5a4d4d, 0xd0cc80b2, 0x742f7fd9));
  EXPECT_THAT(noise_words(7, (std::uint64_t{1} << 32) + 5),
              ElementsAre(0xec228467, 0xcba30739, 0x3a706581, 0x2f38d913));
}

// The numbers below come from a separate program (Python integers) that follows the headers' descriptions.
TEST(InitialWeights, AreTheSameEverywhere) {
  const Weights<float> weights = initial_weights(Topology::paper(1), 20);
  ASSERT_EQ(weights.values.size(), 1849u);
  EXPECT_EQ(weights.values[0], 0x1.af00a6p-2f);
  EXPECT_EQ(weights.values[1], 0x1.932a12p-2f);
  EXPECT_EQ(weights.values[2], -0x1.869d5p-5f);
  EXPECT_EQ(weights.values[4], 0x1.0b259cp-3f);
  EXPECT_EQ(weights.values[1848], 0x1.0b151ep-2f);
}

TEST(InitialWeights, AreUniformWithinTheBound) {
  double mean = 0, square = 0;
  int count = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    for (const float w : initial_weights(Topology::paper(5), seed).values) {
      ASSERT_LT(std::abs(w), initial_weight_bound);
      mean += w;
      square += double{w} * w;
      ++count;
    }
  }
  // Uniform in +-b: variance b^2 / 3; the mean of n draws has a deviation of b / sqrt(3 n), that of the squares less. 5
  // of them.
  const double b = initial_weight_bound, bound = 5 * b / std::sqrt(3.0 * count);
  EXPECT_NEAR(mean / count, 0, bound);
  EXPECT_NEAR(square / count, b * b / 3, bound);
}

// Of leaky rectifiers: a variance of 2 / fan in, 1 / fan in of the outputs, biases of 0. Of n draws that are uniform in
// +-b the mean of squares has a deviation of b^2 sqrt(4 / 45 n): five of them.
TEST(InitialWeights, OfLeakyRectifiersKeepTheSizeOfTheirInputs) {
  const Topology topology({100, 80, 60, 3}, Activation::leaky_relu);
  const Weights<float> weights = initial_weights(topology, 5);
  for (int l = 0; l < 3; ++l) {
    const auto w = weights.layer(l).leftCols(topology.fan_in(l));
    const double variance = (l < 2 ? 2.0 : 1.0) / topology.fan_in(l), n = static_cast<double>(w.size());
    EXPECT_LT(w.cwiseAbs().maxCoeff(), std::sqrt(3 * variance));
    EXPECT_NEAR(w.squaredNorm() / n, variance, 5 * 3 * variance * std::sqrt(4 / (45 * n))) << l;
    EXPECT_EQ(weights.layer(l).rightCols(1).cwiseAbs().maxCoeff(), 0) << l;
  }
}

TEST(PresentationOrder, FollowsItsDescription) {
  const std::uint64_t seed = (std::uint64_t{7} << 32) + 5;
  EXPECT_THAT(presentation_order(PresentationOrder::permuted, seed, 0, 10), ElementsAre(4, 6, 0, 2, 5, 8, 3, 7, 9, 1));
  EXPECT_THAT(presentation_order(PresentationOrder::permuted, seed, 3, 10), ElementsAre(3, 6, 2, 0, 1, 9, 7, 4, 8, 5));
  EXPECT_THAT(presentation_order(PresentationOrder::sequential, seed, 3, 4), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(presentation_order(PresentationOrder::permuted, seed, 3, 1), ElementsAre(0));
}

TEST(PresentationOrder, ShowsEveryRowOnce) {
  for (const std::uint32_t rows : {2u, 5u, 700u}) {
    std::vector<std::uint32_t> shown = presentation_order(PresentationOrder::permuted, 1, 2, rows);
    EXPECT_FALSE(rows == 700 && std::is_sorted(shown.begin(), shown.end()));
    std::sort(shown.begin(), shown.end());
    for (std::uint32_t row = 0; row < rows; ++row) EXPECT_EQ(shown[row], row);
  }
}

FrameSet flat_set(Eigen::Index rows, int inputs, float stress) {
  FrameSet set{.frames = RowMatrix<float>::Zero(rows, inputs)};
  set.frames(rows - 1, inputs - 1) = -stress;
  set.slip_index = Vector<float>::Constant(rows, 0.5f);
  return set;
}

TEST(Noise, FollowsItsDescription) {
  // Deviation 0.1 * 2 = 0.2 of the numbers that the separate program gave for seed 3; rounded once to float: 1 part in
  // 2^24.
  const FrameSet noisy = with_noise(flat_set(2, 4, 2.0f), 0.1, 3);
  const double expected[] = {-1.73845781718002,    1.4030233941601737, 0.7615151944903205,
                             -0.18383147735246008, 0.9459535599627411, 0.5541504463411119};
  for (int i = 0; i < 6; ++i)
    EXPECT_NEAR(noisy.frames.data()[i], 0.2 * expected[i], 0.2 * std::abs(expected[i]) * 0x1p-24);
}

// Row 410 million of a set with 42 inputs: its values lie beyond 2^34, their words beyond 2^32. The numbers of quad
// 2^32 + 5 with seed 7 are Box and Muller's from the words above, computed by Python. Begins within a quad.
TEST(Noise, FollowsItsDescriptionBeyondTheFirst2To32Words) {
  const double expected[] = {-0.38564918470536225, 0.6879674207969833, 1.575146689833468};
  const std::uint64_t first = 4 * ((std::uint64_t{1} << 32) + 5) + 1;
  ASSERT_GT(first / 42, 409'000'000u);
  std::vector<float> values(3, 0.0f);
  add_noise(values, 0.2, 7, first);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(values[i], 0.2 * expected[i], 0.2 * std::abs(expected[i]) * 0x1p-24) << i;
}

// In pieces of any size, as whole.
TEST(Noise, IsThatOfTheValueWhereverItsPieceBegins) {
  std::vector<float> whole(50, 0.0f), pieces(50, 0.0f);
  add_noise(whole, 1, 3, 0);
  for (const auto& [from, to] : {std::pair{0, 1}, {1, 3}, {3, 8}, {8, 50}})
    add_noise(std::span(pieces).subspan(from, to - from), 1, 3, from);
  EXPECT_EQ(pieces, whole);
}

TEST(Noise, HasTheDeviationAskedFor) {
  const FrameSet clean = flat_set(1000, 42, 5.0f);
  const RowMatrix<double> added = (with_noise(clean, 0.1, 9).frames - clean.frames).cast<double>();
  const double n = static_cast<double>(added.size());
  // Deviation 0.5: mean within 5 * 0.5 / sqrt(n), deviation within 5 * 0.5 / sqrt(2 n).
  EXPECT_NEAR(added.mean(), 0, 2.5 / std::sqrt(n));
  EXPECT_NEAR(std::sqrt((added.array() - added.mean()).square().mean()), 0.5, 2.5 / std::sqrt(2 * n));
  EXPECT_EQ(with_noise(clean, 0.0, 9).frames, clean.frames);
  EXPECT_NE(with_noise(clean, 0.1, 10).frames, with_noise(clean, 0.1, 9).frames);
  EXPECT_THROW(with_noise(clean, -0.1, 9), ValueError);
}

// Frames of largest stress 5 and 500: deviations of 0.5 and 50, within 5 standard errors. The copies keep S, and share
// no noise.
TEST(Noise, OfAFrameIsRelativeToItsOwnLargestStress) {
  FrameSet clean = flat_set(2, 1000, 5.0f);
  clean.frames.row(0).setConstant(5.0f);
  clean.frames.row(1).setConstant(-500.0f);
  const FrameSet noisy = with_frame_noise(clean, 0.1, 9, 3);
  ASSERT_EQ(noisy.rows(), 6);
  for (Eigen::Index row = 0; row < 6; ++row) {
    const auto added = (noisy.frames.row(row) - clean.frames.row(row % 2)).cast<double>().array().eval();
    const double deviation = row % 2 ? 50 : 0.5;
    EXPECT_NEAR(std::sqrt(added.square().mean()), deviation, 5 * deviation / std::sqrt(2000)) << row;
    EXPECT_EQ(noisy.slip_index(row), clean.slip_index(row % 2));
  }
  EXPECT_NE(noisy.frames.row(0), noisy.frames.row(2));
  EXPECT_NE(noisy.frames.row(2), noisy.frames.row(4));
  EXPECT_THROW(with_frame_noise(clean, 0.1, 9, 0), ValueError);
}

}  // namespace random_test
