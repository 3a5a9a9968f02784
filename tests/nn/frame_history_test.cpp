// SPDX-License-Identifier: Apache-2.0

// Inputs of several frames, worked by hand.
#include "nn/frame_history.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "fem/numbers/value_error.h"
#include "nn/forward.h"
#include "nn/frame_set.h"

namespace frame_history_test {

using namespace tactel;
using namespace tactel::nn;
using testing::ElementsAre;

/// Frames of two numbers: a normal stress, 1 MPa from the first on, and the shear stress given.
class ShearPath {
 public:
  explicit ShearPath(const InputHistory& input) : history_(2, input), input_(history_.inputs()) {}
  /// The shear stresses of the input.
  std::vector<float> push(float shear, float normal = 1) {
    const float frame[2] = {normal, shear};
    history_.push(frame);
    return input();
  }
  std::vector<float> input() {
    history_.write(input_.data());
    std::vector<float> shears;
    for (std::size_t k = 1; k < input_.size(); k += 2) shears.push_back(input_[k]);
    return shears;
  }
  FrameHistory& history() { return history_; }

 private:
  FrameHistory history_;
  std::vector<float> input_;
};

TEST(FrameHistory, KeepsFramesByChangeOfLoad) {
  ShearPath path({.frames = 3, .stride = 1, .change = 0.1});
  EXPECT_THAT(path.push(0.01f), ElementsAre(0.01f, 0, 0));      // kept: the first
  EXPECT_THAT(path.push(0.05f), ElementsAre(0.05f, 0, 0));      // 0.04 of 1 MPa: not kept
  EXPECT_THAT(path.push(0.10f), ElementsAre(0.10f, 0, 0));      // 0.09 from the kept 0.01
  EXPECT_THAT(path.push(0.20f), ElementsAre(0.20f, 0.01f, 0));  // 0.19: kept
  EXPECT_THAT(path.push(0.25f), ElementsAre(0.25f, 0.01f, 0));  // belongs to the kept 0.20
  EXPECT_THAT(path.push(0.40f), ElementsAre(0.40f, 0.20f, 0.01f));
  for (int pause = 0; pause < 100; ++pause)
    EXPECT_THAT(path.push(0.40f), ElementsAre(0.40f, 0.20f, 0.01f)) << "a pause teaches nothing";
  EXPECT_THAT(path.push(0.20f), ElementsAre(0.20f, 0.40f, 0.20f));
}

/// The age of a frame is how many frames came after it.
TEST(FrameHistory, TellsTheAgeOfItsFrames) {
  const InputHistory input{.frames = 3, .stride = 2, .change = 0.1};
  FrameHistory history(2, input);
  const auto push = [&](float shear) {
    const float frame[2] = {1, shear};
    history.push(frame);
    return std::pair(history.age(1), history.age(2));
  };
  using Ages = std::pair<std::optional<std::size_t>, std::optional<std::size_t>>;
  EXPECT_EQ(push(0), Ages(std::nullopt, std::nullopt));      // frame 0: kept
  EXPECT_EQ(push(0.2f), Ages(std::nullopt, std::nullopt));   // 1: kept
  EXPECT_EQ(push(0.25f), Ages(std::nullopt, std::nullopt));  // 2
  EXPECT_EQ(push(0.4f), Ages(3, std::nullopt));              // 3: kept; two kept frames before it is frame 0
  EXPECT_EQ(push(0.4f), Ages(4, std::nullopt));              // 4
  EXPECT_EQ(push(0.6f), Ages(4, std::nullopt));              // 5: kept; before it frame 3 and frame 1
  EXPECT_EQ(push(0.8f), Ages(3, 6));                         // 6: kept; frame 3, frame 0
  history.clear();
  EXPECT_EQ(push(0.8f), Ages(std::nullopt, std::nullopt));
}

TEST(FrameHistory, StrideTakesEveryOther) {
  ShearPath path({.frames = 3, .stride = 2, .change = 0.1});
  std::vector<float> last;
  for (int k = 0; k < 5; ++k) last = path.push(0.2f * static_cast<float>(k));
  EXPECT_THAT(last, ElementsAre(0.8f, 0.4f, 0));
  EXPECT_THAT(path.push(1.0f), ElementsAre(1.0f, 0.6f, 0.2f));
  EXPECT_THAT(path.push(1.2f), ElementsAre(1.2f, 0.8f, 0.4f));
}

/// The share is of the largest stress since the contact began, not of the newest frame.
TEST(FrameHistory, ChangeIsMeasuredByTheContactsLargestStress) {
  ShearPath path({.frames = 2, .stride = 1, .change = 0.1});
  path.push(0, 10);
  EXPECT_THAT(path.push(0, 5), ElementsAre(0, 0));
  EXPECT_THAT(path.push(0.9f, 5), ElementsAre(0.9f, 0));
  EXPECT_THAT(path.push(1.0f, 5), ElementsAre(1.0f, 0));
  EXPECT_THAT(path.push(1.1f, 5), ElementsAre(1.1f, 0));  // kept, as 1.1 is more than 0.1 * 10
  EXPECT_THAT(path.push(0.2f, 5), ElementsAre(0.2f, 0.0f));
  EXPECT_THAT(path.push(2.2f, 5), ElementsAre(2.2f, 1.1f));
}

TEST(FrameHistory, AFrameAtRestBeginsAnewContact) {
  ShearPath path({.frames = 2, .stride = 1, .change = 0.1});
  path.push(0.1f), path.push(0.5f);
  EXPECT_THAT(path.push(0.01f, 0.04f), ElementsAre(0.01f, 0));  // below 5 % of 1 MPa
  EXPECT_THAT(path.push(0.3f), ElementsAre(0.3f, 0.01f));       // what was before is forgotten
  ShearPath same({.frames = 2, .stride = 1, .change = 0.1});
  same.push(0.1f), same.push(0.5f);
  EXPECT_THAT(same.push(0.01f, 0.06f), ElementsAre(0.01f, 0.5f));  // above it: the same contact
}

TEST(FrameHistory, WhatIsNotFiniteIsAnsweredAndNotKept) {
  ShearPath path({.frames = 2, .stride = 1, .change = 0.1});
  path.push(0.1f);
  EXPECT_TRUE(std::isnan(path.push(std::numeric_limits<float>::quiet_NaN())[0]));
  EXPECT_THAT(path.push(0.5f), ElementsAre(0.5f, 0.1f));
  path.history().clear();
  EXPECT_THAT(path.input(), ElementsAre(0, 0));
  EXPECT_THAT(path.push(0.7f), ElementsAre(0.7f, 0));
}

/// Scaling a contact's E scales its inputs alike: the rule keeps the same frames.
TEST(FrameHistory, AFactorOfAllStressesChangesNoChoice) {
  const InputHistory input{.frames = 4, .stride = 1, .change = 0.07};
  ShearPath one(input), scaled(input);
  for (int k = 0; k < 40; ++k) {
    const float shear = 0.3f * std::sin(0.7f * static_cast<float>(k)), normal = 0.1f + 0.02f * static_cast<float>(k);
    const std::vector<float> a = one.push(shear, normal), b = scaled.push(4 * shear, 4 * normal);
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(4 * a[i], b[i]) << "step " << k;
  }
}

FrameSet two_contacts() {
  return {.frames = RowMatrix<float>{{1, 0}, {1, 0.5}, {1, 1}, {1, 2}, {1, 3}, {1, 4}},
          .slip_index = Vector<float>::LinSpaced(6, 0, 0.5),
          .contact = {3, 3, 3, 4, 4, 4},
          .step = {0, 1, 2, 0, 1, 3},
          .press_rows = true};
}

TEST(WithHistory, NeverCrossesTheBorderOfAContact) {
  const FrameSet formed = with_history(two_contacts(), {.frames = 3});
  EXPECT_EQ(formed.history, 3);
  const RowMatrix<float> expected{
      {1, 0, 0, 0, 0, 0}, {1, 0.5, 1, 0, 0, 0}, {1, 1, 1, 0.5, 1, 0},
      {1, 2, 0, 0, 0, 0}, {1, 3, 1, 2, 0, 0},   {1, 4, 0, 0, 0, 0}};  // step 2 is not there: the object was released
  EXPECT_EQ(formed.frames, expected);
  EXPECT_EQ(formed.slip_index, two_contacts().slip_index);
}

TEST(WithHistory, OneFrameChangesNothing) {
  FrameSet set = two_contacts();
  set.press_rows = false, set.contact.clear();
  EXPECT_EQ(with_history(set, {}).frames, set.frames);
  EXPECT_THROW(with_history(set, {.frames = 2}), ValueError);
  set = two_contacts();
  set.press_rows = false;
  EXPECT_THROW(with_history(set, {.frames = 2}), ValueError);
  set = two_contacts();
  set.step.pop_back();
  EXPECT_THROW(with_history(set, {.frames = 2}), ValueError);
}

// Of two axes a row is a normal stress and a shear; P is 1 MPa, in the last row 3. Its rest is the one earlier row with
// |S| below 0.9 and a P of its size, or the row itself. D / (1 + D) of a slide D since then: 0.25 / 1.25 and 1 / 2;
// of a way, from (-3, 1) to (-2.2, 0.4), D = 1; to (0, 5), D = 5.
TEST(WithHistory, ARestIsAnEarlierRowThatHolds) {
  FrameSet set{.frames = RowMatrix<float>{{-1, 0}, {-1, 0.5}, {-1, 0.75}, {-3, 1}},
               .slip_index = Vector<float>::Zero(4),
               .contact = {3, 3, 3, 3},
               .step = {4, 5, 6, 7}};
  set.slip = {0.1f, 0.95f, -1, 0.2f}, set.slid = {{0, 0}, {0.25f, 0}, {1, 0}, {1.5f, 0}};
  const FrameSet formed = with_history(set, {.frames = 2, .rest = true});
  EXPECT_EQ(formed.frames, (RowMatrix<float>{{-1, 0, -1, 0}, {-1, 0.5, -1, 0}, {-1, 0.75, -1, 0}, {-3, 1, -3, 1}}));
  EXPECT_EQ(formed.slip_index, (Vector<float>{{0, 0.2f, 0.5f, 0}}));
  set.slid = {{-3, 1}, {-2.2f, 0.4f}, {0, 5}, {7, 7}};
  EXPECT_TRUE(
      with_history(set, {.frames = 2, .rest = true}).slip_index.isApprox(Vector<float>{{0, 0.5f, 5.0f / 6, 0}}, 1e-6f));
  set.slip.clear();
  EXPECT_THROW(with_history(set, {.frames = 2, .rest = true}), ValueError);
}

// Of 3000 rows each of the nine earlier ones is the rest of some 333: six standard deviations are 104.
TEST(WithHistory, ARestIsAnyOfThoseThatHold) {
  constexpr int contacts = 3000, rows = 10;
  FrameSet set{.frames = RowMatrix<float>::Constant(contacts * rows, 2, -1),
               .slip_index = Vector<float>::Zero(contacts * rows)};
  for (int row = 0; row < contacts * rows; ++row) {
    set.frames(row, 1) = static_cast<float>(row % rows);
    set.contact.push_back(static_cast<std::uint64_t>(row / rows)),
        set.step.push_back(static_cast<std::uint32_t>(row % rows));
  }
  set.slip.assign(contacts * rows, 0.5f);
  const FrameSet formed = with_history(set, {.frames = 2, .rest = true});
  std::array<int, rows> taken{};
  for (int row = rows - 1; row < contacts * rows; row += rows) ++taken[static_cast<std::size_t>(formed.frames(row, 3))];
  for (int i = 0; i < rows - 1; ++i) EXPECT_NEAR(taken[static_cast<std::size_t>(i)], 333, 104) << i;
}

// Told exactly, not at all, and drawn: a quarter is silent (six standard deviations of 20 000 are 0.018), the logarithm
// of the spread is even between those of 0.02 and 1 (mean -1.956, deviation 3.912 / sqrt(12)), and so many spreads
// apart from mu is a normal number.
TEST(WithHistory, FrictionIsToldWithItsSpread) {
  constexpr int rows = 20000;
  FrameSet set{.frames = RowMatrix<float>::Constant(rows, 2, -1), .slip_index = Vector<float>::Zero(rows)};
  for (int row = 0; row < rows; ++row) set.contact.push_back(static_cast<std::uint64_t>(row)), set.step.push_back(0);
  set.friction.assign(rows, 0.6f);
  const FrameSet exact = with_history(set, {.friction = true}, 0.0);
  EXPECT_EQ(exact.told, 2);
  EXPECT_EQ(exact.frames.row(7), (Eigen::RowVector4f{-1, -1, 0.6f, 0}));
  EXPECT_EQ(with_history(set, {.friction = true}, INFINITY).frames.rightCols(2), (RowMatrix<float>::Zero(rows, 2)));
  const FrameSet drawn = with_history(set, {.friction = true});
  double silent = 0, logs = 0, normal = 0, squares = 0;
  for (int row = 0; row < rows; ++row) {
    const float mu = drawn.frames(row, 2), spread = drawn.frames(row, 3);
    silent += mu == 0;
    if (mu == 0) continue;
    const double apart = std::log(mu / 0.6) / spread;
    logs += std::log(spread), normal += apart, squares += apart * apart;
  }
  const double told = rows - silent;
  EXPECT_NEAR(silent / rows, 0.25, 0.018);
  EXPECT_NEAR(logs / told, std::log(0.02) / 2, 0.056);
  EXPECT_NEAR(normal / told, 0, 0.05);
  EXPECT_NEAR(squares / told, 1, 0.07);
  EXPECT_EQ(with_noise(drawn, 0.1, 3).frames.rightCols(2), drawn.frames.rightCols(2));
  EXPECT_EQ(drawn.largest_stress(), 1);
  set.friction.clear();
  EXPECT_THROW(with_history(set, {.friction = true}), ValueError);
}

TEST(WithHistory, DifferencesAreToTheNewestFrame) {
  RowMatrix<float> frames{{1, 2, 0.5, 3, 0, 0}};
  take_differences(frames, 3);
  EXPECT_EQ(frames, (RowMatrix<float>{{1, 2, -0.5, 1, -1, -2}}));
}

/// w . (f, a - f, b - f) = w' . (f, a, b), with a bias; rounding of three products of numbers below 10.
TEST(WithHistory, FoldedWeightsGiveTheSameSums) {
  Weights<float> weights = initial_weights(Topology({6, 4, 1}), 5);
  const Weights<float> folded = weights_of_frames(weights, 3);
  RowMatrix<float> frames{{1, 2, 0.5, 3, -4, 0.25}}, differences = frames;
  take_differences(differences, 3);
  const Vector<float> a = weights.layer(0).leftCols(6) * differences.row(0).transpose();
  const Vector<float> b = folded.layer(0).leftCols(6) * frames.row(0).transpose();
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 4e-6f);
  EXPECT_EQ(folded.layer(0).col(6), weights.layer(0).col(6));
  EXPECT_EQ(folded.layer(1), weights.layer(1));
  EXPECT_EQ(weights_of_frames(weights, 1).values, weights.values);
}

/// All frames of an input are divided by the newest frame's largest normal stress.
TEST(WithHistory, TheNewestFrameScalesAll) {
  const InputScaling scaling{ScalingKind::frame, 1.0f, 2};
  const RowMatrix<float> frames{{1, -2, 4, 6, 8, 10, 12, 14}};
  EXPECT_EQ(scale_frames<float>(scaling, frames), (RowMatrix<float>{{0.5, -1, 2, 3, 4, 5, 6, 7}}));
  EXPECT_EQ(scale_frames<float>(scaling, 3 * frames), scale_frames<float>(scaling, frames) * 1.0f);
}

}  // namespace frame_history_test
