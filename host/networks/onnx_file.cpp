// SPDX-License-Identifier: Apache-2.0
#include "host/networks/onnx_file.h"

#include <fmt/format.h>
#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

#include "fem/value_error.h"
#include "host/networks/onnx_bound.h"
#include "host/networks/onnx_graph.h"
#include "host/support/bounded_file.h"
#include "host/support/checksum.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;
using Metadata = std::map<std::string, std::string>;

constexpr std::int64_t opset = 13;
constexpr std::int64_t ir_version = 7;                ///< the one that came with opset 13 (ONNX 1.8)
constexpr std::uintmax_t most_model_bytes = 4 << 20;  ///< of a file; the largest topology's weights take 0.5 MB

// The shortest text that reads back to the same number.
template <class Number>
std::string exact(Number number) {
  char text[64];
  return {text, std::to_chars(text, text + sizeof text, number).ptr};
}

// As files had it that were written before onnx_checksum: of the graph's bytes and all metadata.
std::string checksum_of_bytes(const onnx::GraphProto& graph, const Metadata& metadata) {
  std::string all = graph.SerializeAsString();
  for (const auto& [key, value] : metadata)
    if (key != checksum_key) all.append("\n").append(key).append("=").append(value);
  return checksum_text(all);
}

/// What a bound was calibrated on, and how far that goes.
void add_bound_metadata(const nn::Bound& bound, Metadata& metadata) {
  metadata["bound_level"] = exact(bound.level);
  metadata["bound_set"] = bound.set;
  metadata["bound_rows"] = exact(bound.rows);
  metadata["bound_seed"] = exact(bound.seed);
  if (!bound.distance.empty()) metadata["bound_version"] = "2";  // classes by distance too; absent: the first
  if (bound.least > 0) metadata["bound_least"] = exact(bound.least);
  if (!bound.left_out.empty()) metadata["bound_left_out"] = bound.left_out;
  metadata["bound_scope"] =
      bound.calibrated() ? "slip_upper and slip_interval hold at bound_level for frames drawn as the rows of bound_set "
                           "were, and for no others"
                         : "not calibrated: slip_upper and slip_interval hold at no level";
}

Metadata metadata_of(const nn::Model& model, const std::string& version) {
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
  if (model.magnitude) metadata["magnitude"] = "1";
  if (model.bound) add_bound_metadata(*model.bound, metadata);
  return metadata;
}

void set_metadata(onnx::ModelProto& proto, const Metadata& metadata) {
  proto.clear_metadata_props();
  for (const auto& [key, value] : metadata) {
    onnx::StringStringEntryProto& entry = *proto.add_metadata_props();
    entry.set_key(key);
    entry.set_value(value);
  }
}

/// All that a file says of a model, its checksum included.
onnx::ModelProto proto_of(const nn::Model& model, const std::string& version) {
  onnx::ModelProto proto;
  proto.set_ir_version(ir_version);
  proto.set_producer_name("tactel");
  proto.set_producer_version(version);
  proto.set_doc_string("slippage index S = Q / (mu P) from stresses at the tactels in MPa, normal stresses first");
  onnx::OperatorSetIdProto& operators = *proto.add_opset_import();
  operators.set_domain("");
  operators.set_version(opset);
  *proto.mutable_graph() = onnx_graph(model);
  Metadata metadata = metadata_of(model, version);
  set_metadata(proto, metadata);
  metadata[checksum_key] = onnx_checksum(proto);
  set_metadata(proto, metadata);
  return proto;
}

/// A file's own words, safe to show: cut to 60 bytes, without control characters.
std::string shown(std::string text) {
  constexpr std::size_t most = 60;
  if (text.size() > most) text = text.substr(0, most) + "...";
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text;
}

/// Reads metadata, or says which file is wrong in what.
class ModelReader {
 public:
  ModelReader(std::string file, const onnx::ModelProto& proto) : file_(std::move(file)) {
    for (const onnx::StringStringEntryProto& entry : proto.metadata_props()) metadata_[entry.key()] = entry.value();
  }
  const Metadata& metadata() const { return metadata_; }
  const std::string& text(const std::string& key) const {
    const auto found = metadata_.find(key);
    if (found == metadata_.end())
      fail("a model without \"" + key + "\" in its metadata", "a network that tactel wrote");
    return found->second;
  }
  template <class Number>
  Number number(const std::string& key) const {
    const std::string& from = text(key);
    Number number{};
    const auto [end, error] = std::from_chars(from.data(), from.data() + from.size(), number);
    if (error != std::errc{} || end != from.data() + from.size() || !std::isfinite(static_cast<double>(number)))
      fail(key + " \"" + shown(from) + '"', "a number");
    return number;
  }
  [[noreturn]] void fail(const std::string& what, const std::string& allowed) const {
    throw ConfigError(file_, "network", what, allowed);
  }

 private:
  std::string file_;
  Metadata metadata_;
};

std::string read_bytes(const fs::path& path) try {
  return read_bounded_file(path, most_model_bytes);
} catch (const UnreadableFile& error) {
  throw ConfigError(path.string(), "network", std::string("cannot be read (") + error.what() + ")",
                    "a network that tactel wrote (ONNX, at most 4 MiB)");
}

nn::InputHistory read_history(const ModelReader& reader, const nn::Topology& topology) {
  if (!reader.metadata().contains("history")) return {};
  const nn::InputHistory history{reader.number<int>("history"), reader.number<int>("stride"),
                                 reader.number<double>("history_change")};
  if (!history.valid() || history.frames < 2 || topology.inputs() % (2 * history.frames) != 0)
    reader.fail("history " + shown(reader.text("history")) + " of the network " + topology.text(),
                "2 frames or more that divide its inputs, a stride of 1 to 1000, a change of 0 to 1");
  return history;
}

nn::Model read_model(const ModelReader& reader, const onnx::GraphProto& graph) try {
  nn::Model model{nn::Weights<float>(nn::Topology::parse(reader.text("topology"))), {}, 0, 0, "", 0, {}};
  model.scaling = {nn::parse_scaling(reader.text("scaling")), reader.number<float>("largest_stress")};
  model.history = read_history(reader, model.weights.topology);
  model.scaling.history = model.history.frames;
  model.magnitude = reader.metadata().contains("magnitude") && reader.text("magnitude") == "1";
  model.scaling.validate();
  model.seed = reader.number<std::uint64_t>("seed");
  model.noise = reader.number<double>("noise");
  model.learning_set = reader.text("learning_set");
  model.cycles = reader.number<std::uint32_t>("cycles");
  model.learning_errors = {reader.number<std::size_t>("error_rows"), reader.number<double>("error_max"),
                           reader.number<double>("error_mean"), reader.number<double>("error_std")};
  if (!read_weights(graph, model.weights))
    reader.fail("a graph without the weights of " + model.weights.topology.text(), "a network that tactel wrote");
  if (model.weights.topology.has_bound()) {
    nn::Bound& bound = model.bound.emplace();
    bound.level = reader.number<double>("bound_level");
    bound.set = reader.text("bound_set");
    bound.rows = reader.number<std::uint64_t>("bound_rows");
    bound.seed = reader.number<std::uint64_t>("bound_seed");
    if (reader.metadata().contains("bound_least")) bound.least = reader.number<double>("bound_least");
    if (reader.metadata().contains("bound_left_out")) bound.left_out = reader.text("bound_left_out");
    if (!read_bound(graph, model.weights.topology.inputs(), bound))
      reader.fail("a graph whose tables of the bound are missing or of another size", "a network that tactel wrote");
    bound.validate(model.weights.topology.inputs());
  }
  return model;
} catch (const ValueError& error) {
  reader.fail(error.key + " = " + shown(error.value), error.allowed);
}

/// Whether two models say the same, field by field, in whatever order and form their bytes have it. Metadata apart,
/// whose order means nothing; the reader has taken it, and each key comes once.
bool same_form(onnx::ModelProto a, onnx::ModelProto b) {
  if (a.metadata_props_size() != b.metadata_props_size()) return false;
  a.clear_metadata_props();
  b.clear_metadata_props();
  return google::protobuf::util::MessageDifferencer::Equals(a, b);
}

}  // namespace

std::string network_file_name(const nn::Topology& topology, double noise, std::uint64_t seed) {
  return fmt::format("{}_noise{}_seed{}.onnx", topology.text(), noise, seed);
}

std::string onnx_bytes(const nn::Model& model) { return proto_of(model, TACTEL_VERSION).SerializeAsString(); }

void write_onnx(const fs::path& path, const nn::Model& model) { write_file("--output", path, onnx_bytes(model)); }

nn::Model read_onnx(const fs::path& path) {
  const std::string bytes = read_bytes(path);
  onnx::ModelProto proto;
  const bool parsed = !bytes.empty() && proto.ParsePartialFromString(bytes) && proto.has_graph();
  const ModelReader reader(path.string(), proto);
  if (!parsed) reader.fail(bytes.empty() ? "empty" : "cut short, or no ONNX file", "a network file (ONNX)");
  if (proto.producer_name() != "tactel")
    reader.fail("a model by \"" + shown(proto.producer_name()) + '"', "a network that tactel wrote");
  const std::string& sum = reader.text(checksum_key);
  if (sum != onnx_checksum(proto) && sum != checksum_of_bytes(proto.graph(), reader.metadata()))
    reader.fail("damaged (its checksum does not match)", "whole");
  nn::Model model = read_model(reader, proto.graph());
  for (const float w : model.weights.values)
    if (!std::isfinite(w)) reader.fail("a weight that is NaN or infinite", "a network with finite weights");
  if (!same_form(proto, proto_of(model, reader.text("tactel"))))
    reader.fail("a model of another form", "a network that tactel wrote");
  return model;
}

}  // namespace tactel::host
