// SPDX-License-Identifier: Apache-2.0
#include "nn/infer/network_file.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cfenv>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>

#include "fem/numbers/value_error.h"
#include "nn/infer/loaded_network.h"
#include "nn/infer/network_graph.h"
#include "nn/infer/protobuf.h"

namespace tactel::infer {
namespace {

using std::string;
using std::string_view;

constexpr const char* own_network = "a network that tactel wrote, whole and unchanged";
constexpr const char* checksum_key = "checksum";
constexpr const char* definition_key = "target_definition";
constexpr std::size_t most_parts = 256;  ///< tensors, and entries of the metadata: more than any network has

/// Why some bytes are no network of ours.
struct Refused {
  string problem;
  string allowed = own_network;
};

// ------------------------------------------------------------------------------------------------------- writing ---

/// The shortest text that reads back to the same number.
template <class Number>
string exact(Number number) {
  char text[64];
  return {text, std::to_chars(text, text + sizeof text, number).ptr};
}

/// What a bound was calibrated on, and how far that goes.
void add_bound_metadata(const nn::Bound& bound, Metadata& metadata) {
  metadata["bound_level"] = exact(bound.level);
  metadata["bound_set"] = bound.set;
  metadata["bound_rows"] = exact(bound.rows);
  metadata["bound_seed"] = exact(bound.seed);
  if (!bound.distance.empty()) metadata["bound_version"] = "2";  // classes by distance, too
  metadata["bound_scope"] =
      bound.calibrated() ? "slip_upper and slip_interval hold at bound_level for frames drawn as the rows of bound_set "
                           "were, and for no others"
                         : "not calibrated: slip_upper and slip_interval hold at no level";
}

/// The numbers of what was learnt, by their keys in the metadata; absent where they are 0.
template <class Ranges>
auto ranges_of(Ranges& learnt) {
  return std::array{std::pair{"smallest_peak", &learnt.smallest_peak}, std::pair{"largest_peak", &learnt.largest_peak},
                    std::pair{"least_friction", &learnt.least_friction},
                    std::pair{"most_friction", &learnt.most_friction}, std::pair{"alarm_at", &learnt.alarm_at}};
}

Metadata metadata_of(const nn::Model& model, const string& version) {
  Metadata metadata{{"topology", model.weights.topology.text()},
                    {"seed", exact(model.seed)},
                    {"noise", exact(model.noise)},
                    {"learning_set", model.learning_set},
                    {"cycles", exact(model.cycles)},
                    {"scaling", nn::name(model.scaling.kind)},
                    {"largest_stress", exact(model.scaling.largest_stress)},
                    {"error_rows", exact(model.learning_errors.count)},
                    {"error_max", exact(model.learning_errors.max)},
                    {"error_mean", exact(model.learning_errors.mean)},
                    {"error_std", exact(model.learning_errors.std)},
                    {"tactel", version}};
  if (model.history.frames > 1) {
    metadata["history"] = exact(model.history.frames);
    metadata["stride"] = exact(model.history.stride);
    metadata["history_change"] = exact(model.history.change);
  }
  if (model.scaling.axes != 2) metadata["axes"] = exact(model.scaling.axes);
  if (model.scaling.friction) metadata["friction"] = "1";
  if (model.scaling.markers) metadata["inputs"] = "markers";
  if (model.scaling.features != nn::Features::frame) {
    metadata["features"] = nn::name(model.scaling.features);
    metadata["tactel_columns"] = exact(model.scaling.columns);
    metadata["tactel_square"] = model.scaling.square ? "1" : "0";
    metadata["usual_stress"] = exact(model.scaling.usual_stress);
  }
  if (model.magnitude) metadata["magnitude"] = "1";
  if (model.target != nn::Target::slip_index) metadata["target"] = nn::name(model.target);
  if (nn::is_slide(model.target)) metadata[definition_key] = nn::definition(model.target);
  for (const auto& [key, number] : ranges_of(model.learnt))
    if (*number != 0) metadata[key] = exact(*number);
  if (model.bound) add_bound_metadata(*model.bound, metadata);
  return metadata;
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

/// The checksum of a file: of names, types, dimensions and numbers of the tensors, then of the metadata but for the
/// checksum. It does not depend on protobuf's encoding.
string checksum_of(const std::vector<Tensor>& tensors, const Metadata& metadata) {
  string all;
  for (const Tensor& tensor : tensors) {
    append_counted(all, tensor.name);
    append_number(all, static_cast<std::int64_t>(tensor.type));
    append_number(all, static_cast<std::int64_t>(tensor.dims.size()));
    for (const std::int64_t extent : tensor.dims) append_number(all, extent);
    append_counted(all, tensor.raw);
  }
  for (const auto& [key, value] : metadata)
    if (key != checksum_key) append_counted(all, key), append_counted(all, value);
  return checksum_text(all);
}

Message message_of(const Node& node) {
  Message message;
  for (const string& input : node.inputs) message.add(node_input, input);
  message.add(node_output, node.output);
  message.add(node_name, node.output);
  message.add(node_type, node.type);
  for (const Attribute& attribute : node.attributes) {
    Message inner;
    inner.add(attribute_name, attribute.name);
    inner.add(attribute.list ? attribute_ints : attribute_i, static_cast<std::uint64_t>(attribute.value));
    inner.add(attribute_type, attribute.list ? type_ints : type_int);
    message.add(node_attribute, inner);
  }
  return message;
}

Message message_of(const Tensor& tensor) {
  Message message;
  for (const std::int64_t extent : tensor.dims) message.add(tensor_dims, static_cast<std::uint64_t>(extent));
  message.add(tensor_type, static_cast<std::uint64_t>(tensor.type));
  message.add(tensor_name, tensor.name);
  message.add(tensor_raw, tensor.raw);
  return message;
}

Message message_of(const Value& value) {
  Message rows, columns, shape, tensor, type, message;
  rows.add(dim_param, "batch");
  columns.add(dim_value, static_cast<std::uint64_t>(value.width));
  shape.add(shape_dim, rows);
  shape.add(shape_dim, columns);
  tensor.add(element_type, static_cast<std::uint64_t>(TensorType::floats));
  tensor.add(type_shape, shape);
  type.add(type_tensor, tensor);
  message.add(value_name, value.name);
  message.add(value_type, type);
  return message;
}

Message message_of(const Graph& graph) {
  Message message;
  for (const Node& node : graph.nodes) message.add(graph_node, message_of(node));
  message.add(graph_name, graph.name);
  for (const Tensor& tensor : graph.tensors) message.add(graph_tensor, message_of(tensor));
  message.add(graph_input, message_of(graph.input));
  for (const Value& output : graph.outputs) message.add(graph_output, message_of(output));
  return message;
}

/// The file of a network by a version of tactel, with what its target is unless that is `unsaid`.
string bytes_of(const nn::Model& model, const string& version, bool unsaid = false) {
  const Graph contents = graph_of(model);
  Metadata metadata = metadata_of(model, version);
  if (unsaid) metadata.erase(definition_key);
  metadata[checksum_key] = checksum_of(contents.tensors, metadata);
  Message message, opset;
  message.add(ir_version, 7);  // the one that came with opset 13 (ONNX 1.8)
  message.add(producer_name, "tactel");
  message.add(producer_version, version);
  const string what = model.target == nn::Target::slip_index ? "slippage index S = Q / (mu P)" : nn::name(model.target);
  message.add(doc_string,
              what + (model.scaling.markers ? " from displacements of markers in mm, x and y of each"
                                            : " from stresses at the tactels in MPa, normal stresses first"));
  message.add(graph, message_of(contents));
  opset.add(opset_domain, "");
  opset.add(opset_version, 13);
  message.add(opset_import, opset);
  for (const auto& [key, value] : metadata) {
    Message entry;
    entry.add(entry_key, key);
    entry.add(entry_value, value);
    message.add(metadata_props, entry);
  }
  return message.bytes();
}

// ------------------------------------------------------------------------------------------------------- reading ---

/// What the reader looks for in a file, by name.
struct Contents {
  string_view producer;
  std::vector<Tensor> tensors;
  Metadata metadata;
};

Tensor read_tensor(string_view message) {
  Tensor tensor{};
  Fields fields(message);
  for (Field field; fields.next(field);) {
    if (field.number == tensor_dims) tensor.dims.push_back(static_cast<std::int64_t>(number_of(field)));
    if (field.number == tensor_type) tensor.type = static_cast<TensorType>(number_of(field));
    if (field.number == tensor_name) tensor.name = content_of(field);
    if (field.number == tensor_raw) tensor.raw = content_of(field);
  }
  return tensor;
}

std::pair<string, string> read_entry(string_view message) {
  std::pair<string, string> entry;
  Fields fields(message);
  for (Field field; fields.next(field);) {
    if (field.number == entry_key) entry.first = content_of(field);
    if (field.number == entry_value) entry.second = content_of(field);
  }
  return entry;
}

void expect_few(std::size_t parts) {
  if (parts > most_parts) throw Refused{"a model of more parts than a network has"};
}

Contents read_contents(string_view bytes) {
  Contents contents;
  string_view nodes_and_tensors;
  Fields fields(bytes);
  for (Field field; fields.next(field);) {
    if (field.number == producer_name) contents.producer = content_of(field);
    if (field.number == graph) nodes_and_tensors = content_of(field);
    if (field.number == metadata_props) contents.metadata.insert(read_entry(content_of(field)));
    expect_few(contents.metadata.size());
  }
  Fields parts(nodes_and_tensors);
  for (Field field; parts.next(field); expect_few(contents.tensors.size()))
    if (field.number == graph_tensor) contents.tensors.push_back(read_tensor(content_of(field)));
  return contents;
}

const string& text_of(const Metadata& metadata, const char* key) {
  const auto found = metadata.find(key);
  if (found == metadata.end()) throw Refused{"a model without \"" + string(key) + "\" in its metadata"};
  return found->second;
}

template <class Number>
Number number_of(const Metadata& metadata, const char* key) {
  const string& text = text_of(metadata, key);
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(static_cast<double>(number)))
    throw Refused{string(key) + " \"" + shown(text) + '"', "a number"};
  return number;
}

const Tensor& tensor_of(const Contents& contents, const string& name) {
  const auto found = std::ranges::find(contents.tensors, name, &Tensor::name);
  if (found == contents.tensors.end()) throw Refused{"a graph without \"" + name + '"'};
  return *found;
}

template <class Number>
void read_numbers(const Contents& contents, const string& name, std::size_t count, Number* to) {
  const Tensor& tensor = tensor_of(contents, name);
  if (tensor.raw.size() != count * sizeof(Number)) throw Refused{"\"" + name + "\" of another size"};
  std::memcpy(to, tensor.raw.data(), tensor.raw.size());
}

std::vector<float> read_numbers(const Contents& contents, const string& name, std::size_t count) {
  std::vector<float> numbers(count);
  read_numbers(contents, name, count, numbers.data());
  return numbers;
}

std::vector<float> read_edges(const Contents& contents, const string& name) {
  return read_numbers(contents, name,
                      std::min(tensor_of(contents, name).raw.size() / sizeof(float), nn::Bound::most_edges));
}

void read_weights(const Contents& contents, nn::Weights<float>& weights) {
  float* row = weights.values.data();
  for (int l = 0; l < weights.topology.layers(); ++l) {
    const auto in = static_cast<std::size_t>(weights.topology.fan_in(l));
    const auto out = static_cast<std::size_t>(weights.topology.fan_out(l));
    const std::vector<float> matrix = read_numbers(contents, weight_name(l), in * out);
    const std::vector<float> bias = read_numbers(contents, bias_name(l), out);
    for (std::size_t n = 0; n < out; ++n, row += in + 1) {
      std::copy_n(&matrix[n * in], in, row);
      row[in] = bias[n];
    }
  }
  if (!std::ranges::all_of(weights.values, [](float w) { return std::isfinite(w); }))
    throw Refused{"a weight that is NaN or infinite", "a network with finite weights"};
}

nn::InputHistory read_history(const Metadata& metadata) {
  if (!metadata.contains("history")) return {};
  const nn::InputHistory history{number_of<int>(metadata, "history"), number_of<int>(metadata, "stride"),
                                 number_of<double>(metadata, "history_change"),
                                 text_of(metadata, "scaling") == nn::name(nn::ScalingKind::rest)};
  if (!history.valid() || history.frames < 2)
    throw Refused{"history " + shown(text_of(metadata, "history")),
                  "2 to 128 frames, a stride of 1 to 1000, a change of 0 to 1"};
  return history;
}

nn::Bound read_bound(const Contents& contents, int inputs) {
  const Metadata& metadata = contents.metadata;
  nn::Bound bound;
  bound.level = number_of<double>(metadata, "bound_level");
  bound.set = text_of(metadata, "bound_set");
  bound.rows = number_of<std::uint64_t>(metadata, "bound_rows");
  bound.seed = number_of<std::uint64_t>(metadata, "bound_seed");
  bound.touching = read_edges(contents, "touching_edges");
  bound.slip_index = read_edges(contents, "slip_index_edges");
  bound.width = read_edges(contents, "width_edges");
  if (metadata.contains("bound_version")) bound.distance = read_edges(contents, "distance_edges");
  const auto count = static_cast<std::size_t>(inputs);
  bound.upper_correction = read_numbers(contents, "upper_corrections", bound.classes());
  bound.interval_correction = read_numbers(contents, "interval_corrections", bound.classes());
  bound.centre = read_numbers(contents, "centre", count);
  bound.whitening = read_numbers(contents, "whitening", count * count);
  read_numbers(contents, "unlike_above", 1, &bound.unlike_above);
  std::int64_t tactels = 0;
  read_numbers(contents, "tactels", 1, &tactels);
  bound.tactels = static_cast<int>(std::clamp<std::int64_t>(tactels, 0, nn::Topology::widest_layer));
  bound.validate(inputs);
  return bound;
}

/// The inputs of a network are whole frames of whole tactels, and their sums.
void check_frames(const nn::Model& model) {
  const nn::InputScaling& scaling = model.scaling;
  const int numbers = model.numbers(), tactels = scaling.normals(numbers), stresses = numbers - scaling.told();
  const bool grid = scaling.features == nn::Features::frame || tactels % scaling.columns == 0;
  const bool turns = !scaling.square || tactels == scaling.columns * scaling.columns;
  const bool whole = scaling.inputs(numbers) == model.weights.topology.inputs();
  if (stresses > 0 && stresses % (scaling.axes * scaling.history) == 0 && whole && grid && turns) return;
  throw Refused{std::to_string(scaling.axes) + " axes and a history of " + std::to_string(scaling.history) +
                    " of the network " + model.weights.topology.text(),
                "stresses of a tactel and frames that divide its inputs, in columns that divide its tactels"};
}

/// The ranges that a network learnt, of which any may be absent. Throws ValueError for those that no set has.
nn::Learnt read_learnt(const Metadata& metadata) {
  constexpr float most = 1e6f;  // MPa; mu
  nn::Learnt learnt;
  for (const auto& [key, number] : ranges_of(learnt)) {
    if (!metadata.contains(key)) continue;
    *number = number_of<float>(metadata, key);
    if (!(*number > 0 && *number <= most)) throw ValueError(key, exact(*number), "above 0, at most 1e6");
  }
  const auto ordered = [](const char* key, float least, float largest) {
    if (largest > 0 && least > largest) throw ValueError(key, exact(least), "at most the largest, " + exact(largest));
  };
  ordered("smallest_peak", learnt.smallest_peak, learnt.largest_peak);
  ordered("least_friction", learnt.least_friction, learnt.most_friction);
  if (learnt.alarm_at >= 1) throw ValueError("alarm_at", exact(learnt.alarm_at), "below 1, which no answer reaches");
  return learnt;
}

nn::Model model_of(const Contents& contents) {
  const Metadata& metadata = contents.metadata;
  nn::Model model{nn::Weights<float>(nn::Topology::parse(text_of(metadata, "topology"))), {}, 0, 0, "", 0, {}};
  const nn::Topology& topology = model.weights.topology;
  model.history = read_history(metadata);
  model.scaling = {nn::parse_scaling(text_of(metadata, "scaling")), number_of<float>(metadata, "largest_stress"),
                   model.history.frames, metadata.contains("axes") ? number_of<int>(metadata, "axes") : 2};
  model.scaling.friction = model.history.friction = metadata.contains("friction");
  model.scaling.markers = metadata.contains("inputs");
  if (metadata.contains("features")) {
    model.scaling.features = nn::parse_features(text_of(metadata, "features"));
    model.scaling.columns = number_of<int>(metadata, "tactel_columns");
    model.scaling.square = text_of(metadata, "tactel_square") == "1";
    model.scaling.usual_stress = number_of<float>(metadata, "usual_stress");
  }
  model.scaling.validate();
  check_frames(model);
  model.magnitude = metadata.contains("magnitude");
  if (metadata.contains("target")) model.target = nn::parse_target(text_of(metadata, "target"));
  model.seed = number_of<std::uint64_t>(metadata, "seed");
  model.noise = number_of<double>(metadata, "noise");
  model.learning_set = text_of(metadata, "learning_set");
  model.cycles = number_of<std::uint32_t>(metadata, "cycles");
  model.learning_errors = {number_of<std::size_t>(metadata, "error_rows"), number_of<double>(metadata, "error_max"),
                           number_of<double>(metadata, "error_mean"), number_of<double>(metadata, "error_std")};
  model.learnt = read_learnt(metadata);
  read_weights(contents, model.weights);
  if (!topology.has_bound()) return model;
  model.bound = read_bound(contents, topology.inputs());
  if (model.scaling.width(model.numbers()) % model.bound->tactels != 0)
    throw ValueError("bound.tactels", std::to_string(model.bound->tactels),
                     "such that the network has whole frames of them");
  return model;
}

/// The fields of a file, sorted: their order means nothing.
std::vector<string_view> sorted_fields(string_view bytes) {
  std::vector<string_view> all;
  Fields fields(bytes);
  for (Field field; fields.next(field);) all.push_back(field.whole);
  std::ranges::sort(all);
  return all;
}

/// While it lives, this thread rounds to nearest: the graph holds a quotient.
class RoundingToNearest {
 public:
  RoundingToNearest() { std::fesetround(FE_TONEAREST); }
  ~RoundingToNearest() { std::fesetround(before_); }
  RoundingToNearest(const RoundingToNearest&) = delete;
  RoundingToNearest& operator=(const RoundingToNearest&) = delete;

 private:
  int before_ = std::fegetround();
};

NetworkFile read(string_view bytes) {
  if (bytes.empty()) throw Refused{"empty"};
  if (bytes.size() > most_network_bytes) throw Refused{"larger than 4 MiB"};
  Contents contents = read_contents(bytes);
  if (contents.producer != "tactel") throw Refused{"a model by \"" + shown(string(contents.producer)) + '"'};
  if (text_of(contents.metadata, checksum_key) != checksum_of(contents.tensors, contents.metadata))
    throw Refused{"damaged (its checksum does not match)"};
  nn::Model model = model_of(contents);
  // Files of before do not say what their `slid` is: sets of grips had the cells' slips under that name.
  const bool unsaid = model.target == nn::Target::slid && !contents.metadata.contains(definition_key);
  const string written = bytes_of(model, text_of(contents.metadata, "tactel"), unsaid);
  if (sorted_fields(bytes) != sorted_fields(written)) throw Refused{"a model of another form"};
  if (unsaid) {
    model.target = nn::Target::slip_path;
    contents.metadata["target"] = nn::name(model.target);
    contents.metadata[definition_key] = string(nn::definition(model.target)) + ", if grips taught it; else slid";
  }
  return {std::move(model), std::move(contents.metadata)};
}

}  // namespace

string network_bytes(const nn::Model& model) {
  const RoundingToNearest rounding;
  return bytes_of(model, TACTEL_VERSION);
}

NetworkFile read_network(string_view bytes) try {
  const RoundingToNearest rounding;
  return read(bytes);
} catch (const Refused& refused) {
  throw ValueError("network", refused.problem, refused.allowed);
} catch (const Malformed&) {
  throw ValueError("network", "truncated, or no ONNX file", own_network);
} catch (const ValueError& error) {
  throw ValueError("network", error.key + " = " + shown(error.value), error.allowed);
}

SlipEstimator estimator_of(const nn::Model& model) {
  return SlipEstimator::Network::of(model, metadata_of(model, TACTEL_VERSION));
}

}  // namespace tactel::infer

namespace tactel {

SlipEstimator SlipEstimator::Network::of(const nn::Model& model, infer::Metadata metadata) {
  const infer::RoundingToNearest rounding;
  const nn::Topology& topology = model.weights.topology;
  auto network = std::make_unique<Network>();
  network->inputs = model.numbers();
  network->scaling = model.scaling;
  network->history = model.history;
  network->normals = model.scaling.normals(network->inputs);
  network->factor = 1.0f / model.scaling.largest_stress;
  network->learnt = model.learnt;
  network->metadata = std::move(metadata);
  const int last = topology.hidden_layers();
  for (int l = 0; l < last; ++l) network->hidden.push_back(infer::hidden_layer(model.weights, l));
  network->last = topology.fan_in(last);
  network->output.assign(model.weights.values.end() - topology.outputs() * (network->last + 1),
                         model.weights.values.end());
  network->bound = model.bound;
  if (network->bound)
    network->bound->whitening = infer::tiled(model.bound->whitening, static_cast<std::size_t>(topology.inputs()));
  return SlipEstimator(network.release());
}

}  // namespace tactel
