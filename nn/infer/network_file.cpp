// SPDX-License-Identifier: Apache-2.0
#include "nn/infer/network_file.h"

#define XXH_INLINE_ALL
#include <tactel/error.h>
#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>

#include "nn/infer/protobuf_fields.h"

namespace tactel::infer {
namespace {

static_assert(std::endian::native == std::endian::little, "ONNX keeps raw data little-endian");

using std::string;
using std::string_view;

constexpr std::size_t most_bytes = 4 << 20;  ///< of a file; the largest topology's weights take 0.5 MB
constexpr std::size_t most_parts = 256;      ///< nodes, initializers or metadata: more than any network has
constexpr const char* own_network = "a network that tactel wrote, whole and unchanged";
constexpr const char* checksum_key = "checksum";

/// Why some bytes are no network of ours.
struct Refused {
  string problem;
  string fix = own_network;
};

// Numbers of the fields (onnx.proto of ONNX 1.8).
enum ModelField : std::uint32_t { producer_name = 2, graph = 7, opset_import = 8, metadata_props = 14 };
enum OpsetField : std::uint32_t { opset_domain = 1, opset_version = 2 };
enum EntryField : std::uint32_t { entry_key = 1, entry_value = 2 };
enum GraphField : std::uint32_t { graph_node = 1, graph_initializer = 5, graph_input = 11, graph_output = 12 };
enum NodeField : std::uint32_t { node_input = 1, node_output = 2, node_type = 4, node_attribute = 5, node_domain = 7 };
enum AttributeField : std::uint32_t { attribute_name = 1, attribute_i = 3, attribute_ints = 8 };
enum TensorField : std::uint32_t { tensor_dims = 1, tensor_type = 2, tensor_name = 8, tensor_raw = 9 };
enum ValueField : std::uint32_t { value_name = 1 };
enum TensorType : std::uint64_t { type_float = 1, type_int64 = 7 };

constexpr std::uint64_t first_opset = 13;

/// One operation of the graph. Operands are joined by commas, attributes are "name=value".
struct Node {
  string type, inputs, output, attributes;
  bool operator==(const Node&) const = default;
};

struct Tensor {
  string_view name, raw;
  std::uint64_t type = 0;
  std::vector<std::int64_t> dims;
};

struct Graph {
  std::vector<Node> nodes;
  std::vector<Tensor> tensors;
  std::vector<string_view> inputs, outputs;
};

string_view bytes_of(const Field& field) {
  if (field.wire != Field::bytes) throw Malformed{};
  return field.content;
}

std::uint64_t number_of(const Field& field) {
  if (field.wire != Field::varint) throw Malformed{};
  return field.value;
}

template <class List>
void expect_room(const List& list) {
  if (list.size() >= most_parts) throw Refused{"a model of more parts than a network has"};
}

void append(string& list, string_view word) {
  if (!list.empty()) list += ',';
  list += word;
}

string read_attribute(string_view message) {
  string name, value;
  Fields fields(message);
  for (Field field; fields.next(field);) {
    if (field.number == attribute_name) name = bytes_of(field);
    if (field.number == attribute_i || field.number == attribute_ints) append(value, std::to_string(number_of(field)));
  }
  return name + "=" + value;
}

Node read_node(string_view message) {
  Node node;
  Fields fields(message);
  for (Field field; fields.next(field);) {
    if (field.number == node_input) append(node.inputs, bytes_of(field));
    if (field.number == node_output) append(node.output, bytes_of(field));
    if (field.number == node_type) node.type = bytes_of(field);
    if (field.number == node_attribute) append(node.attributes, read_attribute(bytes_of(field)));
    if (field.number == node_domain) throw Refused{"a model of another form"};
  }
  return node;
}

Tensor read_tensor(string_view message) {
  Tensor tensor;
  Fields fields(message);
  for (Field field; fields.next(field);) {
    if (field.number == tensor_dims) {
      expect_room(tensor.dims);
      tensor.dims.push_back(static_cast<std::int64_t>(number_of(field)));
    }
    if (field.number == tensor_type) tensor.type = number_of(field);
    if (field.number == tensor_name) tensor.name = bytes_of(field);
    if (field.number == tensor_raw) tensor.raw = bytes_of(field);
  }
  return tensor;
}

string_view read_value_name(string_view message) {
  string_view name;
  Fields fields(message);
  for (Field field; fields.next(field);)
    if (field.number == value_name) name = bytes_of(field);
  return name;
}

Graph read_graph(string_view message) {
  Graph read;
  Fields fields(message);
  for (Field field; fields.next(field);) {
    if (field.number == graph_node) {
      expect_room(read.nodes);
      read.nodes.push_back(read_node(bytes_of(field)));
    } else if (field.number == graph_initializer) {
      expect_room(read.tensors);
      read.tensors.push_back(read_tensor(bytes_of(field)));
    } else if (field.number == graph_input) {
      expect_room(read.inputs);
      read.inputs.push_back(read_value_name(bytes_of(field)));
    } else if (field.number == graph_output) {
      expect_room(read.outputs);
      read.outputs.push_back(read_value_name(bytes_of(field)));
    }
  }
  return read;
}

struct Model {
  std::vector<string_view> graphs, producers;
  std::uint64_t opset = 0;
  std::map<string, string, std::less<>> metadata;
};

void read_opset(string_view message, Model& into) {
  string_view domain;
  std::uint64_t version = 0;
  Fields fields(message);
  for (Field field; fields.next(field);) {
    if (field.number == opset_domain) domain = bytes_of(field);
    if (field.number == opset_version) version = number_of(field);
  }
  if (domain.empty()) into.opset = version;
}

void read_entry(string_view message, Model& into) {
  string key, value;
  Fields fields(message);
  for (Field field; fields.next(field);) {
    if (field.number == entry_key) key = bytes_of(field);
    if (field.number == entry_value) value = bytes_of(field);
  }
  expect_room(into.metadata);
  if (!into.metadata.emplace(std::move(key), std::move(value)).second) throw Refused{"a model of another form"};
}

Model read_model(string_view bytes) {
  Model model;
  Fields fields(bytes);
  for (Field field; fields.next(field);) {
    switch (field.number) {
      case producer_name:
        expect_room(model.producers);
        model.producers.push_back(bytes_of(field));
        break;
      case graph:
        expect_room(model.graphs);
        model.graphs.push_back(bytes_of(field));
        break;
      case opset_import:
        read_opset(bytes_of(field), model);
        break;
      case metadata_props:
        read_entry(bytes_of(field), model);
        break;
      default:
        break;
    }
  }
  return model;
}

string checksum_text(string_view bytes) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(XXH3_64bits(bytes.data(), bytes.size())));
  return text;
}

void append_number(string& all, std::int64_t number) {
  all.append(reinterpret_cast<const char*>(&number), sizeof number);
}
void append_counted(string& all, string_view text) {
  append_number(all, static_cast<std::int64_t>(text.size()));
  all.append(text);
}

/// The checksum of files: of names, types, dimensions and numbers of the initializers, then of the metadata.
string checksum_of(const Graph& graph, const Model& model) {
  string all;
  for (const Tensor& tensor : graph.tensors) {
    append_counted(all, tensor.name);
    append_number(all, static_cast<std::int64_t>(tensor.type));
    append_number(all, static_cast<std::int64_t>(tensor.dims.size()));
    for (const std::int64_t extent : tensor.dims) append_number(all, extent);
    append_counted(all, tensor.raw);
  }
  for (const auto& [key, value] : model.metadata)
    if (key != checksum_key) append_counted(all, key), append_counted(all, value);
  return checksum_text(all);
}

/// The same in files of the first versions: of the graph's bytes and all metadata.
string first_checksum_of(string_view graph, const Model& model) {
  string all(graph);
  for (const auto& [key, value] : model.metadata)
    if (key != checksum_key) all.append("\n").append(key).append("=").append(value);
  return checksum_text(all);
}

const string& entry(const Model& model, string_view key) {
  const auto found = model.metadata.find(key);
  if (found == model.metadata.end()) throw Refused{"a model without \"" + string(key) + "\" in its metadata"};
  return found->second;
}

constexpr string_view leaky_end = "_leaky-relu";  ///< of the text of a topology whose hidden neurons are such

/// "42-42-21-1", or "42-42-21-1_leaky-relu", as widths: an even number of inputs, one or two hidden layers, one output,
/// or the heads of a bound.
std::vector<int> widths_of(const string& topology) {
  std::vector<int> widths;
  const char* at = topology.data();
  const char* const end = at + topology.size() - (topology.ends_with(leaky_end) ? leaky_end.size() : 0);
  bool good = true;
  while (good && widths.size() < 5) {
    int width = 0;
    const auto [rest, error] = std::from_chars(at, end, width);
    good = error == std::errc{} && width >= 1 && width <= widest_layer && (rest == end || *rest == '-');
    widths.push_back(width);
    if (rest == end) break;
    at = rest + 1;
  }
  if (!good || widths.size() < 3 || widths.size() > 4 || widths.front() % 2 != 0 ||
      (widths.back() != 1 && widths.back() != heads))
    throw Refused{"a model of an unknown topology"};
  return widths;
}

void add_count(std::vector<Node>& nodes, const string& values, const string& limit, const string& name) {
  nodes.push_back({"Greater", values + "," + limit, name + "_above", ""});
  nodes.push_back({"Cast", name + "_above", name + "_counted", "to=1"});
  nodes.push_back({"ReduceSum", name + "_counted,along_outputs", name, "keepdims=1"});
}

/// The part of a graph that our exporter writes for a bound (host/networks/onnx_bound.cpp).
void add_bound_nodes(std::vector<Node>& nodes, const string& last, bool by_distance) {
  const auto column = [](int k) {
    return "heads,column" + std::to_string(k) + ",column" + std::to_string(k + 1) + ",along_outputs";
  };
  const auto add = [&nodes](const char* type, const string& inputs, const char* output, const char* attributes = "") {
    nodes.push_back({type, inputs, output, attributes});
  };
  add("Add", last + ",half", "heads");
  add("Slice", column(0), "slip_index");
  add("Slice", column(1), "width_above");
  add("Slice", column(2), "width_below");
  add("Add", "slip_index,width_above", "upper_quantile");
  add("Sub", "slip_index,width_below", "lower_quantile");
  add("Sub", "upper_quantile,lower_quantile", "width");
  add("Slice", "scaled,column0,tactels,along_outputs", "scaled_normal");
  add("Abs", "scaled_normal", "scaled_normal_size");
  add("ReduceMax", "scaled_normal_size", "scaled_largest", "axes=1,keepdims=1");
  add("Mul", "scaled_largest,touching_share", "touching_least");
  add_count(nodes, "scaled_normal_size", "touching_least", "touching");
  const auto add_distance = [&] {
    add("Sub", "scaled,centre", "centred");
    add("MatMul", "centred,whitening", "white");
    add("Mul", "white,white", "white_squares");
    add("ReduceSum", "white_squares,along_outputs", "distance", "keepdims=1");
  };
  if (by_distance) add_distance();
  for (const char* feature : {"touching", "slip_index", "width"})
    add_count(nodes, feature, string(feature) + "_edges", string(feature) + "_class");
  add("Mul", "touching_class,slip_index_classes", "class1");
  add("Add", "class1,slip_index_class", "class2");
  add("Mul", "class2,width_classes", "class3");
  add("Add", "class3,width_class", "class4");
  if (by_distance) {
    add_count(nodes, "distance", "distance_edges", "distance_class");
    add("Mul", "class4,distance_classes", "class5");
    add("Add", "class5,distance_class", "class6");
  }
  add("Cast", by_distance ? "class6" : "class4", "class", "to=7");
  add("Gather", "upper_corrections,class", "upper_correction", "axis=0");
  add("Gather", "interval_corrections,class", "interval_correction", "axis=0");
  for (const auto& [correction, name] :
       {std::pair{"upper_correction", "slip_upper"}, {"interval_correction", "interval_upper"}}) {
    const string end = name;
    nodes.push_back({"Add", string("upper_quantile,") + correction, end + "_sum", ""});
    nodes.push_back({"Max", end + "_sum,slip_index", end + "_above", ""});
    nodes.push_back({"Min", end + "_above,largest_slip_index", end, ""});
  }
  add("Sub", "lower_quantile,interval_correction", "interval_lower_sum");
  add("Min", "interval_lower_sum,slip_index", "interval_lower_below");
  add("Max", "interval_lower_below,least_slip_index", "interval_lower");
  add("Concat", "interval_lower,interval_upper", "slip_interval", "axis=1");
  if (!by_distance) add_distance();
  add("LessOrEqual", "distance,unlike_above", "within");
  add("Not", "within", "beyond");
  add("Cast", "beyond", "unlike", "to=1");
}

/// The graph that our exporter writes for a number of layers, of leaky rectifiers but for the last, and a scaling.
std::vector<Node> expected_nodes(std::size_t layers, bool leaky, bool by_frame, bool bound, bool by_distance) {
  std::vector<Node> nodes;
  if (by_frame)
    nodes = {{"Slice", "frame,first_normal,end_of_normal,along_frame", "normal", ""},
             {"Abs", "normal", "normal_size", ""},
             {"ReduceMax", "normal_size", "largest_normal", "axes=1,keepdims=1"},
             {"Less", "largest_normal,smallest_stress", "no_stress", ""},
             {"Where", "no_stress,one,largest_normal", "divisor", ""},
             {"Div", "frame,divisor", "relative", ""},
             {"Where", "no_stress,zero,relative", "scaled", ""}};
  else
    nodes = {{"Mul", "frame,factor", "scaled", ""}};
  string last = "scaled";
  for (std::size_t l = 1; l <= layers; ++l) {
    const string n = std::to_string(l);
    last.append(",weight").append(n).append(",bias").append(n);
    nodes.push_back({"Gemm", last, "sum" + n, "transB=1"});
    last = "output" + n;
    if (leaky && l < layers) {
      nodes.push_back({"LeakyRelu", "sum" + n, last, ""});
      continue;
    }
    nodes.push_back({"Mul", "sum" + n + ",half", "half_sum" + n, ""});
    nodes.push_back({"Tanh", "half_sum" + n, "tanh" + n, ""});
    nodes.push_back({"Mul", "tanh" + n + ",half", last, ""});
  }
  if (bound)
    add_bound_nodes(nodes, last, by_distance);
  else
    nodes.push_back({"Add", last + ",half", "slip_index", ""});
  return nodes;
}

/// Takes the initializers of a graph by their names; each must be taken.
class Initializers {
 public:
  explicit Initializers(const std::vector<Tensor>& tensors) {
    for (const Tensor& tensor : tensors)
      if (!left_.emplace(tensor.name, &tensor).second) refuse();
  }
  std::vector<float> numbers(string_view name, const std::vector<std::int64_t>& dims) {
    return values<float>(name, type_float, dims);
  }
  /// A list of 1 to `most` numbers.
  std::vector<float> list(string_view name, std::size_t most) {
    const auto found = left_.find(name);
    if (found == left_.end()) throw Refused{"a graph without \"" + string(name) + '"'};
    const std::size_t count = found->second->raw.size() / sizeof(float);
    if (count < 1 || count > most) refuse();
    return numbers(name, {static_cast<std::int64_t>(count)});
  }
  std::int64_t integer(string_view name) { return values<std::int64_t>(name, type_int64, {1}).front(); }
  void expect(string_view name, float value) {
    if (numbers(name, {}).front() != value) refuse();
  }
  void expect(string_view name, std::int64_t value) {
    if (values<std::int64_t>(name, type_int64, {1}).front() != value) refuse();
  }
  void finish() const {
    if (!left_.empty()) refuse();
  }

 private:
  [[noreturn]] static void refuse() { throw Refused{"a model of another form"}; }

  template <class Number>
  std::vector<Number> values(string_view name, TensorType type, const std::vector<std::int64_t>& dims) {
    const auto found = left_.find(name);
    if (found == left_.end()) throw Refused{"a graph without \"" + string(name) + '"'};
    const Tensor& tensor = *found->second;
    std::size_t count = 1;
    for (const std::int64_t extent : dims) count *= static_cast<std::size_t>(extent);
    if (tensor.type != type || tensor.dims != dims || tensor.raw.size() != count * sizeof(Number)) refuse();
    std::vector<Number> numbers(count);
    std::memcpy(numbers.data(), tensor.raw.data(), tensor.raw.size());
    left_.erase(found);
    return numbers;
  }

  std::map<string_view, const Tensor*> left_;
};

void expect_finite(const std::vector<float>& numbers) {
  if (!std::ranges::all_of(numbers, [](float x) { return std::isfinite(x); }))
    throw Refused{"a weight that is NaN or infinite"};
}

template <class Number>
Number number_of(const Model& model, string_view key) {
  const string& text = entry(model, key);
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size())
    throw Refused{"a model whose \"" + string(key) + "\" is no number"};
  return number;
}

/// Which frames an input of `inputs` numbers has.
nn::InputHistory history_of(const Model& model, int inputs) {
  if (!model.metadata.contains("history")) return {};
  const nn::InputHistory history{number_of<int>(model, "history"), number_of<int>(model, "stride"),
                                 number_of<double>(model, "history_change")};
  if (!history.valid() || history.frames < 2 || inputs % (2 * history.frames) != 0)
    throw Refused{"a model of an unknown history"};
  return history;
}

std::vector<float> read_edges(Initializers& initializers, const char* name) {
  constexpr std::size_t most_edges = 16;
  std::vector<float> edges = initializers.list(name, most_edges);
  expect_finite(edges);
  if (!std::ranges::is_sorted(edges, std::less_equal{})) throw Refused{"edges of classes that do not ascend"};
  return edges;
}

FileBound read_bound(Initializers& initializers, int inputs, bool by_distance) {
  for (int k = 0; k <= heads; ++k) initializers.expect("column" + std::to_string(k), std::int64_t{k});
  initializers.expect("along_outputs", std::int64_t{1});
  initializers.expect("touching_share", touching_share);
  initializers.expect("largest_slip_index", 1.0f);
  initializers.expect("least_slip_index", -1.0f);
  FileBound bound;
  const std::int64_t tactels = initializers.integer("tactels");
  if (tactels < 1 || tactels > inputs / 2 || inputs % (2 * tactels) != 0)
    throw Refused{"a bound of tactels that its frames have not"};
  bound.tactels = static_cast<std::size_t>(tactels);
  bound.touching = read_edges(initializers, "touching_edges");
  bound.slip_index = read_edges(initializers, "slip_index_edges");
  bound.width = read_edges(initializers, "width_edges");
  if (by_distance) {
    bound.distance = read_edges(initializers, "distance_edges");
    initializers.expect("distance_classes", static_cast<float>(bound.distance.size() + 1));
  }
  const std::size_t slips = bound.slip_index.size() + 1, widths = bound.width.size() + 1;
  initializers.expect("slip_index_classes", static_cast<float>(slips));
  initializers.expect("width_classes", static_cast<float>(widths));
  const auto classes =
      static_cast<std::int64_t>((bound.touching.size() + 1) * slips * widths * (bound.distance.size() + 1));
  bound.upper_correction = initializers.numbers("upper_corrections", {classes});
  bound.interval_correction = initializers.numbers("interval_corrections", {classes});
  bound.centre = initializers.numbers("centre", {inputs});
  bound.whitening = initializers.numbers("whitening", {inputs, inputs});
  bound.unlike_above = initializers.numbers("unlike_above", {}).front();
  for (const auto* table : {&bound.upper_correction, &bound.interval_correction, &bound.centre, &bound.whitening})
    expect_finite(*table);
  if (!std::isfinite(bound.unlike_above) || !(bound.unlike_above > 0))
    throw Refused{"a limit of unlike frames that is no number above 0"};
  return bound;
}

NetworkFile network_of(const Graph& graph, const Model& model) {
  const std::vector<int> widths = widths_of(entry(model, "topology"));
  const string& scaling = entry(model, "scaling");
  if (scaling != "set" && scaling != "frame") throw Refused{"a model of an unknown scaling"};
  NetworkFile file;
  file.by_frame = scaling == "frame";
  file.history = history_of(model, widths.front());
  const std::size_t layers = widths.size() - 1;
  const bool bound = widths.back() == heads, leaky = entry(model, "topology").ends_with(leaky_end);
  std::vector<string_view> outputs{"slip_index"};
  if (bound) outputs.insert(outputs.end(), {"slip_upper", "slip_interval", "unlike"});
  const bool by_distance =
      std::ranges::any_of(graph.tensors, [](const Tensor& t) { return t.name == "distance_edges"; });
  if (graph.nodes != expected_nodes(layers, leaky, file.by_frame, bound, by_distance) ||
      graph.inputs != std::vector<string_view>{"frame"} || graph.outputs != outputs)
    throw Refused{"a model of another form"};
  Initializers initializers(graph.tensors);
  initializers.expect("half", 0.5f);
  if (file.by_frame) {
    initializers.expect("first_normal", std::int64_t{0});
    initializers.expect("end_of_normal", std::int64_t{widths.front() / (2 * file.history.frames)});
    initializers.expect("along_frame", std::int64_t{1});
    initializers.expect("zero", 0.0f);
    initializers.expect("one", 1.0f);
    initializers.expect("smallest_stress", 1e-12f);
  } else {
    file.factor = initializers.numbers("factor", {}).front();
    if (!std::isfinite(file.factor) || !(file.factor > 0)) throw Refused{"a scaling that is no number above 0"};
  }
  for (std::size_t l = 0; l < layers; ++l) {
    FileLayer layer{
        .inputs = widths[l], .outputs = widths[l + 1], .leaky = leaky && l + 1 < layers, .weights = {}, .bias = {}};
    layer.weights = initializers.numbers("weight" + std::to_string(l + 1), {layer.outputs, layer.inputs});
    layer.bias = initializers.numbers("bias" + std::to_string(l + 1), {layer.outputs});
    expect_finite(layer.weights);
    expect_finite(layer.bias);
    file.layers.push_back(std::move(layer));
  }
  if (bound) file.bound = read_bound(initializers, widths.front(), by_distance);
  initializers.finish();
  file.metadata = model.metadata;
  return file;
}

NetworkFile read(string_view bytes) {
  if (bytes.empty()) throw Refused{"empty"};
  if (bytes.size() > most_bytes) throw Refused{"larger than 4 MiB"};
  const Model model = read_model(bytes);
  if (model.graphs.size() != 1 || model.producers.size() != 1 || model.producers.front() != "tactel")
    throw Refused{"no network of tactel"};
  if (model.opset < first_opset) throw Refused{"a model of an older opset than 13"};
  const Graph graph = read_graph(model.graphs.front());
  const string& sum = entry(model, checksum_key);
  if (sum != checksum_of(graph, model) && sum != first_checksum_of(model.graphs.front(), model))
    throw Refused{"damaged (its checksum does not match)"};
  return network_of(graph, model);
}

}  // namespace

NetworkFile read_network_file(string_view bytes, const string& place) try {
  return read(bytes);
} catch (const Refused& refused) {
  throw InputError(place, refused.problem, refused.fix);
} catch (const Malformed&) {
  throw InputError(place, "truncated, or no ONNX file", own_network);
}

string read_network_bytes(const string& path) {
  const auto fail = [&](const string& reason) -> InputError {
    return {path, "cannot be read (" + reason + ")", "a network that tactel wrote (ONNX, at most 4 MiB)"};
  };
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) throw fail(std::strerror(ENOENT));
  if (error) throw fail(error.message());
  if (!std::filesystem::is_regular_file(status)) throw fail("no regular file");
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) throw fail(std::strerror(errno));
  string bytes(most_bytes + 1, '\0');
  bytes.resize(std::fread(bytes.data(), 1, bytes.size(), file.get()));
  if (std::ferror(file.get())) throw fail(std::strerror(errno));
  return bytes;
}

}  // namespace tactel::infer
