// SPDX-License-Identifier: Apache-2.0

// Networks with features: kernel, twin, library and file.
#include <gtest/gtest.h>
#include <onnx/checker.h>

#include <random>

#include "host/networks/forward.h"
#include "host/networks/network_training.h"
#include "host/networks/onnx_file.h"
#include "nn/infer/network_file.h"
#include "tests/host/networks/network_cases.h"
#include "tests/host/networks/onnx_evaluator.h"

namespace features_test {

using namespace tactel;
using namespace tactel::host;
using nn::Features;
using nn::FrameStatus;
using tactel::tests::bumps;
using tactel::tests::executor;
using tactel::tests::OnnxEvaluator;

struct Case {
  const char* name;
  nn::InputScaling scaling;
  int stresses;
};
const nn::ScalingKind by_frame = nn::ScalingKind::frame, by_rest = nn::ScalingKind::rest;
const Case line{"line", {by_frame, 1, 1, 2, Features::line, 21, false, 0.5f}, 42},
    square{"square pad", {by_frame, 1, 1, 3, Features::pad, 4, true, 0.5f}, 48},
    oblong{"oblong pad", {by_frame, 1, 1, 3, Features::pad, 3, false, 0.5f}, 36},
    history{"pad with history", {by_frame, 1, 4, 3, Features::pad, 2, true, 0.5f}, 48},
    rest{"rest", {by_rest, 1, 2, 3}, 96}, rest_of_line{"line by rest", {by_rest, 1, 2, 2, Features::line, 21}, 84},
    rest_and_history{"pad by rest with history", {by_rest, 1, 4, 3, Features::pad, 4, true}, 192},
    friction_by_set{"friction by set", {.largest_stress = 1.3f, .friction = true}, 44},
    friction_by_rest{"friction by rest", {.kind = by_rest, .history = 2, .axes = 3, .friction = true}, 98},
    friction{"friction",
             {.kind = by_frame, .axes = 3, .features = Features::pad, .columns = 4, .square = true, .friction = true},
             50};

nn::Model model_of(const Case& c, const char* hidden = "16-9-1") {
  std::vector<int> widths = nn::Topology::parse(hidden).widths();
  widths.insert(widths.begin(), c.scaling.inputs(c.stresses));
  nn::Model model{nn::initial_weights(nn::Topology(widths), 3), c.scaling, 3, 0, "none", 1, {}};
  for (float& weight : model.weights.values) weight *= 3;  // S well away from 0.5
  model.history.frames = c.scaling.history, model.history.rest = c.scaling.kind == by_rest;
  model.history.friction = c.scaling.friction;
  model.magnitude = c.scaling.features == Features::line;
  return model;
}

/// Some frames; three have no answer of their own: NaN, no stress, stress that is no normal number.
nn::RowMatrix<float> frames_of(const Case& c) {
  nn::RowMatrix<float> frames = bumps(203, c.stresses, 4).frames;
  const int normals = c.scaling.normals(c.stresses), width = c.scaling.width(c.stresses);
  frames.leftCols(normals).array() -= 0.1f;
  if (c.scaling.kind == by_rest) {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform(-0.5f, 0.5f);
    for (float& stress : frames.reshaped()) stress += uniform(random);  // each frame has shear, whose image is no tie
    frames.middleCols(width * (c.scaling.history - 1), normals).array() -= 1;
  }
  if (c.scaling.friction)
    for (int row = 0; row < 203; ++row)
      frames.row(row).tail(2) << 0.05f * static_cast<float>(row % 30), 0.01f * static_cast<float>(row % 60);  // also 0
  frames(5, 1) = NAN;
  frames.row(6).setZero();
  frames.row(7) *= c.scaling.kind == nn::ScalingKind::set ? 1e30f : 1e38f;
  return frames;
}

/// Every case has fp32, in a program of its own; fp64 the first of a line and of a pad, and at night all.
bool in_both_precisions(const Case& c) {
  const std::string suite = ::testing::UnitTest::GetInstance()->current_test_info()->test_suite_name();
  return suite.starts_with("Nightly") || c.scaling == line.scaling || c.scaling == rest_and_history.scaling;
}

class FeaturesOnDevice : public ::testing::TestWithParam<Case> {};

// As ForwardTopology.MatchesReference. The library has the bits of the kernel in fp32.
TEST_P(FeaturesOnDevice, KernelTwinAndLibraryAgree) {
  const Case& c = GetParam();
  const nn::Model model = model_of(c);
  const nn::RowMatrix<float> frames = frames_of(c);
  const nn::Weights<double> weights(model.weights);
  const nn::Recall<double> truth = nn::recall(weights, c.scaling, frames);
  const nn::Recall<double> d =
      in_both_precisions(c) ? Forward<double>(executor(), std::span(&weights, 1), c.scaling).recall(frames) : truth;
  const nn::Recall<float> f = Forward<float>(executor(), std::span(&model.weights, 1), c.scaling).recall(frames);
  const SlipEstimator library = infer::estimator_of(model);
  ASSERT_EQ(library.inputs(), static_cast<std::size_t>(c.stresses));
  EXPECT_EQ(d.status, truth.status);
  EXPECT_EQ(f.status, truth.status);
  EXPECT_EQ(f.status[5], FrameStatus::not_finite);
  EXPECT_EQ(f.status[6], c.scaling.kind == nn::ScalingKind::set ? FrameStatus::ok : FrameStatus::no_stress);
  for (int row = 0; row < 203; ++row) {
    const Answer answer = library.estimate({frames.row(row).data(), static_cast<std::size_t>(c.stresses)});
    EXPECT_EQ(static_cast<int>(answer.status), static_cast<int>(f.status[static_cast<std::size_t>(row)])) << row;
    if (row == 5) continue;
    EXPECT_NEAR(d.slip_index(row), truth.slip_index(row), 1e-13) << row;
    EXPECT_NEAR(f.slip_index(row), truth.slip_index(row), 1e-5) << row;
    EXPECT_EQ(answer.slip_index, f.slip_index(row)) << row;
  }
  EXPECT_GT(truth.slip_index.tail(150).maxCoeff() - truth.slip_index.tail(150).minCoeff(), 0.05);
}

// Read back as it was; ONNX's own checker takes it; another runtime gives the same S.
TEST_P(FeaturesOnDevice, FileMeansTheSameToAnotherRuntime) {
  const Case& c = GetParam();
  const nn::Model model = model_of(c);
  const std::string bytes = infer::network_bytes(model);
  const nn::Model read = infer::read_network(bytes).model;
  EXPECT_EQ(read.scaling, model.scaling);
  EXPECT_EQ(read.weights.values, model.weights.values);
  onnx::ModelProto file;
  ASSERT_TRUE(file.ParseFromString(bytes));
  EXPECT_NO_THROW(onnx::checker::check_model(file));
  nn::RowMatrix<float> frames = frames_of(c);
  frames.row(5) = frames.row(8), frames.row(7) = frames.row(9);
  const nn::Recall<float> own = Forward<float>(executor(), std::span(&model.weights, 1), c.scaling).recall(frames);
  const OnnxEvaluator::Tensor s = OnnxEvaluator(file).run(frames.cast<double>());
  ASSERT_TRUE(s.rows() == 203 && s.cols() == 1);
  for (int row = 0; row < 203; ++row) EXPECT_NEAR(s(row), own.slip_index(row), 1e-5) << row;
}

const auto name_of = [](const auto& info) {
  std::string name = info.param.name;
  std::ranges::replace(name, ' ', '_');
  return name;
};
INSTANTIATE_TEST_SUITE_P(All, FeaturesOnDevice,
                         ::testing::Values(line, square, oblong, rest_and_history, friction_by_set), name_of);
INSTANTIATE_TEST_SUITE_P(Nightly, FeaturesOnDevice,
                         ::testing::Values(square, oblong, friction_by_set, history, rest, rest_of_line,
                                           friction_by_rest, friction),
                         name_of);

// Contacts that are images of those learnt: a network with features answers as before, one without does not.
TEST(FeaturesTrainingOnDevice, NetworksAnswerImagesAsTheyAnswerTheFrames) {
  nn::FrameSet set = bumps(400, 42, 7);
  set.columns = 21;
  TrainingPlan plan{.topologies = {nn::Topology::parse("42-21-1")}, .seeds = {1}, .scaling = by_frame};
  plan.batch = nn::BatchOptions{};
  plan.options.cycle_limit = 100;
  const nn::RowMatrix<float> mirrored = [&] {
    nn::RowMatrix<float> frames(400, 42);
    frames.leftCols(21) = set.frames.leftCols(21).rowwise().reverse();
    frames.rightCols(21) = -set.frames.rightCols(21).rowwise().reverse();
    return frames;
  }();
  for (const Features features : {Features::line, Features::frame}) {
    plan.features = features;
    NetworkTraining<float> training(executor(), set, plan);
    ASSERT_TRUE(training.run());
    const nn::Model model = training.model(0, "bumps", {});
    EXPECT_EQ(model.numbers(), 42);
    const nn::Recall<float> own = nn::recall(model.weights, model.scaling, set.frames);
    const nn::Recall<float> other = nn::recall(model.weights, model.scaling, mirrored);
    const float difference = (own.slip_index - other.slip_index).cwiseAbs().maxCoeff();
    const float error = (own.slip_index - set.slip_index).cwiseAbs().mean();
    EXPECT_LT(error, 0.2f) << nn::name(features);  // a constant errs by 0.25
    if (features == Features::line)
      EXPECT_LT(difference, 1e-6f);
    else
      EXPECT_GT(difference, 0.1f);
  }
}

}  // namespace features_test
