#include "host/onnx_file.h"

#include <unistd.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>

#include "fem/value_error.h"
#include "host/checksum.h"
#include "host/errors.h"
#include "host/onnx_graph.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;
using Metadata = std::map<std::string, std::string>;

constexpr std::int64_t opset = 13;
const std::string checksum_key = "checksum";
constexpr std::int64_t ir_version = 7;  ///< the one that came with opset 13 (ONNX 1.8)

// The shortest text that reads back to the same number.
template <class Number>
std::string exact(Number number) {
  char text[64];
  return {text, std::to_chars(text, text + sizeof text, number).ptr};
}

// Of the graph and of all metadata but the checksum itself.
std::string checksum_of(const onnx::GraphProto& graph, const Metadata& metadata) {
  std::string all = graph.SerializeAsString();
  for (const auto& [key, value] : metadata)
    if (key != checksum_key) all += '\n' + key + '=' + value;
  return checksum_text(all);
}

Metadata metadata_of(const nn::Model& model, const onnx::GraphProto& graph, const std::string& version) {
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
  metadata[checksum_key] = checksum_of(graph, metadata);
  return metadata;
}

std::string bytes_of(const nn::Model& model, const std::string& version) {
  onnx::ModelProto proto;
  proto.set_ir_version(ir_version);
  proto.set_producer_name("tactel");
  proto.set_producer_version(version);
  proto.set_doc_string("slippage index S = Q / (mu P) from stresses at the tactels in MPa, normal stresses first");
  onnx::OperatorSetIdProto& operators = *proto.add_opset_import();
  operators.set_domain("");
  operators.set_version(opset);
  *proto.mutable_graph() = onnx_graph(model);
  for (const auto& [key, value] : metadata_of(model, proto.graph(), version)) {
    onnx::StringStringEntryProto& entry = *proto.add_metadata_props();
    entry.set_key(key);
    entry.set_value(value);
  }
  return proto.SerializeAsString();
}

/// Reads metadata, or says which file is wrong in what.
class Reader {
 public:
  Reader(std::string file, const onnx::ModelProto& proto) : file_(std::move(file)) {
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
    if (error != std::errc{} || end != from.data() + from.size()) fail(key + " \"" + from + '"', "a number");
    return number;
  }
  [[noreturn]] void fail(const std::string& what, const std::string& allowed) const {
    throw ConfigError(file_, "network", what, allowed);
  }

 private:
  std::string file_;
  Metadata metadata_;
};

std::string read_bytes(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  if (!file.good() && !file.eof())
    throw ConfigError(path.string(), "network", "cannot be read", "a network file (ONNX)");
  return bytes;
}

nn::Model read_model(const Reader& reader, const onnx::GraphProto& graph) try {
  nn::Model model{nn::Weights<float>(nn::Topology::parse(reader.text("topology"))), {}, 0, 0, "", 0, {}};
  model.scaling = {nn::parse_scaling(reader.text("scaling")), reader.number<float>("largest_stress")};
  model.scaling.validate();
  model.seed = reader.number<std::uint64_t>("seed");
  model.noise = reader.number<double>("noise");
  model.learning_set = reader.text("learning_set");
  model.cycles = reader.number<std::uint32_t>("cycles");
  model.learning_errors = {reader.number<std::size_t>("error_rows"), reader.number<double>("error_max"),
                           reader.number<double>("error_mean"), reader.number<double>("error_std")};
  if (!read_weights(graph, model.weights))
    reader.fail("a graph without the weights of " + model.weights.topology.text(), "a network that tactel wrote");
  return model;
} catch (const ValueError& error) {
  reader.fail(error.key + " = " + error.value, error.allowed);
}

}  // namespace

std::string onnx_bytes(const nn::Model& model) { return bytes_of(model, TACTEL_VERSION); }

void write_onnx(const fs::path& path, const nn::Model& model) {
  const fs::path temporary = path.string() + "." + std::to_string(getpid());
  {
    std::ofstream file(temporary, std::ios::binary);
    const std::string bytes = onnx_bytes(model);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file)
      throw ConfigError(path.string(), "network", "cannot be written", "in a directory that can be written to");
  }
  fs::rename(temporary, path);
}

nn::Model read_onnx(const fs::path& path) {
  const std::string bytes = read_bytes(path);
  onnx::ModelProto proto;
  const bool parsed = !bytes.empty() && proto.ParsePartialFromString(bytes) && proto.has_graph();
  const Reader reader(path.string(), proto);
  if (!parsed) reader.fail(bytes.empty() ? "empty" : "cut short, or no ONNX file", "a network file (ONNX)");
  if (proto.producer_name() != "tactel")
    reader.fail("a model by \"" + proto.producer_name() + '"', "a network that tactel wrote");
  if (reader.text(checksum_key) != checksum_of(proto.graph(), reader.metadata()))
    reader.fail("damaged (its checksum does not match)", "whole");
  const nn::Model model = read_model(reader, proto.graph());
  if (bytes_of(model, reader.text("tactel")) != bytes)
    reader.fail("a model of another form", "a network that tactel wrote");
  for (const float w : model.weights.values)
    if (!std::isfinite(w)) reader.fail("a weight that is NaN or infinite", "a network with finite weights");
  return model;
}

}  // namespace tactel::host
