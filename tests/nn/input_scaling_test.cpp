// SPDX-License-Identifier: Apache-2.0
#include "nn/input_scaling.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "fem/numbers/value_error.h"
#include "nn/frame_set.h"
#include "tests/fem/expect_error.h"

namespace input_scaling_test {

using namespace tactel;
using namespace tactel::nn;
using testing::Each;
using testing::ElementsAre;

constexpr float inf = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

struct Scaled {
  FrameStatus status;
  std::vector<float> values;
};
Scaled scale(const InputScaling& scaling, const std::vector<float>& frame) {
  std::vector<float> scaled(frame.size(), not_a_number);
  return {scale_frame(scaling, frame.data(), static_cast<int>(frame.size()), scaled.data()), scaled};
}
const InputScaling by_frame{ScalingKind::frame, 1.0f};

TEST(InputScaling, BySetDividesByTheSetsLargestStress) {
  const FrameSet set{.frames = RowMatrix<float>{{1, -2, 0.5, 0}, {0.25, 0, -4, 1}},
                     .slip_index = Vector<float>::Zero(2)};
  const InputScaling scaling = fit_scaling(ScalingKind::set, set);
  EXPECT_EQ(scaling.largest_stress, 4.0f);
  EXPECT_THAT(scale(scaling, {1, -2, 0.5, 0}).values, ElementsAre(0.25f, -0.5f, 0.125f, 0.0f));
  EXPECT_EQ(scale(scaling, {0, 0, 0, 0}).status, FrameStatus::ok);
}

TEST(InputScaling, ByFrameDividesByItsLargestNormalStress) {
  EXPECT_THAT(scale(by_frame, {1, -2, 8, 0}).values, ElementsAre(0.5f, -1.0f, 4.0f, 0.0f));
}

// Two frames of two tactels with three axes, one that has a normal stress alone: tau_x of 8 MPa and the earlier frame
// count for nothing.
TEST(InputScaling, ByFrameTakesTheNormalStressesOfAPad) {
  InputScaling pad = by_frame;
  pad.axes = 3, pad.history = 2;
  EXPECT_THAT(scale(pad, {1, -2, 8, 0, 4, 0, 6, 6, 0, 0, 0, 0}).values,
              ElementsAre(0.5f, -1.0f, 4.0f, 0.0f, 2.0f, 0.0f, 3.0f, 3.0f, 0.0f, 0.0f, 0.0f, 0.0f));
  pad.axes = 1, pad.history = 1;
  EXPECT_THAT(scale(pad, {1, 0, -4}).values, ElementsAre(0.25f, 0.0f, -1.0f));
  const FrameSet set{.frames = RowMatrix<float>{{1, 2, 3}}, .slip_index = Vector<float>::Zero(1), .axes = 3};
  EXPECT_EQ(fit_scaling(ScalingKind::frame, set).axes, 3);
}

// Two tactels with two axes, the newest frame and the rest, whose P is 2 + 2 MPa. A rest without P is none.
TEST(InputScaling, ByRestTakesDifferencesOverItsForce) {
  const InputScaling rest{ScalingKind::rest, 1.0f, 2};
  const auto scaled = [&](const std::vector<float>& frames) {
    std::vector<float> x(static_cast<std::size_t>(rest.inputs(static_cast<int>(frames.size()))), not_a_number);
    return Scaled{scale_frame(rest, frames.data(), static_cast<int>(frames.size()), x.data()), x};
  };
  EXPECT_EQ(rest.numbers(4), 8);
  EXPECT_THAT(scaled({-3, -1, 0.5f, 0.25f, -2, -2, 0.5f, 0}).values, ElementsAre(-0.25f, 0.25f, 0.0f, 0.0625f));
  for (const float largest : {0x1p-30f, 0x1p127f})  // 2^127 + 2^127 is infinity in fp32
    EXPECT_THAT(scaled({-largest, largest, 0, 0, -largest, -largest, largest, 0}).values,
                ElementsAre(0.0f, 1.0f, -0.5f, 0.0f));
  for (const std::vector<float>& none : {std::vector<float>{-1, -1, 0, 0, 0, 0, 0, 0}, {-1, -1, 0, 0, 2, -1, 0, 0}}) {
    EXPECT_EQ(scaled(none).status, FrameStatus::no_stress);
    EXPECT_THAT(scaled(none).values, Each(0.0f));
  }
  EXPECT_EQ(scaled({-1, -1, 0, 0, -1, not_a_number, 0, 0}).status, FrameStatus::not_finite);
  InputScaling alone = rest;
  alone.history = 1;
  EXPECT_THROW(alone.validate(), ValueError);
}

// Above 2^126 the reciprocal of a stress is no normal number in fp32; the answer is nevertheless the exact quotient.
TEST(InputScaling, ByFrameHoldsUpToTheLargestFloat) {
  for (const float factor : {0x1p125f, 0x1p126f, 0x1p127f})
    EXPECT_THAT(scale(by_frame, {0.5f * factor, -1.0f * factor, 0.25f * factor, 0}).values,
                ElementsAre(0.5f, -1.0f, 0.25f, 0.0f));
}

TEST(InputScaling, RefusesASetWhoseReciprocalIsNoNormalNumber) {
  const auto set_with = [](float stress) {
    return FrameSet{.frames = RowMatrix<float>{{stress, 0}}, .slip_index = Vector<float>::Zero(1)};
  };
  EXPECT_NO_THROW(fit_scaling(ScalingKind::set, set_with(0x1p126f)));
  EXPECT_THROW(fit_scaling(ScalingKind::set, set_with(1e38f)), ValueError);
  EXPECT_THROW(fit_scaling(ScalingKind::set, set_with(1e-13f)), ValueError);
  EXPECT_NO_THROW(fit_scaling(ScalingKind::frame, set_with(1e38f)));
}

TEST(InputScaling, ByFrameSaysWhenThereIsNoStress) {
  for (const std::vector<float>& frame :
       {std::vector<float>{0, 0, 0, 0}, {0, 0, 3, -3}, {1e-13f, 0, 1, 0}, {-0.0f, 0, 0, 0}}) {
    const Scaled scaled = scale(by_frame, frame);
    EXPECT_EQ(scaled.status, FrameStatus::no_stress);
    EXPECT_THAT(scaled.values, Each(0.0f));
  }
}

TEST(InputScaling, FramesThatAreNotFiniteBecomeZeros) {
  for (const InputScaling& scaling : {by_frame, InputScaling{}}) {
    for (const std::vector<float>& frame :
         {std::vector<float>{1, not_a_number, 0, 0}, {inf, 0, 0, 0}, {1, 0, 0, -inf}}) {
      const Scaled scaled = scale(scaling, frame);
      EXPECT_EQ(scaled.status, FrameStatus::not_finite);
      EXPECT_THAT(scaled.values, Each(0.0f));
    }
  }
}

TEST(InputScaling, RefusesWhatCannotScale) {
  EXPECT_THROW(parse_scaling("max"), ValueError);
  EXPECT_EQ(parse_scaling("frame"), ScalingKind::frame);
  for (const float divisor : {0.0f, -1.0f, not_a_number, inf, 1e-13f})
    EXPECT_THROW((InputScaling{ScalingKind::set, divisor}.validate()), ValueError) << divisor;
  const FrameSet zeros{.frames = RowMatrix<float>::Zero(3, 4), .slip_index = Vector<float>::Zero(3)};
  EXPECT_THROW(fit_scaling(ScalingKind::set, zeros), ValueError);
}

// Two frames of two tactels in a row, the newest first. Of 300 peaks of 1 to 300 MPa, three, 1 %, are below 4. A frame
// without stress has no peak, and a bonded contact no friction.
TEST(FrameSet, TheRangesThatANetworkLearns) {
  FrameSet set{RowMatrix<float>::Zero(301, 8), Vector<float>::Zero(301), {}, {}};
  set.history = 2;
  for (Eigen::Index row = 0; row < 300; ++row) {
    const auto peak = static_cast<float>(row + 1);
    set.frames.row(row) << 0.5f * peak, row % 2 == 0 ? peak : -peak, 1e3f, 1e3f, 1e4f, 0, 0, 0;
    set.friction.push_back(0.2f + 0.001f * peak);
  }
  set.friction.push_back(INFINITY);
  const Learnt learnt = learnt_ranges(set);
  EXPECT_EQ(learnt.smallest_peak, 4);
  EXPECT_EQ(learnt.largest_peak, 300);
  EXPECT_FLOAT_EQ(learnt.least_friction, 0.201f);
  EXPECT_FLOAT_EQ(learnt.most_friction, 0.5f);
  const Learnt none = learnt_ranges({RowMatrix<float>::Zero(2, 4), Vector<float>::Zero(2), {}, {}});
  EXPECT_EQ(none.smallest_peak, 0);
  EXPECT_EQ(none.most_friction, 0);
}

TEST(FrameSet, NamesTheRowThatIsWrong) {
  FrameSet set{.frames = RowMatrix<float>::Ones(3, 4), .slip_index = Vector<float>::Zero(3)};
  EXPECT_NO_THROW(set.validate());
  set.slip_index(1) = not_a_number;
  expect_value_error([&] { set.validate(); }, "slip_index[1]", "", "");
  set.slip_index(1) = 0;
  set.frames(2, 3) = inf;
  EXPECT_THROW(set.validate(), ValueError);
  set.frames(2, 3) = 0;
  set.shape_class = {1, 2};
  EXPECT_THROW(set.validate(), ValueError);
}

}  // namespace input_scaling_test
