// SPDX-License-Identifier: Apache-2.0
#include "host/networks/onnx_chain.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <map>
#include <optional>
#include <set>

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
constexpr std::size_t most_numbers = 1 << 20;  ///< of all constants, and of those that products take; 300 000 will do
constexpr Eigen::Index widest = 1024;          ///< sums of a product; nn::Topology::widest_layer is less
constexpr std::size_t most_operations = 1000;
constexpr std::size_t longest_shape = 8;  ///< numbers of a list of whole numbers

[[noreturn]] void refuse_graph(const string& problem, const string& allowed = a_chain) {
  throw ValueError("network", problem, allowed);
}

struct Attributes {
  std::map<string, double, std::less<>> numbers;
  std::map<string, std::vector<std::uint64_t>, std::less<>> lists;
  string_view tensor;
  double of(string_view name, double usual) const {
    const auto found = numbers.find(name);
    return found == numbers.end() ? usual : found->second;
  }
};

struct Operation {
  string type, domain;
  std::vector<string> inputs, outputs;
  Attributes attributes;
};

/// A tensor. The numbers of a list are one row; there are none where the type is another than float, double or int64.
struct Constant {
  string name;
  std::uint64_t type = 0;
  std::size_t extents = 0;
  Matrix values;

  bool of_reals() const { return type == type_float || type == type_double; }
};

string type_in_words(std::uint64_t type) {
  constexpr std::array words{"no type", "float",  "uint8",     "int8",       "uint16",  "int16",
                             "int32",   "int64",  "string",    "bool",       "float16", "double",
                             "uint32",  "uint64", "complex64", "complex128", "bfloat16"};
  return type < words.size() ? words[type] : fmt::format("type {}", type);
}

double to_double(const Field& field) {
  float value = 0;
  if (field.wire != Field::fixed32) throw Malformed{};
  std::memcpy(&value, field.content.data(), sizeof value);
  return value;
}

void read_attribute(string_view message, Attributes& to) {
  string name;
  double value = 0;
  std::vector<std::uint64_t> list;
  Fields fields(message);
  for (Field field; fields.next(field);) {
    if (field.number == attribute_name) name = content_of(field);
    if (field.number == attribute_f) value = to_double(field);
    if (field.number == attribute_i) value = static_cast<double>(static_cast<std::int64_t>(number_of(field)));
    if (field.number == attribute_t) to.tensor = content_of(field);
    if (field.number == attribute_ints) list.push_back(number_of(field));
  }
  to.numbers[name] = value;
  to.lists[name] = std::move(list);
}

Operation read_operation(string_view message) {
  Operation operation;
  Fields fields(message);
  for (Field field; fields.next(field);) {
    if (field.number == node_input) operation.inputs.emplace_back(content_of(field));
    if (field.number == node_output) operation.outputs.emplace_back(content_of(field));
    if (field.number == node_type) operation.type = content_of(field);
    if (field.number == node_domain) operation.domain = content_of(field);
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

template <class Number>
void copy_numbers(string_view bytes, Matrix& to) {
  if (bytes.size() != static_cast<std::size_t>(to.size()) * sizeof(Number)) throw Malformed{};
  for (Eigen::Index i = 0; i < to.size(); ++i) {
    Number number;
    std::memcpy(&number, bytes.data() + static_cast<std::size_t>(i) * sizeof number, sizeof number);
    to.data()[i] = static_cast<double>(number);
  }
}

/// Reads tensors, and the files beside the network that hold their numbers.
class ConstantReader {
 public:
  explicit ConstantReader(fs::path folder) : folder_(std::move(folder)) {}

  Constant read(string_view message) {
    Constant constant;
    std::vector<std::uint64_t> extents;
    string bytes;
    std::map<string, string> external;
    Fields fields(message);
    for (Field field; fields.next(field);) {
      if (field.number == tensor_dims) extents.push_back(number_of(field));
      if (field.number == tensor_type) constant.type = number_of(field);
      if (field.number == tensor_name) constant.name = content_of(field);
      if (field.number == tensor_raw) bytes = content_of(field);
      if (field.number == tensor_floats || field.number == tensor_doubles)
        bytes += field.content;  // a list, or one of many
      if (field.number == tensor_int64s) append_varints(field, bytes);
      if (field.number == tensor_external) {
        std::map<std::uint32_t, string> entry;
        Fields parts(content_of(field));
        for (Field part; parts.next(part);) entry[part.number] = content_of(part);
        external[entry[entry_key]] = entry[entry_value];
      }
    }
    constant.extents = extents.size();
    const bool whole = constant.type == type_int64;
    if (whole ? extents.size() > 1 || (!extents.empty() && extents[0] > longest_shape) : !constant.of_reals())
      return constant;
    std::size_t rows = 1, columns = 1;
    for (const std::uint64_t extent : extents) {
      if (extent == 0 || extent > most_numbers || (rows > 1 && extents.size() > 2))
        refuse_graph("a tensor of another shape");
      rows *= columns, columns = static_cast<std::size_t>(extent);
    }
    numbers_ += rows * columns;
    if (numbers_ > most_numbers) refuse_graph("constants of more than 1048576 numbers");
    const std::size_t width = constant.type == type_float ? sizeof(float) : sizeof(double);
    if (!external.empty()) bytes = external_bytes(external, rows * columns * width);
    constant.values.resize(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(columns));
    if (whole)
      copy_numbers<std::int64_t>(bytes, constant.values);
    else if (constant.type == type_double)
      copy_numbers<double>(bytes, constant.values);
    else
      copy_numbers<float>(bytes, constant.values);
    return constant;
  }

 private:
  static void append_varints(const Field& field, string& bytes) {
    const auto append = [&](std::uint64_t number) {
      bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
    };
    if (field.wire == Field::varint) return append(field.value);
    Fields list(content_of(field));
    for (std::uint64_t number = 0; list.next(number);) append(number);
  }

  /// The part of a file beside the network's that its entries name.
  string external_bytes(const std::map<string, string>& entries, std::size_t bytes) {
    const auto entry = [&](const char* key) {
      const auto found = entries.find(key);
      return found == entries.end() ? string() : found->second;
    };
    const fs::path file = entry("location");
    if (file.empty() || file != file.filename() || file == "." || file == "..")
      refuse_graph("numbers in the file \"" + shown(file.string()) + '"',
                   "a network whose numbers lie in files beside it");
    const auto [place, missing] = files_.try_emplace(file.string());
    string& all = place->second;
    if (missing) {
      try {
        all = read_bounded_file(folder_ / file, most_network_bytes - bytes_of_files_);
      } catch (const UnreadableFile& error) {
        refuse_graph(fmt::format("numbers in \"{}\", which cannot be read ({})", shown(file.string()), error.what()),
                     "with that file beside it; torch.onnx.export(..., external_data=False) writes one file");
      }
      bytes_of_files_ += all.size();
    }
    const std::size_t offset = entry("offset").empty() ? 0 : whole_number(entry("offset"));
    if (offset > all.size() || bytes > all.size() - offset) throw Malformed{};
    return all.substr(offset, bytes);
  }

  fs::path folder_;
  std::map<string, string> files_;
  std::size_t bytes_of_files_ = 0, numbers_ = 0;
};

/// Layers, one operation after the other. What is not yet in a layer: matrix * x + shift, x the frame or the answers of
/// the last layer; no matrix: x times a number for each place.
class ChainBuilder {
 public:
  void add_constant(Constant constant, const string& name) {
    name_once(name);
    constants_[name] = std::move(constant);
  }
  void begin(const string& input) {
    name_once(input);
    value_ = input;
  }

  void apply(const Operation& operation) {
    if (operation.outputs.empty() || operation.inputs.empty()) throw Malformed{};
    if (fold(operation)) return;
    for (const string& output : operation.outputs)
      if (!output.empty()) name_once(output);
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
    else if (type == "BatchNormalization")
      normalize(operation);
    else if (type == "Reshape")
      reshape(operation);
    else if (type == "Identity" || type == "Flatten" || type == "Squeeze" || type == "Dropout" || type == "Cast")
      pass(operation);
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
  void name_once(const string& name) {
    if (!names_.insert(name).second) refuse_graph("two values of the name \"" + shown(name) + '"');
  }
  const Constant& any_constant(const string& name) const {
    const auto found = constants_.find(name);
    if (found == constants_.end()) refuse_graph("an operation on two values of the graph");
    return found->second;
  }
  const Matrix& constant(const string& name) const {
    const Constant& found = any_constant(name);
    if (!found.of_reals())
      refuse_graph(fmt::format("numbers of type {} in \"{}\"", type_in_words(found.type), shown(name)),
                   "numbers of type float or double");
    return found.values;
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

  /// Of a Cast.
  static std::uint64_t target_type(const Operation& operation) {
    return static_cast<std::uint64_t>(std::clamp(operation.attributes.of("to", 0), 0.0, 100.0));
  }
  /// What exporters leave of a constant: Identity, Cast and Transpose make another.
  bool fold(const Operation& operation) {
    const auto found = constants_.find(operation.inputs.front());
    if (found == constants_.end()) return false;
    Constant made = found->second;
    if (operation.type == "Transpose") {
      const auto order = operation.attributes.lists.find("perm");
      if (order == operation.attributes.lists.end() || order->second != std::vector<std::uint64_t>{0, 1})
        if (made.extents > 1) made.values.transposeInPlace();
    } else if (operation.type == "Cast") {
      made.type = target_type(operation);
      if (made.type == type_float) made.values = made.values.cast<float>().cast<double>().eval();
    } else if (operation.type != "Identity") {
      return false;
    }
    spend(made.values.size());
    add_constant(std::move(made), operation.outputs.front());
    return true;
  }
  void spend(Eigen::Index numbers) {
    numbers_ += static_cast<std::size_t>(numbers);
    if (numbers_ > most_numbers) refuse_graph("products with more than 1048576 numbers");
  }

  void multiply(const Operation& operation) {
    take(operation);
    const Attributes& attributes = operation.attributes;
    if (operation.inputs.size() < 2) throw Malformed{};
    if (attributes.of("transA", 0) != 0) refuse_graph("a product with a transposed frame");
    const bool gemm = operation.type == "Gemm";
    Matrix weights = constant(operation.inputs[1]);
    if (any_constant(operation.inputs[1]).extents != 2) refuse_graph("a product with a list");
    if (weights.rows() > widest || weights.cols() > widest)
      refuse_graph(fmt::format("a product with [{}, {}] numbers", weights.rows(), weights.cols()));
    spend(weights.size());
    if (!gemm || attributes.of("transB", 0) == 0) weights.transposeInPlace();
    weights *= gemm ? attributes.of("alpha", 1) : 1;
    know_places(weights.cols());
    Numbers shift = weights * shift_;
    if (gemm && operation.inputs.size() > 2 && !operation.inputs[2].empty())
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

  /// (x - mean) / sqrt(variance + epsilon) * scale + bias, as when it does not learn.
  void normalize(const Operation& operation) {
    take(operation);
    if (operation.inputs.size() != 5) throw Malformed{};
    if (operation.attributes.of("training_mode", 0) != 0) refuse_graph("a BatchNormalization that learns");
    know_places(constant(operation.inputs[1]).cols());
    const auto of = [&](std::size_t input) -> Eigen::ArrayXd {
      return each(constant(operation.inputs[input]), shift_.size());
    };
    const Numbers scale = of(1) / (of(4) + operation.attributes.of("epsilon", 1e-5f)).sqrt();
    rescale(scale);
    shift_.array() += of(2) - of(3) * scale.array();
  }

  /// What leaves each number in its place.
  void pass(const Operation& operation) const {
    take(operation);
    const Attributes& attributes = operation.attributes;
    const double axis = attributes.of("axis", 1);
    if (operation.type == "Flatten" && axis != 1 && axis != -1) refuse_graph("a Flatten along another axis");
    if (operation.type == "Dropout" && operation.inputs.size() > 2) refuse_graph("a Dropout that learns");
    if (operation.type != "Cast") return;
    const std::uint64_t to = target_type(operation);
    if (to != type_float && to != type_double)
      refuse_graph("a Cast to " + type_in_words(to), "numbers of type float or double");
  }
  /// To [frames, places]; of one place to [frames], too.
  void reshape(const Operation& operation) {
    take(operation);
    if (operation.inputs.size() != 2) throw Malformed{};
    const Constant& shape = any_constant(operation.inputs[1]);
    const double* const extents = shape.values.data();
    const bool known = matrix_ || !layers_.empty();
    const Eigen::Index count = shape.type == type_int64 ? shape.values.size() : 0;
    if (count == 1 && known && shift_.size() == 1 && extents[0] == -1) return;
    if (count == 2 && (extents[1] != -1 || extents[0] != -1) && std::abs(extents[0]) <= 1) {
      if (extents[1] == -1 || extents[1] == 0 || (known && extents[1] == 1 && shift_.size() == 1)) return;
      if (extents[1] > 1 && extents[1] <= widest) return know_places(static_cast<Eigen::Index>(extents[1]));
    }
    refuse_graph("a Reshape of a frame");
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

  std::map<string, Constant> constants_;
  std::set<string> names_;
  std::size_t numbers_ = 0;  ///< of constants in products so far
  string value_;             ///< the chain's end so far
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
  std::set<string> constants;
  ConstantReader reader(folder);
  Fields parts(graph_bytes);
  for (Field field; parts.next(field);) {
    if (field.number == graph_node && operations.size() == most_operations)
      refuse_graph(fmt::format("more than {} operations", most_operations));
    if (field.number == graph_node) operations.push_back(read_operation(content_of(field)));
    if (field.number == graph_input) inputs.push_back(name_of(content_of(field)));
    if (field.number == graph_output) outputs.push_back(name_of(content_of(field)));
    if (field.number != graph_tensor) continue;
    Constant constant = reader.read(content_of(field));
    const string name = constant.name;
    constants.insert(name);
    chain.add_constant(std::move(constant), name);
  }
  std::erase_if(inputs, [&](const string& name) { return constants.contains(name); });
  if (inputs.size() != 1 || outputs.size() != 1)
    refuse_graph(fmt::format("{} inputs and {} outputs", inputs.size(), outputs.size()),
                 "a chain from one input to one output");
  chain.begin(inputs.front());
  for (const Operation& operation : operations) {
    if (!operation.domain.empty() && operation.domain != "ai.onnx")
      refuse_graph(fmt::format("the operation {} of {}", shown(operation.type), shown(operation.domain)));
    if (operation.type == "Constant" && !operation.outputs.empty())
      chain.add_constant(reader.read(operation.attributes.tensor), operation.outputs.front());
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
