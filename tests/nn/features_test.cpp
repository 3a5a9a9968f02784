// SPDX-License-Identifier: Apache-2.0

// The fixed layer before networks: sums by hand, one answer for all images of a frame, and what a network learns of it.
#include "nn/features.h"

#include <gtest/gtest.h>

#include <random>

#include "fem/numbers/value_error.h"
#include "nn/forward.h"
#include "nn/frame_set.h"
#include "nn/learning_view.h"
#include "nn/network.h"

namespace features_test {

using namespace tactel;
using namespace tactel::nn;

InputScaling pad(int columns, bool square, int history = 1) {
  return {ScalingKind::frame, 1.0f, history, 3, Features::pad, columns, square, 0.03f};
}
const InputScaling line{ScalingKind::frame, 1.0f, 1, 2, Features::line, 3, false, 0.03f};

std::vector<double> inputs_of(const InputScaling& scaling, std::vector<float> frame) {
  const int stresses = static_cast<int>(frame.size());
  std::vector<double> inputs(static_cast<std::size_t>(scaling.inputs(stresses)));
  EXPECT_EQ(scale_frame(scaling, frame.data(), stresses, inputs.data()), FrameStatus::ok);
  return inputs;
}

void expect_near(const std::vector<double>& got, const std::vector<double>& wanted) {
  ASSERT_EQ(got.size(), wanted.size());
  for (std::size_t k = 0; k < got.size(); ++k) EXPECT_NEAR(got[k], wanted[k], 1e-6) << k;
}

// 2 x 2 tactels at +-1/2. p = 1 and 1/2 in the left column, so P = 3/2 and c = (-1/2, -1/6); t = (0.3, 0) at the first
// tactel and (0, 0.1) at the second. By hand.
TEST(Features, SumsOfAPadAreThoseByHand) {
  const std::vector<double> sums{1.5, 0.3,       0.1, 0.2108185, 0.2,  0.0666667, 0.1333333, -0.5,      -0.1666667,
                                 0,   0.2222222, 0,   0.2666667, 0.25, 0.1111111, 0.0316228, -0.1054093};
  std::vector<double> wanted{-1, 0, -0.5, 0, 0.3, 0, 0, 0, 0, 0.1, 0, 0};
  wanted.insert(wanted.end(), sums.begin(), sums.end());
  wanted.push_back(0.4);  // 0.02 / (0.02 + 0.03)
  std::vector<float> frame{-1, 0, -0.5, 0, 0.3f, 0, 0, 0, 0, 0.1f, 0, 0};
  for (float& stress : frame) stress *= 0.02f;
  expect_near(inputs_of(pad(2, true), frame), wanted);
}

// Three tactels at -1, 0, 1 with p = 0, 1, 1/2 and t = 0, 0.2, 0.1, and the mirrored contact, whose t points back.
TEST(Features, SumsOfALineAreThoseByHand) {
  const std::vector<double> wanted{0,   -1,        -0.5,      0,   0.2,       0.1, 1.5, 0.3,
                                   0.2, 0.3333333, 0.2222222, 0.2, 0.2222222, 0,   0.4};
  for (const std::vector<float>& frame :
       {std::vector<float>{0, -0.02f, -0.01f, 0, 0.004f, 0.002f}, {-0.01f, -0.02f, 0, -0.002f, -0.004f, 0}})
    expect_near(inputs_of(line, frame), wanted);
}

/// The frame of the contact's image: mirrored left to right, then bottom to top, then with x and y exchanged.
std::vector<float> image(const std::vector<float>& frame, int columns, int axes, int which) {
  const int n = static_cast<int>(frame.size()) / axes, rows = n / columns;
  std::vector<float> made = frame;
  const bool mirror_x = which & 1, mirror_y = which & 2, turn = which & 4;
  for (int axis = 0; axis < axes; ++axis)
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i) {
        const int x = mirror_x ? columns - 1 - i : i, y = mirror_y ? rows - 1 - j : j;
        const int to_axis = turn && axis > 0 ? 3 - axis : axis;
        const float sign = (axis == 1 && mirror_x) || (axis == 2 && mirror_y) ? -1.0f : 1.0f;
        made[static_cast<std::size_t>(to_axis * n + (turn ? x * columns + y : y * columns + x))] =
            sign * frame[static_cast<std::size_t>(axis * n + j * columns + i)];
      }
  return made;
}

// Bit for bit. Frames of noise, so that no sum is 0 or equal to another.
TEST(Features, AllImagesOfAFrameAreOneInput) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  struct Case {
    InputScaling scaling;
    int tactels, images;
  };
  InputScaling long_line = line;
  long_line.columns = 21;
  for (const Case& c : {Case{pad(4, true), 16, 8}, {pad(3, false), 15, 4}, {pad(4, false), 16, 4}, {long_line, 21, 2}})
    for (int trial = 0; trial < 2000; ++trial) {
      std::vector<float> frame(static_cast<std::size_t>(c.scaling.axes * c.tactels));
      for (float& stress : frame) stress = normal(random);
      const std::vector<double> first = inputs_of(c.scaling, frame);
      for (int which = 1; which < c.images; ++which) {
        const std::vector<double> other = inputs_of(c.scaling, image(frame, c.scaling.columns, c.scaling.axes, which));
        ASSERT_EQ(first, other) << c.tactels << " tactels, image " << which;
      }
      if (c.images == 4 && c.tactels == 16) {  // not square
        EXPECT_NE(first, inputs_of(c.scaling, image(frame, 4, 3, 4)));
      }
    }
}

// The newest frame chooses the image of all.
TEST(Features, HistoryHasTheImageOfTheNewestFrame) {
  const std::vector<float> newest{-1, 0, 0, 0, -0.3f, 0, 0, 0, 0, 0.1f, 0, 0},
      before{0, -1, 0, 0, 0.2f, 0, 0, 0, 0, 0, 0, 0};
  std::vector<float> both = newest;
  both.insert(both.end(), before.begin(), before.end());
  const std::vector<double> inputs = inputs_of(pad(2, true, 2), both);
  ASSERT_EQ(inputs.size(), 24u + 2 * 17 + 1);
  const std::vector<double> mirrored{-1, 0, 0, 0, 0, -0.2f, 0, 0, 0, 0, 0, 0};
  for (std::size_t k = 0; k < 12; ++k) EXPECT_EQ(inputs[12 + k], mirrored[k]) << k;
  EXPECT_NEAR(inputs[24 + 17 + 1], -0.2, 1e-7);  // its Qx
}

TEST(Features, NeedScalingByFrameAndAKnownGrid) {
  const auto refused = [](InputScaling scaling) { EXPECT_THROW(scaling.validate(), ValueError); };
  InputScaling by_set = pad(4, true), no_grid = pad(0, false), two_axes = pad(4, true), three_axes = line;
  by_set.kind = ScalingKind::set;
  two_axes.axes = 2, three_axes.axes = 3;
  for (const InputScaling& scaling : {by_set, no_grid, two_axes, three_axes}) refused(scaling);
  EXPECT_NO_THROW(pad(4, true).validate());
  EXPECT_THROW(
      fit_scaling(ScalingKind::frame, FrameSet{.frames = RowMatrix<float>::Ones(1, 48), .axes = 3}, Features::pad),
      ValueError);
}

// A network that learnt from the view gives the same for inputs, once its weights are folded.
TEST(Features, FoldedWeightsMeanTheSame) {
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  const InputScaling scaling = pad(2, true, 3);
  RowMatrix<float> frames(200, 36);
  for (float& stress : frames.reshaped()) stress = normal(random);
  const LearningView view(scaling, frames);
  const RowMatrix<double> inputs = scale_frames<double>(scaling, frames);
  const Weights<double> learnt{initial_weights(Topology({88, 9, 1}), 1)}, folded = view.weights_of_inputs(learnt);
  double mean = 0, square = 0;
  for (Eigen::Index row = 0; row < 200; ++row) {
    Vector<double> seen = inputs.row(row).transpose();
    view.apply(seen.data());
    EXPECT_NEAR(forward(folded, Vector<double>(inputs.row(row).transpose())).back()(0), forward(learnt, seen).back()(0),
                1e-12);
    mean += seen(40) / 200, square += seen(40) * seen(40) / 200;
  }
  EXPECT_NEAR(mean, 0, 1e-5);
  EXPECT_NEAR(square, 1, 1e-4);
}

}  // namespace features_test
