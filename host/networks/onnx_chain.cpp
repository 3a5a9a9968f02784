// SPDX-License-Identifier: Apache-2.0
#include "host/networks/onnx_chain.h"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cstring>
#include <map>
#include <optional>

#include "host/support/bounded_file.h"
#include "host/support/errors.h"
#include "nn/infer/network_file.h"
#include "nn/infer/onnx_fields.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;
using namespace infer;
using std::string;
using std::string_view;
using Matrix = nn::RowMatrix<double>;
using Numbers = nn::Vector<double>;

constexpr const char* a_chain =
    "a chain of dense layers (Gemm or MatMul) with Sigmoid, Tanh, Relu or LeakyRelu behind each";
constexpr std::size_t most_numbers = 1 << 20;  ///< of a matrix

[[noreturn]] void refuse_graph(const string& problem, const string& allowed = a_chain) {
  throw ValueError("network", problem, allowed);
}

struct Attributes {
  std::map<string, double, std::less<>> numbers;
  string_view tensor;
  double of(string_view name, double usual) const {
    const auto found = numbers.find(name);
    return found == numbers.end() ? usual : found->second;
  }
};

struct Operation {
  string type;
  std::vector<string> inputs, outputs;
  Attributes attributes;
};

/// The numbers of a tensor; a list is one row.
struct Constant {
  string name;
  Matrix values;
};

double to_double(const Field& field) {
  float value = 0;
  if (field.wire != Field::fixed32) throw Malformed{};
  std::memcpy(&value, field.content.data(), sizeof value);
  return value;
}

void read_attribute(string_view message, Attributes& to) {
  string name;
  double value = 0;
  Fields fields(message);
  for (Field field; fields.next(field);) {
    if (field.number == attribute_name) name = content_of(field);
    if (field.number == attribute_f) value = to_double(field);
    if (field.number == attribute_i) value = static_cast<double>(static_cast<std::int64_t>(number_of(field)));
    if (field.number == attribute_t) to.tensor = content_of(field);
  }
  to.numbers[name] = value;
}

Operation read_operation(string_view message) {
  Operation operation;
  Fields fields(message);
  for (Field field; fields.next(field);) {
    if (field.number == node_input) operation.inputs.emplace_back(content_of(field));
    if (field.number == node_output) operation.outputs.emplace_back(content_of(field));
    if (field.number == node_type) operation.type = content_of(field);
    if (field.number == node_attribute) read_attribute(content_of(field), operation.attributes);
  }
  return operation;
}

std::size_t whole_number(const string& text) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) throw Malformed{};
  return number;
}

/// The part of a file beside the network's that its entries name.
string external_bytes(const fs::path& folder, const std::map<string, string>& entries, std::size_t bytes) {
  const auto entry = [&](const char* key) {
    const auto found = entries.find(key);
    return found == entries.end() ? string() : found->second;
  };
  const fs::path file = entry("location");
  if (file.empty() || file != file.filename() || file == "." || file == "..")
    refuse_graph("numbers in the file \"" + shown(file.string()) + '"',
                 "a network whose numbers lie in files beside it");
  const string all = [&] {
    try {
      return read_bounded_file(folder / file, most_network_bytes);
    } catch (const UnreadableFile& error) {
      refuse_graph(fmt::format("numbers in \"{}\", which cannot be read ({})", shown(file.string()), error.what()),
                   "with that file beside it; torch.onnx.export(..., external_data=False) writes one file");
    }
  }();
  const std::size_t offset = entry("offset").empty() ? 0 : whole_number(entry("offset"));
  if (offset > all.size() || bytes > all.size() - offset) throw Malformed{};
  return all.substr(offset, bytes);
}

Constant read_constant(string_view message, const fs::path& folder) {
  Constant constant;
  std::vector<std::uint64_t> extents;
  std::uint64_t type = 0;
  string bytes;
  std::map<string, string> external;
  Fields fields(message);
  for (Field field; fields.next(field);) {
    if (field.number == tensor_dims) extents.push_back(number_of(field));
    if (field.number == tensor_type) type = number_of(field);
    if (field.number == tensor_name) constant.name = content_of(field);
    if (field.number == tensor_raw) bytes = content_of(field);
    if (field.number == tensor_floats) bytes += field.content;  // a list, or one of many
    if (field.number == tensor_external) {
      std::map<std::uint32_t, string> entry;
      Fields parts(content_of(field));
      for (Field part; parts.next(part);) entry[part.number] = content_of(part);
      external[entry[entry_key]] = entry[entry_value];
    }
  }
  if (type != 1) return constant;  // indices and the like: no operation of a chain takes them
  std::size_t rows = 1, columns = 1;
  for (const std::uint64_t extent : extents) {
    if (extent == 0 || extent > most_numbers || (rows > 1 && extents.size() > 2))
      refuse_graph("a tensor of another shape");
    rows *= columns, columns = static_cast<std::size_t>(extent);
  }
  const std::size_t size = rows * columns * sizeof(float);
  if (size > most_network_bytes) refuse_graph("a tensor of more than 4 MiB");
  if (!external.empty()) bytes = external_bytes(folder, external, size);
  if (bytes.size() != size) throw Malformed{};
  std::vector<float> values(rows * columns);
  std::memcpy(values.data(), bytes.data(), size);
  constant.values = Eigen::Map<const nn::RowMatrix<float>>(values.data(), static_cast<Eigen::Index>(rows),
                                                           static_cast<Eigen::Index>(columns))
                        .cast<double>();
  return constant;
}

/// Layers, one operation after the other. What is not yet in a layer: matrix * x + shift, x the frame or the answers of
/// the last layer; no matrix: x times a number for each place.
class ChainBuilder {
 public:
  void add_constant(const Constant& constant, const string& name) { constants_[name] = constant.values; }
  void begin(const string& input) { value_ = input; }

  void apply(const Operation& operation) {
    if (operation.outputs.empty() || operation.inputs.empty()) throw Malformed{};
    const string& type = operation.type;
    if (type == "Gemm" || type == "MatMul")
      multiply(operation);
    else if (type == "Add" || type == "Sub" || type == "Mul" || type == "Div")
      combine(operation);
    else if (type == "Sigmoid")
      activate(operation, DenseLayer::Activation::sigmoid);
    else if (type == "Tanh")
      activate(operation, DenseLayer::Activation::tanh);
    else if (type == "Relu")
      activate(operation, DenseLayer::Activation::leaky_relu);
    else if (type == "LeakyRelu")
      activate(operation, DenseLayer::Activation::leaky_relu, operation.attributes.of("alpha", 0.01));
    else if (type == "Identity" || type == "Flatten" || type == "Squeeze" || type == "Dropout")
      take(operation);
    else
      refuse_graph("the operation " + shown(type));
    value_ = operation.outputs.front();
  }

  DenseChain finished(const string& output) {
    if (value_ != output) refuse_graph("an output that is not the chain's end");
    if (layers_.empty()) refuse_graph("no dense layer with an activation");
    const bool halves = scale_.size() == 1 && !matrix_ && scale_[0] == 0.5 && shift_[0] == 0.5;
    DenseLayer& last = layers_.back();
    if (halves && last.activation == DenseLayer::Activation::tanh) {
      last = {2 * last.weights, 2 * last.bias, DenseLayer::Activation::sigmoid};  // 1/2 + 1/2 tanh z = sigmoid(2z)
    } else if (matrix_ || (scale_.array() != 1).any() || (shift_.array() != 0).any()) {
      refuse_graph("an output without a sigmoid", "one output through a sigmoid: S lies between 0 and 1");
    }
    return std::move(layers_);
  }

 private:
  const Matrix& constant(const string& name) const {
    const auto found = constants_.find(name);
    if (found == constants_.end() || found->second.size() == 0) refuse_graph("an operation on two values of the graph");
    return found->second;
  }
  void take(const Operation& operation) const {
    if (operation.inputs.front() != value_) refuse_graph("a graph with branches");
  }
  /// A constant for each place, or one for all.
  Numbers each(const Matrix& values, Eigen::Index places) const {
    if (values.rows() != 1 || (values.cols() != 1 && values.cols() != places))
      refuse_graph("a constant of another shape");
    return values.cols() == 1 ? Numbers::Constant(places, values(0, 0)) : Numbers(values.row(0).transpose());
  }

  void multiply(const Operation& operation) {
    take(operation);
    const Attributes& attributes = operation.attributes;
    if (operation.inputs.size() < 2 || attributes.of("transA", 0) != 0) throw Malformed{};
    const bool gemm = operation.type == "Gemm";
    Matrix weights = constant(operation.inputs[1]);
    if (!gemm || attributes.of("transB", 0) == 0) weights.transposeInPlace();
    weights *= gemm ? attributes.of("alpha", 1) : 1;
    know_places(weights.cols());
    Numbers shift = weights * shift_;
    if (gemm && operation.inputs.size() > 2)
      shift += attributes.of("beta", 1) * each(constant(operation.inputs[2]), weights.rows());
    matrix_ = matrix_ ? Matrix(weights * *matrix_) : Matrix(weights * scale_.asDiagonal());
    shift_ = shift, scale_ = Numbers::Ones(weights.rows());
  }

  void combine(const Operation& operation) {
    if (operation.inputs.size() != 2) throw Malformed{};
    const bool first = operation.inputs[0] == value_;
    if (first == (operation.inputs[1] == value_)) refuse_graph("a graph with branches");
    const Matrix& other = constant(operation.inputs[first ? 1 : 0]);
    know_places(std::max(other.cols(), shift_.size()));
    Numbers numbers = each(other, shift_.size());
    if (operation.type == "Div" && !first) refuse_graph("a constant over a value");
    if (operation.type == "Div") numbers = numbers.cwiseInverse();
    if (operation.type == "Mul" || operation.type == "Div") {
      rescale(numbers);
    } else {
      const bool subtracts = operation.type == "Sub";
      if (subtracts && !first) rescale(-Numbers::Ones(numbers.size()));
      shift_ += subtracts && first ? -numbers : numbers;
    }
  }
  void rescale(const Numbers& by) {
    if (matrix_)
      *matrix_ = by.asDiagonal() * *matrix_;
    else
      scale_ = scale_.cwiseProduct(by);
    shift_ = shift_.cwiseProduct(by);
  }

  void activate(const Operation& operation, DenseLayer::Activation activation, double slope = 0) {
    take(operation);
    if (!matrix_) refuse_graph(operation.type + " without a dense layer before it");
    const Eigen::Index places = matrix_->rows();
    layers_.push_back({std::move(*matrix_), shift_, activation, slope});
    matrix_.reset();
    scale_ = Numbers::Ones(places), shift_ = Numbers::Zero(places);
  }

  /// One number stands for all places until their count is known.
  void know_places(Eigen::Index places) {
    if (shift_.size() == 1 && !matrix_ && layers_.empty() && places > 1)
      scale_ = Numbers::Constant(places, scale_[0]), shift_ = Numbers::Constant(places, shift_[0]);
    if (shift_.size() != places) refuse_graph("layers that do not fit each other");
  }

  std::map<string, Matrix> constants_;
  string value_;  ///< the chain's end so far
  DenseChain layers_;
  std::optional<Matrix> matrix_;
  Numbers scale_ = Numbers::Ones(1), shift_ = Numbers::Zero(1);
};

string name_of(string_view value) {
  Fields fields(value);
  for (Field field; fields.next(field);)
    if (field.number == value_name) return string(content_of(field));
  throw Malformed{};
}

DenseChain chain_of(string_view bytes, const fs::path& folder) {
  string_view graph_bytes;
  Fields model(bytes);
  for (Field field; model.next(field);)
    if (field.number == graph) graph_bytes = content_of(field);
  ChainBuilder chain;
  std::vector<Operation> operations;
  std::vector<string> inputs, outputs;
  std::map<string, bool> constants;
  Fields parts(graph_bytes);
  for (Field field; parts.next(field);) {
    if (field.number == graph_node) operations.push_back(read_operation(content_of(field)));
    if (field.number == graph_input) inputs.push_back(name_of(content_of(field)));
    if (field.number == graph_output) outputs.push_back(name_of(content_of(field)));
    if (field.number != graph_tensor) continue;
    const Constant constant = read_constant(content_of(field), folder);
    chain.add_constant(constant, constant.name);
    constants[constant.name] = true;
  }
  std::erase_if(inputs, [&](const string& name) { return constants.contains(name); });
  if (inputs.size() != 1 || outputs.size() != 1)
    refuse_graph(fmt::format("{} inputs and {} outputs", inputs.size(), outputs.size()),
                 "a chain from one input to one output");
  chain.begin(inputs.front());
  for (const Operation& operation : operations) {
    if (operation.type == "Constant" && !operation.outputs.empty())
      chain.add_constant(read_constant(operation.attributes.tensor, folder), operation.outputs.front());
    else
      chain.apply(operation);
  }
  return chain.finished(outputs.front());
}

}  // namespace

DenseChain read_onnx_chain(const fs::path& path) try {
  return chain_of(read_bounded_file(path, most_network_bytes), path.parent_path());
} catch (const UnreadableFile& error) {
  throw ConfigError(path.string(), "network", string("cannot be read (") + error.what() + ")",
                    "an ONNX file of at most 4 MiB");
} catch (const Malformed&) {
  throw ConfigError(path.string(), "network", "truncated, or no ONNX file", a_chain);
} catch (const ValueError& error) {
  throw ConfigError(path.string(), error);
}

}  // namespace tactel::host
