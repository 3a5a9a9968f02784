// SPDX-License-Identifier: Apache-2.0

// The bound in network files: the standard's checker, a runtime that does not know tactel, and broken tables.
#include <gmock/gmock.h>
#include <onnx/checker.h>

#include "host/networks/forward.h"
#include "host/networks/onnx_file.h"
#include "tests/host/networks/bounded_model.h"
#include "tests/host/networks/crafted_network.h"
#include "tests/host/networks/onnx_evaluator.h"
#include "tests/scratch.h"

namespace onnx_bound_test {

using namespace tactel;
using namespace tactel::host;
using nn::ScalingKind;
using tactel::tests::bounded_model;
using tactel::tests::bumps;
using tactel::tests::executor;
using tactel::tests::OnnxEvaluator;
using tactel::tests::parsed;

TEST(OnnxBound, SatisfiesTheStandardsChecker) {
  for (const ScalingKind kind : {ScalingKind::set, ScalingKind::frame})
    EXPECT_NO_THROW(onnx::checker::check_model(parsed(bounded_model("16-16-8-3", kind))));
}

// Another runtime gives S, bound and interval of the forward kernel and nn::bounded within 1e-5, on every row, in many
// classes; and says of the same frames that they are unlike. The values lie well away from the edges of classes.
TEST(OnnxBound, MeansTheSameToAnotherRuntime) {
  for (const char* topology : {"42-42-21-3", "14-9-3", "14-9-3_leaky-relu"}) {
    for (const ScalingKind kind : {ScalingKind::set, ScalingKind::frame}) {
      const bool by_distance = topology[0] == '1';
      const nn::Model model = bounded_model(topology, kind, by_distance);
      const int inputs = model.weights.topology.inputs();
      nn::FrameSet set = bumps(300, inputs, 9);
      set.frames.row(3).setZero();
      set.frames.row(4) *= 1e3f;
      set.frames.row(5).reverseInPlace();
      Forward<float> forward(executor(), std::span(&model.weights, 1), model.scaling);
      const nn::Recall<float> answer = forward.recall(set.frames);
      const std::vector<nn::BoundAnswer> own = tactel::tests::bounds_of(model, answer, set.frames);
      const auto other = OnnxEvaluator(parsed(model)).all(set.frames.cast<double>());
      std::map<double, int> classes;
      int unlike = 0;
      for (int row = 0; row < 300; ++row) {
        const nn::BoundAnswer& bound = own[static_cast<std::size_t>(row)];
        EXPECT_NEAR(other.at("slip_index")(row), answer.slip_index(row), 1e-5) << row;
        EXPECT_NEAR(other.at("slip_upper")(row), bound.upper, 1e-5) << row;
        EXPECT_NEAR(other.at("slip_interval")(row, 0), bound.interval[0], 1e-5) << row;
        EXPECT_NEAR(other.at("slip_interval")(row, 1), bound.interval[1], 1e-5) << row;
        EXPECT_EQ(other.at("unlike")(row), bound.unlike ? 1 : 0) << row;
        ++classes[other.at("class")(row)];
        unlike += bound.unlike;
      }
      EXPECT_GT(classes.size(), 3u);
      EXPECT_EQ(other.contains("class6"), by_distance);
      EXPECT_GT(unlike, 0);
      EXPECT_LT(unlike, 300);
    }
  }
}

TEST(OnnxBound, IsReadBackAsItWas) {
  const nn::Model model = bounded_model("16-9-3", ScalingKind::frame);
  const ScratchFolder folder;
  write_onnx(folder / "network.onnx", model);
  const nn::Model read = read_onnx(folder / "network.onnx");
  ASSERT_TRUE(read.bound);
  EXPECT_EQ(read.bound->touching, model.bound->touching);
  EXPECT_EQ(read.bound->slip_index, model.bound->slip_index);
  EXPECT_EQ(read.bound->width, model.bound->width);
  EXPECT_EQ(read.bound->distance, model.bound->distance);
  EXPECT_EQ(read.bound->upper_correction, model.bound->upper_correction);
  EXPECT_EQ(read.bound->interval_correction, model.bound->interval_correction);
  EXPECT_EQ(read.bound->centre, model.bound->centre);
  EXPECT_EQ(read.bound->whitening, model.bound->whitening);
  EXPECT_EQ(read.bound->unlike_above, model.bound->unlike_above);
  EXPECT_EQ(read.bound->tactels, 8);
  EXPECT_EQ(read.bound->level, 0.9);
  EXPECT_EQ(read.bound->set, "other.h5");
  EXPECT_EQ(read.bound->rows, 4321u);
  EXPECT_EQ(read.bound->seed, 77u);
}

}  // namespace onnx_bound_test
