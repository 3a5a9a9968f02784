// SPDX-License-Identifier: Apache-2.0
#include "nn/infer/network_graph.h"

#include <bit>
#include <set>
#include <utility>

#include "nn/features.h"

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
  void integer(const string& name, std::int64_t value) { integers(name, {1}, {value}); }
  void integers(const string& name, std::vector<std::int64_t> dims, const std::vector<std::int64_t>& values) {
    tensor(name, TensorType::integers, std::move(dims), values);
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

void add_set_scaling(Builder& graph, const nn::InputScaling& scaling, const string& frame, const string& output) {
  graph.scalar("factor", 1.0f / scaling.largest_stress);
  graph.node("Mul", {frame, "factor"}, output);
}

/// Each input by the largest |normal stress| of its first `normals` numbers, the newest frame's; zeros where there is
/// none.
void add_frame_scaling(Builder& graph, int normals, const string& frame, const string& output) {
  graph.integer("first_normal", 0);
  graph.integer("end_of_normal", normals);
  if (frame == "frame") graph.integer("along_frame", 1);
  graph.scalar("zero", 0.0f);
  graph.scalar("one", 1.0f);
  graph.scalar("smallest_stress", nn::InputScaling::smallest_stress);
  graph.node("Slice", {frame, "first_normal", "end_of_normal", "along_frame"}, "normal");
  graph.node("Abs", {"normal"}, "normal_size");
  graph.node("ReduceMax", {"normal_size"}, "largest_normal", largest_of_row);
  graph.node("Less", {"largest_normal", "smallest_stress"}, "no_stress");
  graph.node("Where", {"no_stress", "one", "largest_normal"}, "divisor");
  graph.node("Div", {frame, "divisor"}, "relative");
  graph.node("Where", {"no_stress", "zero", "relative"}, output);
}

/// Where each of so many scaled stresses of an image comes from, and its sign: of all images, [images][stresses].
void add_image_tables(Builder& graph, const nn::InputScaling& scaling, int n, int stresses) {
  const int columns = scaling.columns, rows = n / columns;
  const int images = scaling.features == nn::Features::line ? 2 : scaling.square ? 8 : 4;
  std::vector<std::int64_t> places;
  std::vector<float> signs;
  for (int image = 0; image < images; ++image)
    for (int k = 0; k < stresses; ++k) {
      const bool mirror_x = image & 1, mirror_y = image & 2, turn = image & 4;
      const int frame = k / (scaling.axes * n), axis = k / n % scaling.axes;
      const int i = turn ? k % n / columns : k % columns, j = turn ? k % columns : k % n / columns;
      const int from = turn && axis > 0 ? 3 - axis : axis;
      const int x = mirror_x ? columns - 1 - i : i, y = mirror_y ? rows - 1 - j : j;
      places.push_back((frame * scaling.axes + from) * n + y * columns + x);
      signs.push_back((from == 1 && mirror_x) || (from == 2 && mirror_y) ? -1.0f : 1.0f);
    }
  graph.integers("image_places", {images, stresses}, places);
  graph.numbers("image_signs", {images, stresses}, signs);
}

/// Slices of [batch, numbers], and sums over them, [batch, 1].
class Rows {
 public:
  explicit Rows(Builder& graph) : graph_(graph) {}
  void slice(const string& from, int first, int end, const string& output) {
    for (const int place : {first, end})
      if (known_.insert(place).second) graph_.integer("place" + std::to_string(place), place);
    graph_.node("Slice", {from, "place" + std::to_string(first), "place" + std::to_string(end), "along_frame"}, output);
  }
  void sum(const string& of, const string& output) {
    graph_.node("ReduceSum", {of, "along_frame"}, output, sum_of_row);
  }
  /// The sum of products of the factors.
  void sum_of(std::vector<string> factors, const string& output) {
    string product = factors[0];
    for (std::size_t k = 1; k < factors.size(); ++k) {
      const string next = output + "_product" + std::to_string(k);
      graph_.node("Mul", {product, factors[k]}, next);
      product = next;
    }
    sum(product, output);
  }
  /// At least nn::least_divisor.
  void divisor(const string& of, const string& output) { graph_.node("Max", {of, "least_divisor"}, output); }

 private:
  Builder& graph_;
  std::set<int> known_;
};

/// Differences of frames to the input's last one, the rest, over its P; zeros where it has none.
void add_rest_scaling(Builder& graph, Rows& rows, const nn::InputScaling& scaling, int numbers, const string& frame,
                      const string& output) {
  const int width = scaling.width(numbers), shown = scaling.shown() * width;
  if (frame == "frame") graph.integer("along_frame", 1);
  graph.scalar("zero", 0.0f);
  graph.scalar("one", 1.0f);
  graph.scalar("smallest_stress", nn::InputScaling::smallest_stress);
  rows.slice(frame, 0, shown, "path");
  rows.slice(frame, shown, shown + width, "rest");
  rows.slice("rest", 0, scaling.normals(numbers), "rest_normals");
  rows.sum("rest_normals", "rest_tension");
  graph.node("Neg", {"rest_tension"}, "rest_force");
  graph.node("Less", {"rest_force", "smallest_stress"}, "no_stress");
  graph.node("Where", {"no_stress", "one", "rest_force"}, "rest_divisor");
  if (scaling.shown() > 1) {
    const std::vector<string> repeated(static_cast<std::size_t>(scaling.shown()), "rest");
    graph.node("Concat", repeated, "rests", {{"axis", 1}});
  }
  graph.node("Sub", {"path", scaling.shown() > 1 ? "rests" : "rest"}, "changes");
  graph.node("Div", {"changes", "rest_divisor"}, "relative");
  graph.node("Where", {"no_stress", "zero", "relative"}, output);
}

/// The image of `relative_frame`, [batch, scaled stresses], that its newest frame's Q chooses.
void add_image(Builder& graph, Rows& rows, const nn::InputScaling& scaling, int n) {
  add_image_tables(graph, scaling, n, scaling.shown() * scaling.axes * n);
  const auto is_negative = [&](int axis, const string& name) {
    rows.slice("relative_frame", axis * n, (axis + 1) * n, name + "_newest");
    rows.sum(name + "_newest", name + "_force");
    graph.node("Less", {name + "_force", "zero"}, name + "_negative");
    graph.node("Cast", {name + "_negative"}, name + "_bit", to_float);
  };
  string image = "x_bit";
  const auto add_bit = [&](const string& bit, float weight, const string& name) {
    graph.scalar(bit + "_weight", weight);
    graph.node("Mul", {bit, bit + "_weight"}, bit + "_weighted");
    graph.node("Add", {image, bit + "_weighted"}, name);
    image = name;
  };
  is_negative(1, "x");
  if (scaling.features == nn::Features::pad) {
    is_negative(2, "y");
    add_bit("y_bit", 2, "image_xy");
  }
  if (scaling.square) {
    for (const string axis : {"x", "y"}) graph.node("Abs", {axis + "_force"}, axis + "_force_size");
    graph.node("Greater", {"y_force_size", "x_force_size"}, "turned");
    graph.node("Cast", {"turned"}, "turn_bit", to_float);
    add_bit("turn_bit", 4, "image_xyt");
  }
  graph.node("Cast", {image}, "image_column", to_integer);
  graph.node("Squeeze", {"image_column", "along_frame"}, "image");
  graph.node("Gather", {"image_places", "image"}, "its_places", {{"axis", 0}});
  graph.node("Gather", {"image_signs", "image"}, "its_signs", {{"axis", 0}});
  graph.node("GatherElements", {"relative_frame", "its_places"}, "placed", {{"axis", 1}});
  graph.node("Mul", {"placed", "its_signs"}, "canonical");
}

/// The sums of frames, [batch * history, numbers of a frame], in the order of nn/features.h.
std::vector<string> add_sums(Builder& graph, Rows& rows, const nn::InputScaling& scaling, int n) {
  const bool pad = scaling.features == nn::Features::pad;
  std::vector<float> x, y;
  const int last_row = n / scaling.columns - 1;
  for (int k = 0; k < n; ++k) {
    const int column = k % scaling.columns, row = k / scaling.columns;
    x.push_back(static_cast<float>(column) - static_cast<float>(scaling.columns - 1) / 2);
    y.push_back(static_cast<float>(row) - static_cast<float>(last_row) / 2);
  }
  graph.numbers("x", x);
  rows.slice("one_frame", 0, n, "normals");
  rows.slice("one_frame", n, 2 * n, "tx");
  graph.node("Neg", {"normals"}, "pressures");
  graph.node("Max", {"pressures", "zero"}, "p");
  rows.sum("pressures", "P");
  rows.sum("tx", "Qx");
  rows.sum("p", "w");
  rows.divisor("P", "by_p");
  rows.divisor("w", "by_w");
  const auto centre = [&](const string& axis) {
    rows.sum_of({"p", axis}, "w" + axis);
    graph.node("Div", {"w" + axis, "by_w"}, "c" + axis);
    graph.node("Sub", {axis, "c" + axis}, "d" + axis);
  };
  const auto over = [&](const string& sum, const string& divisor, const string& output) {
    graph.node("Div", {sum, divisor}, output);
  };
  const auto second_moment = [&](const string& weight, const string& divisor, const string& a, const string& b) {
    string name = weight + "_d" + a + "d" + b;
    rows.sum_of({weight, "d" + a, "d" + b}, name + "_sum");
    over(name + "_sum", divisor, name);
    return name;
  };
  centre("x");
  if (!pad) {
    graph.node("Abs", {"tx"}, "t");
    rows.sum("t", "T");
    rows.divisor("T", "by_t");
    over("Qx", "by_p", "Qx_P"), over("T", "by_p", "T_P");
    rows.sum_of({"tx", "dx"}, "tx_dx");
    const string pxx = second_moment("p", "by_w", "x", "x"), txx = second_moment("t", "by_t", "x", "x");
    return {"P", "Qx", "Qx_P", "cx", pxx, "T_P", txx, "tx_dx"};
  }
  graph.numbers("y", y);
  rows.slice("one_frame", 2 * n, 3 * n, "ty");
  rows.sum("ty", "Qy");
  centre("y");
  const auto length = [&](const string& a, const string& b, const string& output) {
    graph.node("Mul", {a, a}, output + "_a2");
    graph.node("Mul", {b, b}, output + "_b2");
    graph.node("Add", {output + "_a2", output + "_b2"}, output + "_2");
    graph.node("Sqrt", {output + "_2"}, output);
  };
  length("tx", "ty", "t");
  length("Qx", "Qy", "Q");
  rows.sum("t", "T");
  rows.divisor("T", "by_t"), rows.divisor("Q", "by_q");
  over("Q", "by_p", "Q_P"), over("Qx", "by_p", "Qx_P"), over("Qy", "by_p", "Qy_P"), over("T", "by_p", "T_P");
  over("Qx", "by_q", "ux"), over("Qy", "by_q", "uy");
  graph.node("Mul", {"dx", "ty"}, "M_left"), graph.node("Mul", {"dy", "tx"}, "M_right");
  graph.node("Sub", {"M_left", "M_right"}, "M_parts");
  rows.sum("M_parts", "M");
  over("M", "by_p", "M_P");
  graph.node("Mul", {"tx", "ux"}, "along_x"), graph.node("Mul", {"ty", "uy"}, "along_y");
  graph.node("Add", {"along_x", "along_y"}, "along");
  rows.sum_of({"along", "dx"}, "along_dx"), rows.sum_of({"along", "dy"}, "along_dy");
  const string pxx = second_moment("p", "by_w", "x", "x"), pyy = second_moment("p", "by_w", "y", "y");
  const string pxy = second_moment("p", "by_w", "x", "y");
  const string txx = second_moment("t", "by_t", "x", "x"), tyy = second_moment("t", "by_t", "y", "y");
  return {"P", "Qx", "Qy", "Q_P", "Qx_P", "Qy_P", "M_P",      "cx",      "cy",
          pxx, pyy,  pxy,  "T_P", txx,    tyy,    "along_dx", "along_dy"};
}

/// nn::add_features, from `relative_frame` and `largest_normal`.
void add_features(Builder& graph, Rows& rows, const nn::InputScaling& scaling, int numbers, const string& output) {
  const int n = scaling.normals(numbers);
  graph.scalar("least_divisor", nn::least_divisor);
  if (scaling.has_peak()) graph.scalar("usual_stress", scaling.usual_stress);
  add_image(graph, rows, scaling, n);
  graph.integers("shape_of_frames", {2}, {-1, scaling.axes * n});
  graph.integers("shape_of_sums", {2}, {-1, scaling.shown() * scaling.sums()});
  graph.node("Reshape", {"canonical", "shape_of_frames"}, "one_frame");
  graph.node("Concat", add_sums(graph, rows, scaling, n), "sums_of_frame", {{"axis", 1}});
  graph.node("Reshape", {"sums_of_frame", "shape_of_sums"}, "sums");
  if (!scaling.has_peak()) return graph.node("Concat", {"canonical", "sums"}, output, {{"axis", 1}});
  graph.node("Add", {"largest_normal", "usual_stress"}, "peak_and_usual");
  graph.node("Div", {"largest_normal", "peak_and_usual"}, "peak_share_of_any");
  graph.node("Where", {"no_stress", "zero", "peak_share_of_any"}, "peak_share");
  graph.node("Concat", {"canonical", "sums", "peak_share"}, output, {{"axis", 1}});
}

/// `frame` without what is told.
void add_stresses(Builder& graph, Rows& rows, int numbers) {
  graph.integer("along_frame", 1);
  rows.slice("frame", 0, numbers - 2, "stresses");
}

/// nn::tell_friction, from `frame` and `scaled_stresses` to `scaled`; zeros where these are of no stress.
void add_told(Builder& graph, Rows& rows, const nn::InputScaling& scaling, int numbers) {
  const bool has_status = scaling.kind != nn::ScalingKind::set;
  if (!has_status) graph.scalar("zero", 0.0f), graph.scalar("one", 1.0f);
  graph.scalar("usual_friction", nn::usual_friction);
  graph.scalar("usual_spread", nn::usual_spread);
  graph.scalar("not_told", 0.5f);
  const auto tell = [&](const string& name, int place, const char* of_none) {
    rows.slice("frame", place, place + 1, name);
    graph.node("Add", {name, "usual_" + name}, name + "_and_usual");
    graph.node("Div", {name, name + "_and_usual"}, name + "_share");
    if (place == numbers - 2) graph.node("Greater", {name, "zero"}, "told");
    graph.node("Where", {"told", name + "_share", of_none}, "told_" + name);
  };
  tell("friction", numbers - 2, "not_told");
  tell("spread", numbers - 1, "one");
  graph.node("Concat", {"scaled_stresses", "told_friction", "told_spread"}, has_status ? "all_inputs" : "scaled",
             {{"axis", 1}});
  if (has_status) graph.node("Where", {"no_stress", "zero", "all_inputs"}, "scaled");
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
  const bool features = model.scaling.features != nn::Features::frame;
  Graph graph{"tactel_" + topology.text(), {}, {}, {"frame", model.numbers()}, {{nn::name(model.target), 1}}};
  Builder builder(graph);
  Rows rows(builder);
  const nn::InputScaling& scaling = model.scaling;
  const int numbers = model.numbers();
  const string frame = scaling.friction ? "stresses" : "frame";
  const string inputs = scaling.friction ? "scaled_stresses" : "scaled",
               relative = features ? "relative_frame" : inputs;
  if (scaling.friction) add_stresses(builder, rows, numbers);
  if (scaling.kind == nn::ScalingKind::set)
    add_set_scaling(builder, scaling, frame, relative);
  else if (scaling.kind == nn::ScalingKind::frame)
    add_frame_scaling(builder, scaling.normals(numbers), frame, relative);
  else
    add_rest_scaling(builder, rows, scaling, numbers, frame, relative);
  if (features) add_features(builder, rows, scaling, numbers, inputs);
  if (scaling.friction) add_told(builder, rows, scaling, numbers);
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
