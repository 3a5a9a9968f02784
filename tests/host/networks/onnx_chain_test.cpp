// SPDX-License-Identifier: Apache-2.0

// Networks of other programs. The truth is the test's own runtime for ONNX graphs.
#include "host/networks/onnx_chain.h"

#include <gmock/gmock.h>

#include <cstring>
#include <fstream>
#include <random>

#include "host/support/errors.h"
#include "nn/forward.h"
#include "tests/host/networks/onnx_evaluator.h"
#include "tests/scratch.h"
#include "tests/thrown_message.h"

namespace {

using namespace tactel;
using namespace tactel::host;
using tactel::testing::OnnxEvaluator;
using ::testing::HasSubstr;

/// A graph that grows by one operation at a time, as exporters write it.
class Chain {
 public:
  explicit Chain(int inputs) : width_(inputs) {
    model_.set_ir_version(8);
    model_.mutable_graph()->add_input()->set_name("frame");
  }

  Chain& dense(int outputs) {
    const std::string weights = constant({outputs, width_}), bias = constant({outputs});
    onnx::NodeProto* node = add("Gemm", {value_, weights, bias});
    attribute(*node, "transB")->set_i(1);
    attribute(*node, "alpha")->set_f(1);
    width_ = outputs;
    return *this;
  }
  Chain& product(int outputs) {
    add("MatMul", {value_, constant({width_, outputs})});
    width_ = outputs;
    return *this;
  }
  Chain& by(const char* type, std::vector<std::int64_t> extents) {
    add(type, {value_, constant(std::move(extents))});
    return *this;
  }
  Chain& by(const char* type, float number, bool first = true) {
    const std::string name = constant({});
    tensors().rbegin()->clear_raw_data();
    tensors().rbegin()->add_float_data(number);
    add(type, first ? std::vector<std::string>{value_, name} : std::vector<std::string>{name, value_});
    return *this;
  }
  Chain& op(const char* type) {
    add(type, {value_});
    return *this;
  }
  Chain& leaky(float slope) {
    attribute(*add("LeakyRelu", {value_}), "alpha")->set_f(slope);
    return *this;
  }
  Chain& normalized() {
    std::vector<std::string> inputs{value_};
    for (int i = 0; i < 4; ++i) inputs.push_back(constant({width_}));
    std::string& variance = *tensors().rbegin()->mutable_raw_data();
    for (std::size_t at = 3; at < variance.size(); at += 4) variance[at] &= 0x7f;  // no variance is below 0
    attribute(*add("BatchNormalization", inputs), "epsilon")->set_f(0.01f);
    return *this;
  }
  Chain& cast(int type) {
    attribute(*add("Cast", {value_}), "to")->set_i(type);
    return *this;
  }
  Chain& flatten(int axis) {
    attribute(*add("Flatten", {value_}), "axis")->set_i(axis);
    return *this;
  }
  Chain& reshape(std::initializer_list<std::int64_t> extents) {
    const std::string name = constant({0});
    onnx::TensorProto& shape = *tensors().rbegin();
    shape.clear_raw_data(), shape.set_dims(0, static_cast<std::int64_t>(extents.size()));
    shape.set_data_type(onnx::TensorProto::INT64);
    for (const std::int64_t extent : extents) shape.add_int64_data(extent);
    add("Reshape", {value_, name});
    return *this;
  }
  onnx::ModelProto finished() {
    model_.mutable_graph()->add_output()->set_name(value_);
    return model_;
  }
  google::protobuf::RepeatedPtrField<onnx::TensorProto>& tensors() {
    return *model_.mutable_graph()->mutable_initializer();
  }

 private:
  onnx::NodeProto* add(const char* type, std::vector<std::string> inputs) {
    onnx::NodeProto* node = model_.mutable_graph()->add_node();
    node->set_op_type(type);
    for (const std::string& input : inputs) node->add_input(input);
    node->add_output(value_ = "value" + std::to_string(model_.graph().node_size()));
    return node;
  }
  static onnx::AttributeProto* attribute(onnx::NodeProto& node, const char* name) {
    onnx::AttributeProto* made = node.add_attribute();
    made->set_name(name);
    return made;
  }
  std::string constant(std::vector<std::int64_t> extents) {
    onnx::TensorProto* tensor = model_.mutable_graph()->add_initializer();
    tensor->set_name("constant" + std::to_string(model_.graph().initializer_size()));
    tensor->set_data_type(onnx::TensorProto::FLOAT);
    std::int64_t count = 1;
    for (const std::int64_t extent : extents) tensor->add_dims(extent), count *= extent;
    std::string raw;
    for (; count > 0; --count) {
      const float number = numbers_(generator_);
      raw.append(reinterpret_cast<const char*>(&number), sizeof number);
    }
    tensor->set_raw_data(raw);
    return tensor->name();
  }

  onnx::ModelProto model_;
  std::string value_ = "frame";
  int width_;
  std::mt19937 generator_{3};
  std::uniform_real_distribution<float> numbers_{-0.9f, 1.1f};
};

class OnnxChain : public ::testing::Test {
 protected:
  DenseChain read(const onnx::ModelProto& model) const {
    std::ofstream(folder_ / "own.onnx", std::ios::binary) << model.SerializeAsString();
    return read_onnx_chain(folder_ / "own.onnx");
  }
  std::string refusal(const onnx::ModelProto& model) const {
    return thrown_message<ConfigError>([&] {
      try {
        weights_of_chain(read(model));
      } catch (const ValueError& error) {
        throw ConfigError("own.onnx", error);
      }
    });
  }
  /// S of the graph, of its chain, and of tactel's neurons, on frames of either sign.
  void expect_the_same(const onnx::ModelProto& model) const {
    const DenseChain chain = read(model);
    const nn::Weights<float> weights = weights_of_chain(chain);
    const OnnxEvaluator graph(model);
    std::mt19937 generator(5);
    std::normal_distribution<float> stress(0, 0.7f);
    nn::RowMatrix<float> frames(200, weights.topology.inputs());
    for (float& number : frames.reshaped()) number = stress(generator);
    const nn::Vector<float> answers = nn::recall(weights, {}, frames).slip_index;
    double least = 1, most = 0;
    for (Eigen::Index i = 0; i < frames.rows(); ++i) {
      const nn::RowMatrix<double> frame = frames.row(i).cast<double>();
      const double truth = graph.run(frame)(0, 0);
      EXPECT_NEAR(evaluate(chain, frame.row(0).transpose()), truth, 1e-12);
      EXPECT_NEAR(answers[i], truth, 2e-6);  // fp32: 1e-7 for each of some ten sums
      least = std::min(least, truth), most = std::max(most, truth);
    }
    EXPECT_GT(most - least, 0.05);  // it says something
  }

  const ScratchFolder folder_;
};

TEST_F(OnnxChain, EveryActivation) {
  for (const char* activation : {"Sigmoid", "Tanh", "Relu"}) {
    SCOPED_TRACE(activation);
    expect_the_same(Chain(8).dense(7).op(activation).dense(5).op(activation).dense(1).op("Sigmoid").finished());
    expect_the_same(Chain(8).dense(7).op(activation).dense(1).op("Sigmoid").finished());
  }
  expect_the_same(Chain(8).dense(7).op("Sigmoid").dense(5).op("Tanh").dense(1).op("Sigmoid").finished());
}

// The slope of tactel's own rectifiers takes no second neuron.
TEST_F(OnnxChain, EverySlope) {
  for (const float slope : {0.01f, 0.3f, -0.2f})
    expect_the_same(Chain(8).dense(7).leaky(slope).dense(5).leaky(slope).dense(1).op("Sigmoid").finished());
  const auto widths = [&](float slope) {
    return weights_of_chain(read(Chain(8).dense(7).leaky(slope).dense(1).op("Sigmoid").finished())).topology.text();
  };
  EXPECT_EQ(widths(0.01f), "8-7-1_leaky-relu");
  EXPECT_EQ(widths(0.3f), "8-14-1_leaky-relu");
}

// Frames less their mean over their deviation, products without a bias, sums before and behind a layer, two layers
// without an activation between them, and 1/2 + 1/2 tanh at the end.
TEST_F(OnnxChain, ConstantsGoIntoTheLayers) {
  expect_the_same(Chain(6)
                      .by("Sub", {1, 6})
                      .by("Div", {1, 6})
                      .product(5)
                      .by("Add", {1, 5})
                      .op("Tanh")
                      .dense(1)
                      .op("Sigmoid")
                      .finished());
  expect_the_same(Chain(6).by("Div", 2).by("Sub", 0.1f, false).dense(5).op("Tanh").dense(1).op("Sigmoid").finished());
  expect_the_same(Chain(6).dense(4).op("Tanh").by("Mul", {1, 4}).dense(3).dense(1).op("Sigmoid").finished());
  expect_the_same(
      Chain(6).op("Flatten").dense(4).op("Tanh").dense(1).op("Tanh").by("Mul", 0.5f).by("Add", 0.5f).finished());
}

TEST_F(OnnxChain, NormalizationGoesIntoTheLayers) {
  expect_the_same(
      Chain(6).normalized().dense(5).normalized().op("Tanh").normalized().dense(1).op("Sigmoid").finished());
}

// scikit-learn's networks begin with a Cast and end with a Reshape. Neither changes a number.
TEST_F(OnnxChain, OperationsThatMoveNothingAreLeftOut) {
  const auto weights = [&](Chain chain) { return weights_of_chain(read(chain.finished())).values; };
  const auto plain = weights(Chain(4).dense(3).op("Tanh").dense(1).op("Sigmoid"));
  EXPECT_EQ(weights(Chain(4).cast(1).dense(3).op("Tanh").cast(11).dense(1).op("Sigmoid").reshape({-1, 1})), plain);
  EXPECT_EQ(weights(Chain(4).reshape({-1, 4}).dense(3).op("Tanh").reshape({0, 3}).dense(1).op("Sigmoid").reshape({-1})),
            plain);
  EXPECT_EQ(weights(Chain(4).flatten(1).dense(3).reshape({1, -1}).op("Tanh").dense(1).op("Sigmoid")), plain);
  const auto says = [&](Chain chain, const char* text) { EXPECT_THAT(refusal(chain.finished()), HasSubstr(text)); };
  says(Chain(4).cast(10).dense(3), "a Cast to float16");
  says(Chain(4).flatten(0).dense(3), "a Flatten along another axis");
  says(Chain(4).dense(3).reshape({-1, 1}), "a Reshape of a frame");
  says(Chain(4).dense(3).reshape({3, -1}), "a Reshape of a frame");
  says(Chain(4).reshape({-1}).dense(3), "a Reshape of a frame");
}

// Exporters that fold no constants leave operations between a weight and its layer.
TEST_F(OnnxChain, AWeightBehindOtherOperationsIsFolded) {
  const onnx::ModelProto plain = Chain(4).dense(3).op("Tanh").dense(1).op("Sigmoid").finished();
  const auto expected = weights_of_chain(read(plain)).values;
  const auto behind = [&](const char* type, const char* attribute, std::vector<std::int64_t> values, bool transposes) {
    onnx::ModelProto model = plain;
    onnx::GraphProto& graph = *model.mutable_graph();
    onnx::NodeProto& node = *graph.add_node();
    node.set_op_type(type);
    node.add_input("stored"), node.add_output(graph.initializer(0).name());
    graph.mutable_initializer(0)->set_name("stored");
    if (*attribute) node.add_attribute()->set_name(attribute);
    if (values.size() == 1) node.mutable_attribute(0)->set_i(values[0]);
    if (values.size() > 1)
      for (const std::int64_t value : values) node.mutable_attribute(0)->add_ints(value);
    for (int i = graph.node_size() - 1; i > 0; --i) graph.mutable_node()->SwapElements(i, i - 1);
    if (transposes) graph.mutable_node(1)->mutable_attribute(0)->set_i(0);  // transB
    EXPECT_EQ(weights_of_chain(read(model)).values, expected) << type;
  };
  behind("Identity", "", {}, false);
  behind("Cast", "to", {1}, false);
  behind("Transpose", "", {}, true);
  behind("Transpose", "perm", {1, 0}, true);
  behind("Transpose", "perm", {0, 1}, false);
}

TEST_F(OnnxChain, NumbersOfOtherTypes) {
  onnx::ModelProto model = Chain(4).dense(3).op("Tanh").dense(1).op("Sigmoid").finished();
  const auto expected = weights_of_chain(read(model)).values;
  onnx::TensorProto& tensor = *model.mutable_graph()->mutable_initializer(0);
  const std::string raw = tensor.raw_data();
  tensor.clear_raw_data();
  tensor.set_data_type(onnx::TensorProto::DOUBLE);
  for (std::size_t at = 0; at < raw.size(); at += 4) {
    float number = 0;
    std::memcpy(&number, raw.data() + at, 4);
    tensor.add_double_data(number);
  }
  EXPECT_EQ(weights_of_chain(read(model)).values, expected);
  tensor.clear_double_data();
  tensor.set_data_type(onnx::TensorProto::FLOAT16);
  tensor.set_raw_data(raw.substr(0, raw.size() / 2));
  EXPECT_THAT(refusal(model), HasSubstr("numbers of type float16 in \"constant1\": must be numbers of type float or"));
}

// A small file may name the same numbers, or a large file, many times.
TEST_F(OnnxChain, WorkAndMemoryHaveABound) {
  onnx::ModelProto copies = Chain(4).dense(3).op("Tanh").dense(1).op("Sigmoid").finished();
  std::ofstream(folder_ / "w.data", std::ios::binary).seekp((4 << 20) - 1).put(0);
  for (int i = 0; i < 2; ++i) {
    onnx::TensorProto& tensor = *copies.mutable_graph()->add_initializer();
    tensor.set_name("copy" + std::to_string(i));
    tensor.set_data_type(onnx::TensorProto::FLOAT);
    tensor.add_dims(1024), tensor.add_dims(1000);
    onnx::StringStringEntryProto* entry = tensor.add_external_data();
    entry->set_key("location"), entry->set_value("w.data");
  }
  EXPECT_THAT(refusal(copies), HasSubstr("constants of more than 1048576 numbers"));
  const auto repeated = [&](int width, int times) {
    onnx::ModelProto model = Chain(width).product(width).finished();
    onnx::GraphProto& graph = *model.mutable_graph();
    for (int i = 1; i < times; ++i) {
      onnx::NodeProto& node = *graph.add_node();
      node = graph.node(0);
      node.set_input(0, graph.node(i - 1).output(0)), node.set_output(0, "next" + std::to_string(i));
    }
    return refusal(model);
  };
  EXPECT_THAT(repeated(4, 1001), HasSubstr("more than 1000 operations"));
  EXPECT_THAT(repeated(400, 7), HasSubstr("products with more than 1048576 numbers"));
  EXPECT_THAT(refusal(Chain(2).product(1025).finished()), HasSubstr("a product with [2, 1025] numbers"));
}

// As PyTorch leaves them by default.
TEST_F(OnnxChain, NumbersInAFileBesideIt) {
  onnx::ModelProto model = Chain(4).dense(3).op("Tanh").dense(1).op("Sigmoid").finished();
  const nn::Weights<float> whole = weights_of_chain(read(model));
  onnx::TensorProto& tensor = *model.mutable_graph()->mutable_initializer(0);
  const auto place = [&](const std::string& location) {
    tensor.clear_external_data();
    for (const auto& [key, value] : std::initializer_list<std::pair<const char*, std::string>>{
             {"location", location}, {"offset", "8"}, {"length", "48"}}) {
      onnx::StringStringEntryProto* entry = tensor.add_external_data();
      entry->set_key(key), entry->set_value(value);
    }
  };
  std::ofstream(folder_ / "own.onnx.data", std::ios::binary) << "12345678" << tensor.raw_data();
  tensor.clear_raw_data();
  tensor.set_data_location(onnx::TensorProto::EXTERNAL);
  place("own.onnx.data");
  EXPECT_EQ(weights_of_chain(read(model)).values, whole.values);
  for (const char* elsewhere : {"../own.onnx.data", "/etc/passwd", "..", ""}) {
    place(elsewhere);
    EXPECT_THAT(refusal(model), HasSubstr("a network whose numbers lie in files beside it")) << elsewhere;
  }
  place("lost.data");
  EXPECT_THAT(refusal(model), HasSubstr("external_data=False"));
  place("own.onnx.data");
  std::filesystem::resize_file(folder_ / "own.onnx.data", 55);
  EXPECT_THAT(refusal(model), HasSubstr("truncated"));
}

TEST_F(OnnxChain, WhatIsNoSuchChainIsNamed) {
  const auto says = [&](Chain chain, const char* text) { EXPECT_THAT(refusal(chain.finished()), HasSubstr(text)); };
  says(Chain(4).dense(3).op("Softmax"), "the operation Softmax");
  says(Chain(4).dense(3).op("Tanh").dense(1), "an output without a sigmoid");
  says(Chain(4).dense(3).op("Tanh").dense(2).op("Sigmoid"), "one output through a sigmoid");
  says(Chain(4).dense(1).op("Sigmoid"), "1 dense layers");
  says(Chain(4).dense(3).op("Tanh").dense(3).op("Tanh").dense(3).op("Tanh").dense(1).op("Sigmoid"), "4 dense layers");
  says(Chain(4).dense(3).op("Relu").dense(3).op("Tanh").dense(1).op("Sigmoid"), "a rectifier beside another");
  says(Chain(4).dense(400).op("Tanh").dense(1).op("Sigmoid"), "4-400-1");
  says(Chain(4).op("Tanh").dense(1).op("Sigmoid"), "without a dense layer before it");
  says(Chain(4).dense(3).by("Add", {1, 2}).op("Tanh").dense(1).op("Sigmoid"), "a constant of another shape");
  says(Chain(4).dense(3).leaky(1).dense(1).op("Sigmoid"), "a slope of 1");
  onnx::ModelProto branches = Chain(4).dense(3).op("Tanh").dense(1).op("Sigmoid").finished();
  branches.mutable_graph()->mutable_node(2)->set_input(0, "value1");
  EXPECT_THAT(refusal(branches), HasSubstr("a graph with branches"));
  onnx::ModelProto foreign = Chain(4).dense(3).op("Tanh").dense(1).op("Sigmoid").finished();
  foreign.mutable_graph()->mutable_node(1)->set_domain("com.other");
  EXPECT_THAT(refusal(foreign), HasSubstr("the operation Tanh of com.other"));
  foreign.mutable_graph()->mutable_node(1)->set_domain("ai.onnx");
  EXPECT_EQ(refusal(foreign), "no error");
  onnx::ModelProto twice = Chain(4).dense(3).op("Tanh").dense(1).op("Sigmoid").finished();
  twice.mutable_graph()->mutable_initializer(3)->set_name("constant1");
  EXPECT_THAT(refusal(twice), HasSubstr("two values of the name \"constant1\""));
  twice = Chain(4).dense(3).op("Tanh").op("Identity").dense(1).op("Sigmoid").finished();
  twice.mutable_graph()->mutable_node(2)->set_output(0, "value2");
  twice.mutable_graph()->mutable_node(3)->set_input(0, "value2");
  EXPECT_THAT(refusal(twice), HasSubstr("two values of the name \"value2\""));
  onnx::ModelProto list = Chain(4).dense(3).op("Tanh").product(1).op("Sigmoid").finished();
  list.mutable_graph()->mutable_initializer(2)->mutable_dims()->RemoveLast();
  EXPECT_THAT(refusal(list), HasSubstr("a product with a list"));
  onnx::ModelProto infinite = Chain(4).dense(3).op("Tanh").dense(1).op("Sigmoid").finished();
  infinite.mutable_graph()->mutable_initializer(0)->mutable_raw_data()->replace(0, 4, "\0\0\x80\x7f", 4);
  EXPECT_THAT(refusal(infinite), HasSubstr("NaN or infinite"));
}

TEST_F(OnnxChain, BytesOfNoGraphAreRefused) {
  const std::string whole = Chain(4).dense(3).op("Tanh").dense(1).op("Sigmoid").finished().SerializeAsString();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    std::ofstream(folder_ / "cut.onnx", std::ios::binary) << whole.substr(0, size);
    EXPECT_THROW(weights_of_chain(read_onnx_chain(folder_ / "cut.onnx")), std::exception) << size;
  }
  EXPECT_THAT(thrown_message<ConfigError>([&] { read_onnx_chain(folder_ / "none.onnx"); }), HasSubstr("none.onnx"));
}

}  // namespace
