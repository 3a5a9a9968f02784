// SPDX-License-Identifier: Apache-2.0
#include "nn/infer/network_graph.h"

#include <bit>
#include <utility>

namespace tactel::infer {
namespace {

static_assert(std::endian::native == std::endian::little, "ONNX keeps raw data little-endian");

using std::string;

/// Adds the parts of a graph one by one.
class Builder {
 public:
  explicit Builder(Graph& graph) : graph_(graph) {}

  void node(const char* type, std::vector<string> inputs, const string& output,
            std::vector<Attribute> attributes = {}) {
    graph_.nodes.push_back({type, std::move(inputs), output, std::move(attributes)});
  }
  void numbers(const string& name, std::vector<std::int64_t> dims, const std::vector<float>& values) {
    tensor(name, TensorType::floats, std::move(dims), values);
  }
  void numbers(const string& name, const std::vector<float>& list) {
    numbers(name, {static_cast<std::int64_t>(list.size())}, list);
  }
  void scalar(const string& name, float value) { numbers(name, {}, {value}); }
  void integer(const string& name, std::int64_t value) {
    tensor(name, TensorType::integers, {1}, std::vector<std::int64_t>{value});
  }

 private:
  template <class Number>
  void tensor(const string& name, TensorType type, std::vector<std::int64_t> dims, const std::vector<Number>& values) {
    graph_.tensors.push_back({name, type, std::move(dims),
                              string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number))});
  }

  Graph& graph_;
};

const std::vector<Attribute> largest_of_row{{"axes", 1, true}, {"keepdims", 1}}, sum_of_row{{"keepdims", 1}},
    to_float{{"to", 1}}, to_integer{{"to", 7}};

void add_set_scaling(Builder& graph, const nn::InputScaling& scaling) {
  graph.scalar("factor", 1.0f / scaling.largest_stress);
  graph.node("Mul", {"frame", "factor"}, "scaled");
}

/// Each input by the largest |normal stress| of its first `normals` numbers, the newest frame's; zeros where there is
/// none.
void add_frame_scaling(Builder& graph, int normals) {
  graph.integer("first_normal", 0);
  graph.integer("end_of_normal", normals);
  graph.integer("along_frame", 1);
  graph.scalar("zero", 0.0f);
  graph.scalar("one", 1.0f);
  graph.scalar("smallest_stress", nn::InputScaling::smallest_stress);
  graph.node("Slice", {"frame", "first_normal", "end_of_normal", "along_frame"}, "normal");
  graph.node("Abs", {"normal"}, "normal_size");
  graph.node("ReduceMax", {"normal_size"}, "largest_normal", largest_of_row);
  graph.node("Less", {"largest_normal", "smallest_stress"}, "no_stress");
  graph.node("Where", {"no_stress", "one", "largest_normal"}, "divisor");
  graph.node("Div", {"frame", "divisor"}, "relative");
  graph.node("Where", {"no_stress", "zero", "relative"}, "scaled");
}

/// f(z) = 1/2 tanh(z/2). The halving has a node of its own, because not every runtime heeds Gemm's alpha and beta
/// (OpenCV 4.6 does not).
void add_logistic(Builder& graph, const string& layer) {
  graph.node("Mul", {"sum" + layer, "half"}, "half_sum" + layer);
  graph.node("Tanh", {"half_sum" + layer}, "tanh" + layer);
  graph.node("Mul", {"tanh" + layer, "half"}, "output" + layer);
}

static_assert(nn::leak == 0.01f, "the leak of LeakyRelu without an attribute");

void add_layer(Builder& graph, const nn::Weights<float>& weights, int l, const string& input) {
  const string layer = std::to_string(l + 1);
  const int in = weights.topology.fan_in(l), out = weights.topology.fan_out(l);
  std::vector<float> matrix, bias;
  const float* row = weights.values.data() + weights.topology.layer_offset(l);
  for (int n = 0; n < out; ++n, row += in + 1) {
    matrix.insert(matrix.end(), row, row + in);
    bias.push_back(row[in]);
  }
  graph.numbers(weight_name(l), {out, in}, matrix);
  graph.numbers(bias_name(l), bias);
  graph.node("Gemm", {input, weight_name(l), bias_name(l)}, "sum" + layer, {{"transB", 1}});
  if (weights.topology.activation(l) == nn::Activation::leaky_relu)
    graph.node("LeakyRelu", {"sum" + layer}, "output" + layer);
  else
    add_logistic(graph, layer);
}

/// Counts the elements of [batch, n] above `limit`: [batch, 1].
void add_count(Builder& graph, const string& values, const string& limit, const string& name) {
  graph.node("Greater", {values, limit}, name + "_above");
  graph.node("Cast", {name + "_above"}, name + "_counted", to_float);
  graph.node("ReduceSum", {name + "_counted", "along_outputs"}, name, sum_of_row);
}

/// Class of a feature [batch, 1]: the number of edges below it.
void add_class(Builder& graph, const string& feature, const std::vector<float>& edges) {
  graph.numbers(feature + "_edges", edges);
  add_count(graph, feature, feature + "_edges", feature + "_class");
}

string column(int k) { return "column" + std::to_string(k); }

void add_quantiles(Builder& graph, const string& last) {
  for (int k = 0; k <= nn::Topology::heads; ++k) graph.integer(column(k), k);
  graph.integer("along_outputs", 1);
  graph.node("Add", {last, "half"}, "heads");
  const char* const names[] = {"slip_index", "width_above", "width_below"};
  for (int k = 0; k < nn::Topology::heads; ++k)
    graph.node("Slice", {"heads", column(k), column(k + 1), "along_outputs"}, names[k]);
  graph.node("Add", {"slip_index", "width_above"}, "upper_quantile");
  graph.node("Sub", {"slip_index", "width_below"}, "lower_quantile");
  graph.node("Sub", {"upper_quantile", "lower_quantile"}, "width");
}

void add_touching(Builder& graph, int tactels) {
  graph.integer("tactels", tactels);
  graph.scalar("touching_share", nn::Bound::touching_share);
  graph.node("Slice", {"scaled", "column0", "tactels", "along_outputs"}, "scaled_normal");
  graph.node("Abs", {"scaled_normal"}, "scaled_normal_size");
  graph.node("ReduceMax", {"scaled_normal_size"}, "scaled_largest", largest_of_row);
  graph.node("Mul", {"scaled_largest", "touching_share"}, "touching_least");
  add_count(graph, "scaled_normal_size", "touching_least", "touching");
}

/// |(scaled - centre) * whitening|^2.
void add_distance(Builder& graph) {
  graph.node("Sub", {"scaled", "centre"}, "centred");
  graph.node("MatMul", {"centred", "whitening"}, "white");
  graph.node("Mul", {"white", "white"}, "white_squares");
  graph.node("ReduceSum", {"white_squares", "along_outputs"}, "distance", sum_of_row);
}

/// (touching class * classes of S + class of S) * classes of the width + class of the width, times the classes of the
/// distance + its class where the bound has such, as an integer.
void add_classes(Builder& graph, const nn::Bound& bound) {
  add_class(graph, "touching", bound.touching);
  add_class(graph, "slip_index", bound.slip_index);
  add_class(graph, "width", bound.width);
  graph.scalar("slip_index_classes", static_cast<float>(bound.slip_index.size() + 1));
  graph.scalar("width_classes", static_cast<float>(bound.width.size() + 1));
  graph.node("Mul", {"touching_class", "slip_index_classes"}, "class1");
  graph.node("Add", {"class1", "slip_index_class"}, "class2");
  graph.node("Mul", {"class2", "width_classes"}, "class3");
  graph.node("Add", {"class3", "width_class"}, "class4");
  if (!bound.distance.empty()) {
    add_class(graph, "distance", bound.distance);
    graph.scalar("distance_classes", static_cast<float>(bound.distance.size() + 1));
    graph.node("Mul", {"class4", "distance_classes"}, "class5");
    graph.node("Add", {"class5", "distance_class"}, "class6");
  }
  graph.node("Cast", {bound.distance.empty() ? "class4" : "class6"}, "class", to_integer);
}

/// The upper end of a bound: the upper quantile and a correction, at least S, at most 1.
void add_upper_end(Builder& graph, const string& correction, const string& name) {
  graph.node("Add", {"upper_quantile", correction}, name + "_sum");
  graph.node("Max", {name + "_sum", "slip_index"}, name + "_above");
  graph.node("Min", {name + "_above", "largest_slip_index"}, name);
}

void add_corrected(Builder& graph, const nn::Bound& bound) {
  graph.scalar("largest_slip_index", 1.0f);
  graph.scalar("least_slip_index", -1.0f);
  const auto gather = [&graph](const string& name, const std::vector<float>& table) {
    graph.numbers(name + "_corrections", table);
    graph.node("Gather", {name + "_corrections", "class"}, name + "_correction", {{"axis", 0}});
  };
  gather("upper", bound.upper_correction);
  gather("interval", bound.interval_correction);
  add_upper_end(graph, "upper_correction", "slip_upper");
  add_upper_end(graph, "interval_correction", "interval_upper");
  graph.node("Sub", {"lower_quantile", "interval_correction"}, "interval_lower_sum");
  graph.node("Min", {"interval_lower_sum", "slip_index"}, "interval_lower_below");
  graph.node("Max", {"interval_lower_below", "least_slip_index"}, "interval_lower");
  graph.node("Concat", {"interval_lower", "interval_upper"}, "slip_interval", {{"axis", 1}});
}

void add_unlike(Builder& graph, const nn::Bound& bound) {
  const auto inputs = static_cast<std::int64_t>(bound.centre.size());
  graph.numbers("centre", bound.centre);
  graph.numbers("whitening", {inputs, inputs}, bound.whitening);
  graph.scalar("unlike_above", bound.unlike_above);
  if (bound.distance.empty()) add_distance(graph);
  graph.node("LessOrEqual", {"distance", "unlike_above"}, "within");
  graph.node("Not", {"within"}, "beyond");  // true also for a distance that is NaN
  graph.node("Cast", {"beyond"}, "unlike", to_float);
}

/// Bound::answer, from `scaled` and the outputs of the last layer.
void add_bound(Builder& graph, const nn::Bound& bound, const string& last) {
  add_quantiles(graph, last);
  add_touching(graph, bound.tactels);
  if (!bound.distance.empty()) add_distance(graph);  // before its class
  add_classes(graph, bound);
  add_corrected(graph, bound);
  add_unlike(graph, bound);
}

}  // namespace

string weight_name(int l) { return "weight" + std::to_string(l + 1); }
string bias_name(int l) { return "bias" + std::to_string(l + 1); }

Graph graph_of(const nn::Model& model) {
  const nn::Topology& topology = model.weights.topology;
  Graph graph{"tactel_" + topology.text(), {}, {}, {"frame", topology.inputs()}, {{nn::name(model.target), 1}}};
  Builder builder(graph);
  if (model.scaling.kind == nn::ScalingKind::set)
    add_set_scaling(builder, model.scaling);
  else
    add_frame_scaling(builder, model.scaling.normals(topology.inputs()));
  builder.scalar("half", 0.5f);
  string last = "scaled";
  for (int l = 0; l < topology.layers(); ++l) {
    add_layer(builder, model.weights, l, last);
    last = "output" + std::to_string(l + 1);
  }
  if (topology.has_bound()) {
    graph.outputs.insert(graph.outputs.end(), {{"slip_upper", 1}, {"slip_interval", 2}, {"unlike", 1}});
    add_bound(builder, model.bound.value(), last);
  } else {
    builder.node("Add", {last, "half"}, nn::name(model.target));
  }
  return graph;
}

}  // namespace tactel::infer
