// SPDX-License-Identifier: Apache-2.0

// tactel::infer beside the program's own networks: the files that the exporter writes, the S of its kernels, and broken
// files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <onnx/onnx_pb.h>
#include <sys/stat.h>
#include <tactel/infer.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <limits>

#include "host/networks/forward.h"
#include "host/networks/onnx_file.h"
#include "host/support/checksum.h"
#include "host/support/errors.h"
#include "nn/infer/network_file.h"
#include "tests/host/networks/bounded_model.h"
#include "tests/host/networks/crafted_network.h"
#include "tests/host/networks/network_cases.h"
#include "tests/host/support/run_tactel.h"

namespace infer_test {

using namespace tactel;
using nn::ScalingKind;
using tactel::tests::bumps;
using tactel::tests::executor;
using tactel::tests::metadata;
using tactel::tests::parsed;
using tactel::tests::sealed;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

nn::Model some_model(const char* topology, ScalingKind kind) {
  nn::Weights<float> weights = nn::initial_weights(nn::Topology::parse(topology), 7);
  for (float& w : weights.values) w *= 3;  // S well away from 0.5
  return {weights, {kind, 1.37f}, 7, 0.1, "set \"a\"", 100, {1234, 0.31, 0.0123, 0.02}};
}

SlipEstimator estimator_of(const std::string& bytes) { return SlipEstimator::parse(std::as_bytes(std::span(bytes))); }

std::string problem_of(const std::string& bytes) {
  try {
    estimator_of(bytes);
  } catch (const InputError& error) {
    EXPECT_EQ(error.place + ": " + error.problem + "; " + error.fix, error.what());
    return error.problem;
  }
  return "none";
}

/// Frames like those of a sensor, and hard ones.
nn::RowMatrix<float> some_frames(int inputs) {
  nn::RowMatrix<float> frames = bumps(150, inputs, 9).frames;
  constexpr float infinite = std::numeric_limits<float>::infinity();
  frames.row(3).setZero();
  frames.row(4) *= 1e4f;
  frames.row(5) *= 1e-9f;
  frames.row(6).head(inputs / 2).setZero();
  frames(7, inputs - 1) = std::numeric_limits<float>::quiet_NaN();
  frames(8, 0) = -infinite;
  frames.row(9).setConstant(3e38f);
  frames.row(10).setConstant(1e-13f);
  frames.row(11).setConstant(1e-39f);  // denormal
  frames.row(12).tail(inputs / 2).setConstant(-3e-39f);
  return frames;
}

std::uint32_t bits(float x) { return std::bit_cast<std::uint32_t>(x); }

const std::vector<const char*> topologies = {"1",
                                             "2",
                                             "3",
                                             "4",
                                             "5",
                                             "6",
                                             "42-42-21-1",
                                             "256-256-256-1",
                                             "2-1-1",
                                             "2-1-1-1",
                                             "16-33-1",
                                             "8-32-31-1",
                                             "42-96-96-1_leaky-relu",
                                             "8-33-1_leaky-relu"};

std::vector<Answer> answers_of(const SlipEstimator& estimator, const nn::RowMatrix<float>& frames) {
  std::vector<Answer> answers(static_cast<std::size_t>(frames.rows()));
  const std::span<const float> all(frames.data(), static_cast<std::size_t>(frames.size()));
  EXPECT_EQ(estimator.estimate(all, answers), answers.size());
  return answers;
}

// The kernels and the library fuse the same multiply-adds in the same order: equal bits, and equal statuses.
TEST(InferOnDevice, GivesTheBitsOfTheKernels) {
  for (const char* topology :
       {"1", "42-42-21-1", "8-32-31-1", "2-1-1", "8-33-31-1_leaky-relu"}) {  // each compiles a kernel
    for (const ScalingKind kind : {ScalingKind::set, ScalingKind::frame}) {
      const nn::Model model = some_model(topology, kind);
      const nn::RowMatrix<float> frames = some_frames(model.weights.topology.inputs());
      const auto kernel = host::Forward<float>(executor(), std::span(&model.weights, 1), model.scaling).recall(frames);
      const std::vector<Answer> answers = answers_of(estimator_of(infer::network_bytes(model)), frames);
      for (int row = 0; row < frames.rows(); ++row) {
        EXPECT_EQ(int(answers[row].status), int(kernel.status[row])) << topology << " row " << row;
        if (std::isnan(kernel.slip_index(row)))
          EXPECT_TRUE(std::isnan(answers[row].slip_index)) << topology << " row " << row;
        else
          EXPECT_EQ(bits(answers[row].slip_index), bits(kernel.slip_index(row)))
              << topology << ' ' << nn::name(kind) << " row " << row << ": " << answers[row].slip_index << " and "
              << kernel.slip_index(row);
      }
    }
  }
}

// Frames are evaluated four together, the last ones with empty places: any batch gives each frame the bits that it has
// alone.
TEST(Infer, AnswersDoNotDependOnTheBatch) {
  for (const char* topology : {"42-42-21-1", "8-33-31-1_leaky-relu", "42-42-21-3"}) {
    const bool bound = std::string_view(topology).ends_with("-3");
    const nn::Model model = bound ? tactel::tests::bounded_model(topology, ScalingKind::frame, true)
                                  : some_model(topology, ScalingKind::frame);
    const SlipEstimator estimator = estimator_of(infer::network_bytes(model));
    const nn::RowMatrix<float> frames = some_frames(model.weights.topology.inputs());
    for (int rows = 1; rows <= 14; ++rows) {
      const std::vector<Answer> together = answers_of(estimator, frames.topRows(rows));
      for (int row = 0; row < rows; ++row) {
        const Answer alone = estimator.estimate({frames.row(row).data(), estimator.inputs()});
        using Bytes = std::array<std::byte, sizeof alone>;  // no padding: numbers of four bytes
        EXPECT_EQ(std::bit_cast<Bytes>(alone), std::bit_cast<Bytes>(together[static_cast<std::size_t>(row)]))
            << topology << ", row " << row << " of " << rows;
      }
    }
  }
}

// S, the bound and the interval have the bits of the kernel, at a processor's lanes and at a GPU's; the distance, too,
// for both add products in one order without fusing.
TEST(InferOnDevice, GivesTheBoundOfTheProgram) {
  for (const char* topology : {"42-42-21-3", "8-32-3", "8-33-3_leaky-relu"}) {
    for (const ScalingKind kind : {ScalingKind::set, ScalingKind::frame}) {
      const bool by_distance = std::string_view(topology) != "8-32-3";
      const nn::Model model = tactel::tests::bounded_model(topology, kind, by_distance);
      const nn::RowMatrix<float> frames = some_frames(model.weights.topology.inputs());
      const std::vector<Answer> answers = answers_of(estimator_of(infer::network_bytes(model)), frames);
      for (const int lanes : {executor().device().info().lanes_fp32, 1}) {
        if (lanes == 1 && by_distance) continue;  // each compiles a kernel
        host::Executor some{executor().device().with_lanes(lanes), {.threads = 1}};
        const nn::Bound* const bound = &*model.bound;
        const auto kernel =
            host::Forward<float>(some, std::span(&model.weights, 1), model.scaling, std::span(&bound, 1))
                .recall(frames);
        int unlike = 0, below_one = 0;
        for (std::size_t row = 0; row < answers.size(); ++row) {
          const Answer& answer = answers[row];
          const auto i = static_cast<Eigen::Index>(row);
          EXPECT_EQ(int(answer.status), int(kernel.status[row])) << row;
          EXPECT_EQ(answer.unlike != 0, kernel.bounds[row].unlike) << row;
          const bool none = std::isnan(kernel.slip_index(i));
          EXPECT_EQ(std::isnan(answer.slip_upper), none) << row;
          EXPECT_EQ(std::isnan(kernel.bounds[row].upper), none) << row;
          unlike += answer.unlike != 0;
          if (none) continue;
          EXPECT_EQ(bits(answer.slip_index), bits(kernel.slip_index(i))) << row;
          EXPECT_EQ(bits(answer.slip_upper), bits(kernel.bounds[row].upper)) << row;
          EXPECT_EQ(bits(answer.slip_interval[0]), bits(kernel.bounds[row].interval[0])) << row;
          EXPECT_EQ(bits(answer.slip_interval[1]), bits(kernel.bounds[row].interval[1])) << row;
          EXPECT_GE(answer.slip_upper, answer.slip_index) << row;
          below_one += answer.slip_upper < 1;
        }
        EXPECT_GT(unlike, 0);
        EXPECT_LT(unlike, 150);
        EXPECT_GT(below_one, 50);
      }
    }
  }
}

TEST(Infer, HasNoBoundOfAPlainNetwork) {
  const Answer answer =
      answers_of(estimator_of(infer::network_bytes(some_model("2-1-1", ScalingKind::set))), bumps(1, 2, 3).frames)
          .front();
  EXPECT_TRUE(std::isnan(answer.slip_upper) && std::isnan(answer.slip_interval[0]));
  EXPECT_EQ(answer.unlike, 0u);
}

// The reference twin adds in another order. A sum of n products is off by n eps of their sizes, which weights below 1.5
// and inputs below 1 limit; the activation's slope of 1/4 and the next layer's weights carry it on. 2e-5 covers 256
// inputs; S spans 0 to 1.
TEST(Infer, GivesTheSOfTheReference) {
  for (const char* topology : topologies) {
    for (const ScalingKind kind : {ScalingKind::set, ScalingKind::frame}) {
      const nn::Model model = some_model(topology, kind);
      const nn::RowMatrix<float> frames = some_frames(model.weights.topology.inputs());
      const auto twin = nn::recall(model.weights, model.scaling, frames);
      const std::vector<Answer> answers = answers_of(estimator_of(infer::network_bytes(model)), frames);
      float lowest = 1, highest = 0;
      for (int row = 0; row < frames.rows(); ++row) {
        if (row == 4 || row == 9) continue;  // sums of 1e4 and more
        EXPECT_EQ(int(answers[row].status), int(twin.status[row])) << topology << " row " << row;
        if (std::isnan(twin.slip_index(row))) continue;
        EXPECT_NEAR(answers[row].slip_index, twin.slip_index(row), 2e-5) << topology << " row " << row;
        lowest = std::min(lowest, answers[row].slip_index);
        highest = std::max(highest, answers[row].slip_index);
      }
      EXPECT_GT(highest - lowest, 0.001f) << topology;  // they do read the frames
    }
  }
}

// 2-1-1 by hand: weights 1, 2, bias 0.5, then 4 and -1; scaling 1/2. Frame (0.5, -0.25): z = 0.25 - 0.25 + 0.5 = 0.5,
// o = tanh(0.25)/2 = 0.1224593, z = -0.5101627, S = tanh(-0.2550814)/2 + 0.5 = 0.3751549.
TEST(Infer, WorksByHand) {
  nn::Model model = some_model("2-1-1", ScalingKind::set);
  model.scaling.largest_stress = 2;
  model.weights.values = {1, 2, 0.5f, 4, -1};
  const SlipEstimator estimator = estimator_of(infer::network_bytes(model));
  const std::vector<float> frame = {0.5f, -0.25f};
  const Answer answer = estimator.estimate(frame);
  const double o = std::tanh(0.25) / 2;
  EXPECT_NEAR(answer.slip_index, std::tanh((4 * o - 1) / 2) / 2 + 0.5, 1e-6);
  EXPECT_EQ(answer.status, AnswerStatus::ok);
  EXPECT_TRUE(std::isnan(answer.slip_upper));
}

nn::Model model_with_history(ScalingKind kind) {
  nn::Model model = some_model("24-9-1", kind);
  model.history = {.frames = 3, .stride = 2, .change = 0.07};
  model.scaling.history = 3;
  return model;
}

// Frames one after the other give the bits of the kernel on inputs that with_history forms from the same path.
TEST(InferOnDevice, GivesTheBitsOfTheKernelsWithHistory) {
  nn::FrameSet path = bumps(60, 8, 4);
  for (int row = 0; row < 60; ++row)
    path.frames.row(row) = path.frames.row(row / 20 * 20) * (0.2f + 0.05f * static_cast<float>(row % 20));
  path.frames.row(30).setZero();  // released: the frames before are forgotten
  path.contact.assign(60, 0), path.press_rows = true;
  for (int row = 0; row < 60; ++row) path.step.push_back(row);
  for (const ScalingKind kind : {ScalingKind::set, ScalingKind::frame}) {
    const nn::Model model = model_with_history(kind);
    const nn::RowMatrix<float> inputs = nn::with_history(path, model.history).frames;
    EXPECT_NE(inputs.rightCols(8).cwiseAbs().maxCoeff(), 0);
    const auto kernel = host::Forward<float>(executor(), std::span(&model.weights, 1), model.scaling).recall(inputs);
    const auto twin = nn::recall(model.weights, model.scaling, inputs);
    const SlipEstimator estimator = estimator_of(infer::network_bytes(model));
    EXPECT_EQ(estimator.frames(), 3u);
    SlipHistory history(estimator);
    EXPECT_EQ(history.inputs(), 8u);
    for (int row = 0; row < 60; ++row) {
      const Answer answer = history.estimate({path.frames.row(row).data(), 8});
      EXPECT_EQ(bits(answer.slip_index), bits(kernel.slip_index(row))) << nn::name(kind) << " row " << row;
      EXPECT_EQ(int(answer.status), int(kernel.status[row]));
      EXPECT_NEAR(answer.slip_index, twin.slip_index(row), 2e-6);  // 24 products: as GivesTheSOfTheReference
    }
    EXPECT_EQ(history.estimate({path.frames.row(0).data(), 6}).status, AnswerStatus::wrong_size);
    history.clear();
    const Answer first = history.estimate({path.frames.row(0).data(), 8});
    EXPECT_EQ(bits(first.slip_index), bits(kernel.slip_index(0)));
  }
}

TEST(Infer, OneFrameHasNoHistory) {
  const nn::Model model = some_model("8-32-31-1", ScalingKind::frame);
  const SlipEstimator estimator = estimator_of(infer::network_bytes(model));
  EXPECT_EQ(estimator.frames(), 1u);
  EXPECT_EQ(estimator.metadata("history"), "");
  SlipHistory history(estimator);
  const nn::RowMatrix<float> frames = bumps(5, 8, 2).frames;
  for (int row = 0; row < 5; ++row)
    EXPECT_EQ(bits(history.estimate({frames.row(row).data(), 8}).slip_index),
              bits(estimator.estimate({frames.row(row).data(), 8}).slip_index));
}

// Crafted graphs of leaky rectifiers, with a checksum that fits: both readers refuse.
TEST(Infer, RefusesCraftedRectifiers) {
  using Change = std::function<void(onnx::ModelProto&, onnx::NodeProto & rectifier)>;
  const auto topology = [](const char* text) -> Change {
    return [text](onnx::ModelProto& proto, onnx::NodeProto&) { metadata(proto, "topology") = text; };
  };
  const std::vector<std::pair<const char*, Change>> all = {
      {"none", [](auto&, auto&) {}},
      {"another operator", [](auto&, auto& node) { node.set_op_type("Relu"); }},
      {"another leak",
       [](auto&, auto& node) {
         onnx::AttributeProto& alpha = *node.add_attribute();
         alpha.set_name("alpha"), alpha.set_type(onnx::AttributeProto::FLOAT), alpha.set_f(-1e30f);
       }},
      {"of itself", [](auto&, auto& node) { node.set_input(0, node.output(0)); }},
      {"of nothing", [](auto&, auto& node) { node.clear_input(); }},
      {"of two", [](auto&, auto& node) { node.add_input("half"); }},
      {"of another domain", [](auto&, auto& node) { node.set_domain("elsewhere"); }},
      {"logistic", topology("16-16-8-1")},
      {"unknown", topology("16-16-8-1_relu")},
      {"twice", topology("16-16-8-1_leaky-relu_leaky-relu")},
      {"without layers", topology("_leaky-relu")}};
  const host::ScratchFolder folder;
  for (const auto& [what, change] : all) {
    onnx::ModelProto proto = parsed(some_model("16-16-8-1_leaky-relu", ScalingKind::frame));
    for (onnx::NodeProto& node : *proto.mutable_graph()->mutable_node())
      if (node.output(0) == "output1") change(proto, node);
    const std::string bytes = sealed(proto), file = folder.write("crafted.onnx", bytes);
    if (what == std::string("none")) {
      EXPECT_EQ(problem_of(bytes), "none");
      EXPECT_EQ(host::read_onnx(file).weights.topology.text(), "16-16-8-1_leaky-relu");
    } else {
      EXPECT_NE(problem_of(bytes), "none") << what;
      EXPECT_THROW(host::read_onnx(file), ConfigError) << what;
    }
  }
}

TEST(Infer, AnswersFramesOfAnotherSizeByAStatus) {
  const SlipEstimator estimator = estimator_of(infer::network_bytes(some_model("4-3-1", ScalingKind::set)));
  const std::vector<float> frames(13, 0.1f);
  const Answer answer = estimator.estimate(std::span(frames).first(3));
  EXPECT_EQ(answer.status, AnswerStatus::wrong_size);
  EXPECT_TRUE(std::isnan(answer.slip_index));
  EXPECT_EQ(estimator.estimate({}).status, AnswerStatus::wrong_size);
  std::vector<Answer> answers(3);
  EXPECT_EQ(estimator.estimate(frames, answers), 0u);
  EXPECT_EQ(estimator.estimate(std::span(frames).first(12), answers), 3u);
  EXPECT_STREQ(name(AnswerStatus::wrong_size), "wrong size");
}

TEST(Infer, ReadsWhatTheFileSays) {
  const SlipEstimator estimator = estimator_of(infer::network_bytes(some_model("16-33-1", ScalingKind::frame)));
  SlipEstimator copy = estimator_of(infer::network_bytes(some_model("4-3-1", ScalingKind::set)));
  EXPECT_EQ(copy.inputs(), 4u);
  copy = estimator;
  EXPECT_EQ(copy.inputs(), 16u);
  EXPECT_EQ(copy.topology(), "16-33-1");
  EXPECT_EQ(copy.metadata("learning_set"), "set \"a\"");
  EXPECT_EQ(copy.metadata("error_mean"), "0.0123");
  EXPECT_EQ(copy.metadata("no such key"), "");
}

TEST(Infer, RefusesEveryTruncatedFile) {
  for (const ScalingKind kind : {ScalingKind::set, ScalingKind::frame}) {
    const std::string good = infer::network_bytes(some_model("4-3-2-1", kind));
    EXPECT_EQ(problem_of(good), "none");
    for (std::size_t size = 0; size < good.size(); ++size)
      EXPECT_NE(problem_of(good.substr(0, size)), "none") << "first " << size << " bytes";
  }
}

// A changed bit is found, or changes nothing that S depends on: texts that describe the file.
TEST(Infer, NoticesChangedBits) {
  const nn::Model model = some_model("2-1-1", ScalingKind::frame);
  const std::string good = infer::network_bytes(model);
  const std::vector<float> frame = {-0.3f, 0.1f};
  const Answer answer = estimator_of(good).estimate(frame);
  std::size_t accepted = 0;
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    std::string bad = good;
    bad[bit / 8] = static_cast<char>(bad[bit / 8] ^ (1 << bit % 8));
    try {
      EXPECT_EQ(bits(estimator_of(bad).estimate(frame).slip_index), bits(answer.slip_index)) << "bit " << bit;
      ++accepted;
    } catch (const InputError&) {
    }
  }
  EXPECT_LT(accepted, 8 * good.size() / 2);
}

TEST(Infer, SaysWhatIsWrongWithAFile) {
  EXPECT_EQ(problem_of(""), "empty");
  EXPECT_THAT(problem_of("[sensor]\nlength = 20.0\n"), HasSubstr("no"));
  EXPECT_THAT(problem_of(std::string(5 << 20, '\0')), HasSubstr("4 MiB"));
  const auto changed = [](const auto& change) {
    onnx::ModelProto proto = parsed(some_model("4-3-1", ScalingKind::frame));
    change(proto);
    return problem_of(sealed(proto));
  };
  EXPECT_EQ(changed([](auto&) {}), "none");
  EXPECT_THAT(changed([](auto& m) { m.set_producer_name("pytorch"); }), HasSubstr("a model by \"pytorch\""));
  EXPECT_THAT(changed([](auto& m) { m.mutable_opset_import(0)->set_version(9); }), HasSubstr("form"));
  EXPECT_THAT(changed([](auto& m) { m.mutable_graph()->mutable_node(1)->set_op_type("Neg"); }), HasSubstr("form"));
  EXPECT_THAT(changed([](auto& m) { m.mutable_graph()->mutable_node(0)->set_domain("other"); }), HasSubstr("form"));
  EXPECT_THAT(changed([](auto& m) { m.mutable_graph()->mutable_initializer()->RemoveLast(); }), HasSubstr("bias2"));
  EXPECT_THAT(changed([](auto& m) { m.mutable_graph()->add_initializer()->set_name("more"); }), HasSubstr("form"));
  EXPECT_THAT(changed([](auto& m) { m.mutable_graph()->mutable_input()->Clear(); }), HasSubstr("form"));
  EXPECT_THAT(changed([](auto& m) {
                auto& tensor = *m.mutable_graph()->mutable_initializer(m.graph().initializer_size() - 1);
                tactel::tests::begin_with(tensor, std::numeric_limits<float>::infinity());
              }),
              HasSubstr("NaN or infinite"));
}

TEST(Infer, NamesTheFileThatCannotBeRead) {
  const host::ScratchFolder folder;
  const auto message = [](const fs::path& path) -> std::string {
    try {
      SlipEstimator::load(path);
    } catch (const InputError& error) {
      EXPECT_EQ(error.place, path.string());
      return error.what();
    }
    return "none";
  };
  EXPECT_THAT(message(folder / "none.onnx"), HasSubstr("No such file"));
  EXPECT_THAT(message(folder / "."), HasSubstr("no regular file"));
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(message(folder / "pipe"), HasSubstr("no regular file"));
  host::write_onnx(folder / "good.onnx", some_model("4-3-1", ScalingKind::set));
  EXPECT_EQ(message(folder / "good.onnx"), "none");
}

}  // namespace infer_test
