// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <onnx/onnx_pb.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace tactel::testing {

/// A small runtime for ONNX graphs, written from the standard's description of each operator (onnx/docs/Operators.md,
/// opset 13), in double precision. It knows nothing of how tactel makes graphs.
class OnnxEvaluator {
 public:
  struct Tensor {
    std::vector<std::int64_t> shape;
    std::vector<double> data;  ///< row-major; booleans as 0 and 1
    std::int64_t size() const {
      std::int64_t size = 1;
      for (const std::int64_t extent : shape) size *= extent;
      return size;
    }
  };

  explicit OnnxEvaluator(const onnx::ModelProto& model) : graph_(model.graph()) {
    for (const onnx::TensorProto& tensor : graph_.initializer()) constants_[tensor.name()] = read(tensor);
  }

  Tensor run(const Tensor& input) const { return all(input).at(graph_.output(0).name()); }

  /// Every value of the graph by its name.
  std::map<std::string, Tensor> all(const Tensor& input) const {
    std::map<std::string, Tensor> values = constants_;
    values[graph_.input(0).name()] = input;
    for (const onnx::NodeProto& node : graph_.node()) {
      std::vector<Tensor> in;
      for (const std::string& name : node.input()) in.push_back(values.at(name));
      values[node.output(0)] = apply(node, in);
    }
    return values;
  }

 private:
  static Tensor read(const onnx::TensorProto& tensor) {
    Tensor result{{tensor.dims().begin(), tensor.dims().end()}, {}};
    const std::string& raw = tensor.raw_data();
    for (std::int64_t i = 0; i < result.size(); ++i) {
      if (tensor.data_type() == onnx::TensorProto::FLOAT) {
        float value;
        std::memcpy(&value, raw.data() + i * sizeof value, sizeof value);
        result.data.push_back(value);
      } else {
        std::int64_t value;
        std::memcpy(&value, raw.data() + i * sizeof value, sizeof value);
        result.data.push_back(static_cast<double>(value));
      }
    }
    return result;
  }

  static const onnx::AttributeProto* attribute(const onnx::NodeProto& node, const std::string& name) {
    for (const onnx::AttributeProto& attribute : node.attribute())
      if (attribute.name() == name) return &attribute;
    return nullptr;
  }

  // NumPy's rule: shapes aligned at the end, extents of 1 stretched.
  static Tensor broadcast(const std::vector<Tensor>& in, const std::function<double(const std::vector<double>&)>& f) {
    Tensor out;
    for (const Tensor& t : in) {
      if (t.shape.size() > out.shape.size()) out.shape.insert(out.shape.begin(), t.shape.size() - out.shape.size(), 1);
      for (std::size_t k = 1; k <= t.shape.size(); ++k) {
        std::int64_t& extent = out.shape[out.shape.size() - k];
        const std::int64_t own = t.shape[t.shape.size() - k];
        if (extent != 1 && own != 1 && extent != own) throw std::runtime_error("shapes do not fit");
        extent = std::max(extent, own);
      }
    }
    for (std::int64_t i = 0; i < out.size(); ++i) {
      std::vector<double> arguments;
      for (const Tensor& t : in) {
        std::int64_t rest = i, place = 0, stride = 1;
        for (std::size_t k = 1; k <= out.shape.size(); ++k) {
          const std::int64_t index = rest % out.shape[out.shape.size() - k];
          rest /= out.shape[out.shape.size() - k];
          if (k > t.shape.size()) continue;
          const std::int64_t own = t.shape[t.shape.size() - k];
          if (own != 1) place += index * stride;
          stride *= own;
        }
        arguments.push_back(t.data[place]);
      }
      out.data.push_back(f(arguments));
    }
    return out;
  }

  static Tensor gemm(const onnx::NodeProto& node, const std::vector<Tensor>& in) {
    const auto* alpha = attribute(node, "alpha");
    const auto* beta = attribute(node, "beta");
    const auto* transposed = attribute(node, "transB");
    if (attribute(node, "transA")) throw std::runtime_error("transA");
    const bool t = transposed && transposed->i() != 0;
    const std::int64_t rows = in[0].shape[0], inner = in[0].shape[1], columns = in[1].shape[t ? 0 : 1];
    if (in[1].shape[t ? 1 : 0] != inner) throw std::runtime_error("Gemm: inner extents differ");
    Tensor product{{rows, columns}, std::vector<double>(rows * columns, 0)};
    for (std::int64_t i = 0; i < rows; ++i)
      for (std::int64_t j = 0; j < columns; ++j)
        for (std::int64_t k = 0; k < inner; ++k)
          product.data[i * columns + j] += in[0].data[i * inner + k] * in[1].data[t ? j * inner + k : k * columns + j];
    const double a = alpha ? alpha->f() : 1, b = beta ? beta->f() : 1;
    return broadcast({product, in[2]}, [a, b](const auto& x) { return a * x[0] + b * x[1]; });
  }

  // Of a matrix, along its second axis, with step 1.
  static Tensor slice(const std::vector<Tensor>& in) {
    if (in.size() != 4 || in[0].shape.size() != 2 || in[3].data != std::vector<double>{1})
      throw std::runtime_error("Slice: not this one");
    const auto begin = static_cast<std::int64_t>(in[1].data[0]), end = static_cast<std::int64_t>(in[2].data[0]);
    Tensor out{{in[0].shape[0], end - begin}, {}};
    for (std::int64_t i = 0; i < in[0].shape[0]; ++i)
      for (std::int64_t k = begin; k < end; ++k) out.data.push_back(in[0].data[i * in[0].shape[1] + k]);
    return out;
  }

  static Tensor reduce_max(const onnx::NodeProto& node, const Tensor& in) {
    const auto* axes = attribute(node, "axes");
    const auto* keep = attribute(node, "keepdims");
    if (!axes || axes->ints_size() != 1 || axes->ints(0) != 1 || (keep && keep->i() != 1))
      throw std::runtime_error("ReduceMax: not this one");
    Tensor out{{in.shape[0], 1}, {}};
    for (std::int64_t i = 0; i < in.shape[0]; ++i) {
      double most = -std::numeric_limits<double>::infinity();
      for (std::int64_t k = 0; k < in.shape[1]; ++k) most = std::max(most, in.data[i * in.shape[1] + k]);
      out.data.push_back(most);
    }
    return out;
  }

  // Along the second axis of a matrix, with keepdims: the axes are an input since opset 13.
  static Tensor reduce_sum(const onnx::NodeProto& node, const std::vector<Tensor>& in) {
    const auto* keep = attribute(node, "keepdims");
    if (in.size() != 2 || in[1].data != std::vector<double>{1} || (keep && keep->i() != 1))
      throw std::runtime_error("ReduceSum: not this one");
    Tensor out{{in[0].shape[0], 1}, {}};
    for (std::int64_t i = 0; i < in[0].shape[0]; ++i) {
      double sum = 0;
      for (std::int64_t k = 0; k < in[0].shape[1]; ++k) sum += in[0].data[i * in[0].shape[1] + k];
      out.data.push_back(sum);
    }
    return out;
  }

  // Of a list: an element for each index, in the shape of the indices.
  static Tensor gather(const onnx::NodeProto& node, const std::vector<Tensor>& in) {
    const auto* axis = attribute(node, "axis");
    if (in[0].shape.size() != 1 || (axis && axis->i() != 0)) throw std::runtime_error("Gather: not this one");
    Tensor out{in[1].shape, {}};
    for (const double index : in[1].data) out.data.push_back(in[0].data.at(static_cast<std::size_t>(index)));
    return out;
  }

  // Of two columns.
  static Tensor concat(const onnx::NodeProto& node, const std::vector<Tensor>& in) {
    if (in.size() != 2 || in[0].shape != in[1].shape || in[0].shape.at(1) != 1 || attribute(node, "axis")->i() != 1)
      throw std::runtime_error("Concat: not this one");
    Tensor out{{in[0].shape[0], 2}, {}};
    for (std::int64_t i = 0; i < in[0].shape[0]; ++i) out.data.insert(out.data.end(), {in[0].data[i], in[1].data[i]});
    return out;
  }

  static Tensor matmul(const std::vector<Tensor>& in) {
    const std::int64_t rows = in[0].shape[0], inner = in[0].shape[1], columns = in[1].shape[1];
    if (in[1].shape[0] != inner) throw std::runtime_error("MatMul: inner extents differ");
    Tensor product{{rows, columns}, std::vector<double>(rows * columns, 0)};
    for (std::int64_t i = 0; i < rows; ++i)
      for (std::int64_t j = 0; j < columns; ++j)
        for (std::int64_t k = 0; k < inner; ++k)
          product.data[i * columns + j] += in[0].data[i * inner + k] * in[1].data[k * columns + j];
    return product;
  }

  // To an integer or a number; towards zero.
  static Tensor cast(const onnx::NodeProto& node, Tensor in) {
    const std::int64_t to = attribute(node, "to")->i();
    if (to != onnx::TensorProto::FLOAT && to != onnx::TensorProto::INT64)
      throw std::runtime_error("Cast: not this one");
    if (to == onnx::TensorProto::INT64)
      for (double& value : in.data) value = std::trunc(value);
    return in;
  }

  static Tensor apply(const onnx::NodeProto& node, const std::vector<Tensor>& in) {
    const std::string& type = node.op_type();
    if (type == "Gemm") return gemm(node, in);
    if (type == "Slice") return slice(in);
    if (type == "ReduceMax") return reduce_max(node, in[0]);
    if (type == "ReduceSum") return reduce_sum(node, in);
    if (type == "Gather") return gather(node, in);
    if (type == "Concat") return concat(node, in);
    if (type == "MatMul") return matmul(in);
    if (type == "Cast") return cast(node, in[0]);
    if (type == "Greater") return broadcast(in, [](const auto& x) { return x[0] > x[1] ? 1.0 : 0.0; });
    if (type == "LessOrEqual") return broadcast(in, [](const auto& x) { return x[0] <= x[1] ? 1.0 : 0.0; });
    if (type == "Not") return broadcast(in, [](const auto& x) { return x[0] == 0 ? 1.0 : 0.0; });
    if (type == "Max") return broadcast(in, [](const auto& x) { return std::max(x[0], x[1]); });
    if (type == "Min") return broadcast(in, [](const auto& x) { return std::min(x[0], x[1]); });
    if (type == "Sub") return broadcast(in, [](const auto& x) { return x[0] - x[1]; });
    if (type == "Mul") return broadcast(in, [](const auto& x) { return x[0] * x[1]; });
    if (type == "Add") return broadcast(in, [](const auto& x) { return x[0] + x[1]; });
    if (type == "Div") return broadcast(in, [](const auto& x) { return x[0] / x[1]; });
    if (type == "Less") return broadcast(in, [](const auto& x) { return x[0] < x[1] ? 1.0 : 0.0; });
    if (type == "Where") return broadcast(in, [](const auto& x) { return x[0] != 0 ? x[1] : x[2]; });
    if (type == "Abs") return broadcast(in, [](const auto& x) { return std::abs(x[0]); });
    if (type == "LeakyRelu") {
      const auto* alpha = attribute(node, "alpha");
      return broadcast(in, [a = alpha ? alpha->f() : 0.01](const auto& x) { return x[0] < 0 ? a * x[0] : x[0]; });
    }
    if (type == "Tanh") return broadcast(in, [](const auto& x) { return std::tanh(x[0]); });
    throw std::runtime_error("no operator " + type);
  }

  const onnx::GraphProto graph_;
  std::map<std::string, Tensor> constants_;
};

}  // namespace tactel::testing
