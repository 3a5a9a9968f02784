// SPDX-License-Identifier: Apache-2.0
#include "host/networks/onnx_graph.h"

#include <cstring>
#include <map>
#include <string>

#include "host/networks/onnx_bound.h"
#include "host/networks/onnx_builder.h"
#include "host/support/checksum.h"

namespace tactel::host {
namespace {

std::string weight_name(int layer) { return "weight" + std::to_string(layer + 1); }
std::string bias_name(int layer) { return "bias" + std::to_string(layer + 1); }

void describe_value(onnx::ValueInfoProto& value, const std::string& name, int width) {
  value.set_name(name);
  onnx::TypeProto::Tensor& type = *value.mutable_type()->mutable_tensor_type();
  type.set_elem_type(onnx::TensorProto::FLOAT);
  type.mutable_shape()->add_dim()->set_dim_param("batch");
  type.mutable_shape()->add_dim()->set_dim_value(width);
}

void add_set_scaling(OnnxBuilder& builder, const nn::InputScaling& scaling) {
  builder.scalar("factor", 1.0f / scaling.largest_stress);
  builder.node("Mul", {"frame", "factor"}, "scaled");
}

// Each input by the largest |normal stress| of its first `normals` numbers, the newest frame's; zeros where there is
// none.
void add_frame_scaling(OnnxBuilder& builder, int normals) {
  builder.integers("first_normal", {0});
  builder.integers("end_of_normal", {normals});
  builder.integers("along_frame", {1});
  builder.scalar("zero", 0.0f);
  builder.scalar("one", 1.0f);
  builder.scalar("smallest_stress", nn::InputScaling::smallest_stress);
  builder.node("Slice", {"frame", "first_normal", "end_of_normal", "along_frame"}, "normal");
  builder.node("Abs", {"normal"}, "normal_size");
  onnx::NodeProto& most = builder.node("ReduceMax", {"normal_size"}, "largest_normal");
  OnnxBuilder::axis(most, 1);
  OnnxBuilder::attribute(most, "keepdims", std::int64_t{1});
  builder.node("Less", {"largest_normal", "smallest_stress"}, "no_stress");
  builder.node("Where", {"no_stress", "one", "largest_normal"}, "divisor");
  builder.node("Div", {"frame", "divisor"}, "relative");
  builder.node("Where", {"no_stress", "zero", "relative"}, "scaled");
}

// f(z) = 1/2 tanh(z/2). The halving has a node of its own, because not every runtime heeds Gemm's alpha and beta
// (OpenCV 4.6 does not).
void add_logistic(OnnxBuilder& builder, const std::string& name) {
  builder.node("Mul", {"sum" + name, "half"}, "half_sum" + name);
  builder.node("Tanh", {"half_sum" + name}, "tanh" + name);
  builder.node("Mul", {"tanh" + name, "half"}, "output" + name);
}

static_assert(nn::leak == 0.01f, "the leak of LeakyRelu without an attribute");

void add_layer(OnnxBuilder& builder, const nn::Weights<float>& weights, int l, const std::string& input) {
  const std::string name = std::to_string(l + 1);
  const int in = weights.topology.fan_in(l), out = weights.topology.fan_out(l);
  const nn::RowMatrix<float> w = weights.layer(l).leftCols(in);
  const nn::Vector<float> b = weights.layer(l).col(in);
  builder.numbers(weight_name(l), {out, in}, w.data());
  builder.numbers(bias_name(l), {out}, b.data());
  onnx::NodeProto& gemm = builder.node("Gemm", {input, weight_name(l), bias_name(l)}, "sum" + name);
  OnnxBuilder::attribute(gemm, "transB", std::int64_t{1});
  if (weights.topology.activation(l) == nn::Activation::leaky_relu)
    builder.node("LeakyRelu", {"sum" + name}, "output" + name);
  else
    add_logistic(builder, name);
}

// Appends a text or number so that no other sequence of them gives the same bytes.
void append(std::string& all, std::string_view text) {
  const auto size = static_cast<std::uint64_t>(text.size());
  all.append(reinterpret_cast<const char*>(&size), sizeof size).append(text);
}
void append(std::string& all, std::int64_t number) {
  all.append(reinterpret_cast<const char*>(&number), sizeof number);
}

bool read_tensor(const onnx::GraphProto& graph, const std::string& name, std::size_t count, std::string& data) {
  for (const onnx::TensorProto& tensor : graph.initializer()) {
    if (tensor.name() != name) continue;
    data = tensor.raw_data();
    return tensor.data_type() == onnx::TensorProto::FLOAT && data.size() == count * sizeof(float);
  }
  return false;
}

}  // namespace

onnx::GraphProto onnx_graph(const nn::Model& model) {
  onnx::GraphProto graph;
  const nn::Topology& topology = model.weights.topology;
  graph.set_name("tactel_" + topology.text());
  describe_value(*graph.add_input(), "frame", topology.inputs());
  describe_value(*graph.add_output(), "slip_index", 1);
  if (topology.has_bound())
    for (const BoundOutput& output : bound_outputs) describe_value(*graph.add_output(), output.name, output.width);
  OnnxBuilder builder(graph);
  if (model.scaling.kind == nn::ScalingKind::set)
    add_set_scaling(builder, model.scaling);
  else
    add_frame_scaling(builder, topology.inputs() / (2 * model.scaling.history));
  builder.scalar("half", 0.5f);
  std::string last = "scaled";
  for (int l = 0; l < topology.layers(); ++l) {
    add_layer(builder, model.weights, l, last);
    last = "output" + std::to_string(l + 1);
  }
  if (topology.has_bound())
    add_bound(builder, model.bound.value(), last);
  else
    builder.node("Add", {last, "half"}, "slip_index");
  return graph;
}

bool read_weights(const onnx::GraphProto& graph, nn::Weights<float>& weights) {
  for (int l = 0; l < weights.topology.layers(); ++l) {
    const int in = weights.topology.fan_in(l), out = weights.topology.fan_out(l);
    std::string w, b;
    if (!read_tensor(graph, weight_name(l), static_cast<std::size_t>(in) * out, w) ||
        !read_tensor(graph, bias_name(l), out, b))
      return false;
    nn::RowMatrix<float> matrix(out, in);
    nn::Vector<float> bias(out);
    std::memcpy(matrix.data(), w.data(), w.size());
    std::memcpy(bias.data(), b.data(), b.size());
    weights.layer(l).leftCols(in) = matrix;
    weights.layer(l).col(in) = bias;
  }
  return true;
}

std::string onnx_checksum(const onnx::ModelProto& model) {
  std::string all;
  for (const onnx::TensorProto& tensor : model.graph().initializer()) {
    append(all, tensor.name());
    append(all, std::int64_t{tensor.data_type()});
    append(all, std::int64_t{tensor.dims_size()});
    for (const std::int64_t extent : tensor.dims()) append(all, extent);
    append(all, tensor.raw_data());
  }
  std::map<std::string_view, std::string_view> metadata;
  for (const onnx::StringStringEntryProto& entry : model.metadata_props()) metadata[entry.key()] = entry.value();
  metadata.erase(checksum_key);
  for (const auto& [key, value] : metadata) {
    append(all, key);
    append(all, value);
  }
  return checksum_text(all);
}

}  // namespace tactel::host
