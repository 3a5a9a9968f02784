// SPDX-License-Identifier: Apache-2.0
#include "host/networks/onnx_bound.h"

#include <algorithm>
#include <cstring>

namespace tactel::host {
namespace {

std::int64_t size_of(const std::vector<float>& list) { return static_cast<std::int64_t>(list.size()); }

/// Column `which` of [batch, 3].
void add_column(OnnxBuilder& builder, const std::string& from, int which, const std::string& name) {
  builder.node("Slice", {from, "column" + std::to_string(which), "column" + std::to_string(which + 1), "along_outputs"},
               name);
}

/// Counts the elements of [batch, n] above `limit`: [batch, 1].
void add_count(OnnxBuilder& builder, const std::string& values, const std::string& limit, const std::string& name) {
  builder.node("Greater", {values, limit}, name + "_above");
  OnnxBuilder::attribute(builder.node("Cast", {name + "_above"}, name + "_counted"), "to", onnx::TensorProto::FLOAT);
  OnnxBuilder::attribute(builder.node("ReduceSum", {name + "_counted", "along_outputs"}, name), "keepdims", 1);
}

/// Class of a feature [batch, 1]: the number of edges below it.
void add_class(OnnxBuilder& builder, const std::string& feature, const std::vector<float>& edges) {
  builder.numbers(feature + "_edges", {size_of(edges)}, edges.data());
  add_count(builder, feature, feature + "_edges", feature + "_class");
}

void add_quantiles(OnnxBuilder& builder, const std::string& last) {
  for (int k = 0; k <= nn::Topology::heads; ++k) builder.integers("column" + std::to_string(k), {k});
  builder.integers("along_outputs", {1});
  builder.node("Add", {last, "half"}, "heads");
  add_column(builder, "heads", 0, "slip_index");
  add_column(builder, "heads", 1, "width_above");
  add_column(builder, "heads", 2, "width_below");
  builder.node("Add", {"slip_index", "width_above"}, "upper_quantile");
  builder.node("Sub", {"slip_index", "width_below"}, "lower_quantile");
  builder.node("Sub", {"upper_quantile", "lower_quantile"}, "width");
}

void add_touching(OnnxBuilder& builder, int tactels) {
  builder.integers("tactels", {tactels});
  builder.scalar("touching_share", nn::Bound::touching_share);
  builder.node("Slice", {"scaled", "column0", "tactels", "along_outputs"}, "scaled_normal");
  builder.node("Abs", {"scaled_normal"}, "scaled_normal_size");
  onnx::NodeProto& most = builder.node("ReduceMax", {"scaled_normal_size"}, "scaled_largest");
  OnnxBuilder::axis(most, 1);
  OnnxBuilder::attribute(most, "keepdims", 1);
  builder.node("Mul", {"scaled_largest", "touching_share"}, "touching_least");
  add_count(builder, "scaled_normal_size", "touching_least", "touching");
}

/// |(scaled - centre) * whitening|^2.
void add_distance(OnnxBuilder& builder) {
  builder.node("Sub", {"scaled", "centre"}, "centred");
  builder.node("MatMul", {"centred", "whitening"}, "white");
  builder.node("Mul", {"white", "white"}, "white_squares");
  OnnxBuilder::attribute(builder.node("ReduceSum", {"white_squares", "along_outputs"}, "distance"), "keepdims", 1);
}

/// (touching class * classes of S + class of S) * classes of the width + class of the width, times the classes of the
/// distance + its class where the bound has such, as an integer.
void add_classes(OnnxBuilder& builder, const nn::Bound& bound) {
  add_class(builder, "touching", bound.touching);
  add_class(builder, "slip_index", bound.slip_index);
  add_class(builder, "width", bound.width);
  builder.scalar("slip_index_classes", static_cast<float>(bound.slip_index.size() + 1));
  builder.scalar("width_classes", static_cast<float>(bound.width.size() + 1));
  builder.node("Mul", {"touching_class", "slip_index_classes"}, "class1");
  builder.node("Add", {"class1", "slip_index_class"}, "class2");
  builder.node("Mul", {"class2", "width_classes"}, "class3");
  builder.node("Add", {"class3", "width_class"}, "class4");
  if (!bound.distance.empty()) {
    add_class(builder, "distance", bound.distance);
    builder.scalar("distance_classes", static_cast<float>(bound.distance.size() + 1));
    builder.node("Mul", {"class4", "distance_classes"}, "class5");
    builder.node("Add", {"class5", "distance_class"}, "class6");
  }
  const std::string last = bound.distance.empty() ? "class4" : "class6";
  OnnxBuilder::attribute(builder.node("Cast", {last}, "class"), "to", onnx::TensorProto::INT64);
}

/// The upper end of a bound: the upper quantile and a correction, at least S, at most 1.
void add_upper_end(OnnxBuilder& builder, const std::string& correction, const std::string& name) {
  builder.node("Add", {"upper_quantile", correction}, name + "_sum");
  builder.node("Max", {name + "_sum", "slip_index"}, name + "_above");
  builder.node("Min", {name + "_above", "largest_slip_index"}, name);
}

void add_corrected(OnnxBuilder& builder, const nn::Bound& bound) {
  builder.scalar("largest_slip_index", 1.0f);
  builder.scalar("least_slip_index", -1.0f);
  const auto gather = [&builder](const std::string& name, const std::vector<float>& table) {
    builder.numbers(name + "_corrections", {size_of(table)}, table.data());
    OnnxBuilder::attribute(builder.node("Gather", {name + "_corrections", "class"}, name + "_correction"), "axis", 0);
  };
  gather("upper", bound.upper_correction);
  gather("interval", bound.interval_correction);
  add_upper_end(builder, "upper_correction", "slip_upper");
  add_upper_end(builder, "interval_correction", "interval_upper");
  builder.node("Sub", {"lower_quantile", "interval_correction"}, "interval_lower_sum");
  builder.node("Min", {"interval_lower_sum", "slip_index"}, "interval_lower_below");
  builder.node("Max", {"interval_lower_below", "least_slip_index"}, "interval_lower");
  OnnxBuilder::attribute(builder.node("Concat", {"interval_lower", "interval_upper"}, "slip_interval"), "axis", 1);
}

void add_unlike(OnnxBuilder& builder, const nn::Bound& bound) {
  const std::int64_t inputs = bound.centre.size();
  builder.numbers("centre", {inputs}, bound.centre.data());
  builder.numbers("whitening", {inputs, inputs}, bound.whitening.data());
  builder.scalar("unlike_above", bound.unlike_above);
  if (bound.distance.empty()) add_distance(builder);
  builder.node("LessOrEqual", {"distance", "unlike_above"}, "within");
  builder.node("Not", {"within"}, "beyond");  // true also for a distance that is NaN
  OnnxBuilder::attribute(builder.node("Cast", {"beyond"}, "unlike"), "to", onnx::TensorProto::FLOAT);
}

const onnx::TensorProto* tensor_of(const onnx::GraphProto& graph, const std::string& name) {
  for (const onnx::TensorProto& tensor : graph.initializer())
    if (tensor.name() == name) return tensor.data_type() == onnx::TensorProto::FLOAT ? &tensor : nullptr;
  return nullptr;
}

bool read_integer(const onnx::GraphProto& graph, const std::string& name, int& to) {
  for (const onnx::TensorProto& tensor : graph.initializer()) {
    if (tensor.name() != name) continue;
    std::int64_t number = 0;
    if (tensor.data_type() != onnx::TensorProto::INT64 || tensor.raw_data().size() != sizeof number) return false;
    std::memcpy(&number, tensor.raw_data().data(), sizeof number);
    to = static_cast<int>(std::clamp<std::int64_t>(number, 0, nn::Topology::widest_layer));
    return true;
  }
  return false;
}

bool read_numbers(const onnx::GraphProto& graph, const std::string& name, std::size_t count, float* to) {
  const onnx::TensorProto* tensor = tensor_of(graph, name);
  if (tensor == nullptr || tensor->raw_data().size() != count * sizeof(float)) return false;
  std::memcpy(to, tensor->raw_data().data(), tensor->raw_data().size());
  return true;
}

bool read_edges(const onnx::GraphProto& graph, const std::string& name, std::vector<float>& edges) {
  const onnx::TensorProto* tensor = tensor_of(graph, name);
  if (tensor == nullptr || tensor->raw_data().size() % sizeof(float) != 0 ||
      tensor->raw_data().size() > nn::Bound::most_edges * sizeof(float))
    return false;
  edges.resize(tensor->raw_data().size() / sizeof(float));
  return read_numbers(graph, name, edges.size(), edges.data());
}

}  // namespace

void add_bound(OnnxBuilder& builder, const nn::Bound& bound, const std::string& last) {
  add_quantiles(builder, last);
  add_touching(builder, bound.tactels);
  if (!bound.distance.empty()) add_distance(builder);  // before its class
  add_classes(builder, bound);
  add_corrected(builder, bound);
  add_unlike(builder, bound);
}

bool read_bound(const onnx::GraphProto& graph, int inputs, nn::Bound& bound) {
  if (!read_edges(graph, "touching_edges", bound.touching) ||
      !read_edges(graph, "slip_index_edges", bound.slip_index) || !read_edges(graph, "width_edges", bound.width))
    return false;
  const bool by_distance =
      std::ranges::any_of(graph.initializer(), [](const auto& t) { return t.name() == "distance_edges"; });
  if (by_distance && !read_edges(graph, "distance_edges", bound.distance)) return false;
  bound.upper_correction.resize(bound.classes());
  bound.interval_correction.resize(bound.classes());
  bound.centre.resize(inputs);
  bound.whitening.resize(inputs, inputs);
  return read_numbers(graph, "upper_corrections", bound.classes(), bound.upper_correction.data()) &&
         read_numbers(graph, "interval_corrections", bound.classes(), bound.interval_correction.data()) &&
         read_numbers(graph, "centre", static_cast<std::size_t>(inputs), bound.centre.data()) &&
         read_numbers(graph, "whitening", static_cast<std::size_t>(inputs) * inputs, bound.whitening.data()) &&
         read_numbers(graph, "unlike_above", 1, &bound.unlike_above) && read_integer(graph, "tactels", bound.tactels);
}

}  // namespace tactel::host
