// SPDX-License-Identifier: Apache-2.0

// The bound in network files: the standard's checker, a runtime that does not know tactel, and broken tables.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <onnx/checker.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>

#include "host/networks/forward.h"
#include "host/networks/onnx_file.h"
#include "host/support/errors.h"
#include "host/training/bound_report.h"
#include "nn/infer/network_file.h"
#include "tests/host/networks/bounded_model.h"
#include "tests/host/networks/crafted_network.h"
#include "tests/host/networks/onnx_evaluator.h"

namespace {

using namespace tactel;
using namespace tactel::host;
using nn::ScalingKind;
using tactel::testing::bounded_model;
using tactel::testing::bumps;
using tactel::testing::executor;
using tactel::testing::OnnxEvaluator;
using tactel::testing::parsed;
using tactel::testing::sealed;
namespace fs = std::filesystem;

onnx::TensorProto& tensor_of(onnx::ModelProto& proto, const std::string& name) {
  for (onnx::TensorProto& tensor : *proto.mutable_graph()->mutable_initializer())
    if (tensor.name() == name) return tensor;
  throw std::logic_error(name);
}

/// The message about a file with this tensor changed and a checksum that matches.
std::string refusal(const std::string& name, const std::function<void(onnx::TensorProto&)>& change) {
  onnx::ModelProto proto = parsed(bounded_model("16-9-3", ScalingKind::set));
  change(tensor_of(proto, name));
  const fs::path path = fs::temp_directory_path() / "tactel_onnx_bound.onnx";
  std::ofstream(path, std::ios::binary) << sealed(proto);
  std::string message = "no error";
  try {
    read_onnx(path);
  } catch (const ConfigError& error) {
    message = error.what();
  }
  fs::remove(path);
  return message;
}

}  // namespace

TEST(OnnxBound, SatisfiesTheStandardsChecker) {
  for (const ScalingKind kind : {ScalingKind::set, ScalingKind::frame})
    EXPECT_NO_THROW(onnx::checker::check_model(parsed(bounded_model("16-16-8-3", kind))));
}

// Another runtime gives S, bound and interval of the forward kernel and nn::bounded within 1e-5, on every row, in many
// classes; and says of the same frames that they are unlike. The values lie well away from the edges of classes.
TEST(OnnxBound, MeansTheSameToAnotherRuntime) {
  for (const char* topology : {"42-42-21-3", "16-9-3", "16-9-3_leaky-relu"}) {
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
      const std::vector<nn::BoundAnswer> own = bounds_of(model, answer, set);
      const OnnxEvaluator::Tensor input{{300, inputs}, {set.frames.data(), set.frames.data() + set.frames.size()}};
      const auto other = OnnxEvaluator(parsed(model)).all(input);
      std::map<double, int> classes;
      int unlike = 0;
      for (int row = 0; row < 300; ++row) {
        const nn::BoundAnswer& bound = own[static_cast<std::size_t>(row)];
        EXPECT_NEAR(other.at("slip_index").data[row], answer.slip_index(row), 1e-5) << row;
        EXPECT_NEAR(other.at("slip_upper").data[row], bound.upper, 1e-5) << row;
        EXPECT_NEAR(other.at("slip_interval").data[2 * row], bound.interval[0], 1e-5) << row;
        EXPECT_NEAR(other.at("slip_interval").data[2 * row + 1], bound.interval[1], 1e-5) << row;
        EXPECT_EQ(other.at("unlike").data[row], bound.unlike ? 1 : 0) << row;
        ++classes[other.at("class").data[row]];
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
  const fs::path path = fs::temp_directory_path() / "tactel_onnx_bound_back.onnx";
  write_onnx(path, model);
  const nn::Model read = read_onnx(path);
  fs::remove(path);
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

// Files with a matching checksum whose tables hold other numbers (of other changes: CraftedNetworks).
TEST(OnnxBound, RefusesOtherNumbers) {
  const auto not_finite = [](onnx::TensorProto& tensor) {
    const float nan = NAN;
    std::string raw = tensor.raw_data();
    std::memcpy(raw.data(), &nan, sizeof nan);
    tensor.set_raw_data(raw);
  };
  for (const char* name : {"upper_corrections", "interval_corrections", "centre", "whitening", "unlike_above",
                           "touching_edges", "slip_index_edges", "width_edges", "distance_edges"})
    EXPECT_THAT(refusal(name, not_finite), ::testing::HasSubstr("must be")) << name;
  const auto seven = [](onnx::TensorProto& tensor) {
    const std::int64_t number = 7;
    tensor.set_raw_data(&number, sizeof number);
  };
  EXPECT_THAT(refusal("tactels", seven), ::testing::HasSubstr("must be"));
  EXPECT_THAT(refusal("column1", seven), ::testing::HasSubstr("must be"));
}
