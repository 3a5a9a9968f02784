// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <onnx/onnx_pb.h>

#include <Eigen/Dense>
#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace tactel::tests {

/// A small runtime for ONNX graphs, written from the standard's description of each operator (onnx/docs/Operators.md,
/// opset 13), in double precision. It knows nothing of how tactel makes graphs.
class OnnxEvaluator {
 public:
  /// Of at most two extents, a list in one row; booleans as 0 and 1.
  using Tensor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

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
  using Numbers = std::vector<double>;

  template <class Number>
  static void copy(const std::string& raw, Tensor& to) {
    for (Eigen::Index i = 0; i < to.size(); ++i) {
      Number value;
      std::memcpy(&value, raw.data() + i * sizeof value, sizeof value);
      to.data()[i] = static_cast<double>(value);
    }
  }

  static Tensor read(const onnx::TensorProto& tensor) {
    const int extents = tensor.dims_size();
    if (extents > 2) throw std::runtime_error("more than two extents");
    Tensor result(extents > 1 ? tensor.dims(0) : 1, extents > 0 ? tensor.dims(extents - 1) : 1);
    if (tensor.float_data_size() > 0)
      return Eigen::Map<const Eigen::RowVectorXf>(tensor.float_data().data(), 1, tensor.float_data_size())
          .cast<double>();
    tensor.data_type() == onnx::TensorProto::FLOAT ? copy<float>(tensor.raw_data(), result)
                                                   : copy<std::int64_t>(tensor.raw_data(), result);
    return result;
  }

  static const onnx::AttributeProto* attribute(const onnx::NodeProto& node, const std::string& name) {
    for (const onnx::AttributeProto& attribute : node.attribute())
      if (attribute.name() == name) return &attribute;
    return nullptr;
  }

  static void expect(bool known, const std::string& what) {
    if (!known) throw std::runtime_error(what + ": not this one");
  }

  // NumPy's rule: extents of 1 are stretched.
  static Tensor broadcast(const std::vector<Tensor>& in, const std::function<double(const Numbers&)>& f) {
    Eigen::Index rows = 1, columns = 1;
    for (const Tensor& t : in) rows = std::max(rows, t.rows()), columns = std::max(columns, t.cols());
    for (const Tensor& t : in)
      expect((t.rows() == 1 || t.rows() == rows) && (t.cols() == 1 || t.cols() == columns), "shapes that do not fit");
    return Tensor::NullaryExpr(rows, columns, [&](Eigen::Index i, Eigen::Index k) {
      Numbers arguments;
      for (const Tensor& t : in) arguments.push_back(t(t.rows() == 1 ? 0 : i, t.cols() == 1 ? 0 : k));
      return f(arguments);
    });
  }

  static Tensor product(const Tensor& a, const Tensor& b) {
    expect(a.cols() == b.rows(), "inner extents that differ");
    return a * b;
  }

  static Tensor gemm(const onnx::NodeProto& node, const std::vector<Tensor>& in) {
    const auto* alpha = attribute(node, "alpha");
    const auto* beta = attribute(node, "beta");
    const auto* transposed = attribute(node, "transB");
    expect(!attribute(node, "transA"), "Gemm");
    const Tensor factor = transposed && transposed->i() != 0 ? Tensor(in[1].transpose()) : in[1];
    const double a = alpha ? alpha->f() : 1, b = beta ? beta->f() : 1;
    return broadcast({product(in[0], factor), in[2]}, [a, b](const Numbers& x) { return a * x[0] + b * x[1]; });
  }

  // Of a matrix, along its second axis, with step 1.
  static Tensor slice(const std::vector<Tensor>& in) {
    expect(in.size() == 4 && in[3].size() == 1 && in[3](0) == 1, "Slice");
    const auto begin = static_cast<Eigen::Index>(in[1](0)), end = static_cast<Eigen::Index>(in[2](0));
    return in[0].middleCols(begin, end - begin);
  }

  static bool keeps_extents(const onnx::NodeProto& node) {
    const auto* keep = attribute(node, "keepdims");
    return !keep || keep->i() == 1;
  }

  static Tensor reduce_max(const onnx::NodeProto& node, const Tensor& in) {
    const auto* axes = attribute(node, "axes");
    expect(axes && axes->ints_size() == 1 && axes->ints(0) == 1 && keeps_extents(node), "ReduceMax");
    return in.rowwise().maxCoeff();
  }

  // Along the second axis of a matrix: the axes are an input since opset 13.
  static Tensor reduce_sum(const onnx::NodeProto& node, const std::vector<Tensor>& in) {
    expect(in.size() == 2 && in[1].size() == 1 && in[1](0) == 1 && keeps_extents(node), "ReduceSum");
    return in[0].rowwise().sum();
  }

  // Of a list: an element for each index, in the shape of the indices. Of a matrix: a row for each index of a list.
  static Tensor gather(const onnx::NodeProto& node, const std::vector<Tensor>& in) {
    const auto* axis = attribute(node, "axis");
    expect(!axis || axis->i() == 0, "Gather");
    if (in[0].rows() > 1) {
      expect(in[1].rows() == 1 && in[1].minCoeff() >= 0 && in[1].maxCoeff() < static_cast<double>(in[0].rows()),
             "Gather");
      Tensor rows(in[1].size(), in[0].cols());
      for (Eigen::Index i = 0; i < rows.rows(); ++i) rows.row(i) = in[0].row(static_cast<Eigen::Index>(in[1](i)));
      return rows;
    }
    expect(in[1].minCoeff() >= 0 && in[1].maxCoeff() < static_cast<double>(in[0].size()), "an index beyond the list");
    return in[1].unaryExpr([&](double index) { return in[0](static_cast<Eigen::Index>(index)); });
  }

  // Of matrices, side by side.
  static Tensor concat(const onnx::NodeProto& node, const std::vector<Tensor>& in) {
    expect(attribute(node, "axis")->i() == 1, "Concat");
    Tensor out(in[0].rows(), 0);
    for (const Tensor& t : in) {
      expect(t.rows() == out.rows(), "Concat");
      out.conservativeResize(Eigen::NoChange, out.cols() + t.cols());
      out.rightCols(t.cols()) = t;
    }
    return out;
  }

  // Of each row the elements at the indices of this row.
  static Tensor gather_elements(const onnx::NodeProto& node, const std::vector<Tensor>& in) {
    expect(attribute(node, "axis")->i() == 1 && in[0].rows() == in[1].rows(), "GatherElements");
    return Tensor::NullaryExpr(in[1].rows(), in[1].cols(), [&](Eigen::Index i, Eigen::Index k) {
      return in[0](i, static_cast<Eigen::Index>(in[1](i, k)));
    });
  }

  // To rows of so many elements.
  static Tensor reshape(const std::vector<Tensor>& in) {
    expect(in[1].size() == 2 && in[1](0) == -1, "Reshape");
    const auto columns = static_cast<Eigen::Index>(in[1](1));
    expect(in[0].size() % columns == 0, "Reshape");
    return Eigen::Map<const Tensor>(in[0].data(), in[0].size() / columns, columns);
  }

  // A column becomes a list.
  static Tensor squeeze(const std::vector<Tensor>& in) {
    expect(in.size() == 2 && in[1].size() == 1 && in[1](0) == 1 && in[0].cols() == 1, "Squeeze");
    return in[0].transpose();
  }

  // To an integer or a number; towards zero.
  static Tensor cast(const onnx::NodeProto& node, const Tensor& in) {
    const std::int64_t to = attribute(node, "to")->i();
    expect(to == onnx::TensorProto::FLOAT || to == onnx::TensorProto::INT64, "Cast");
    return to == onnx::TensorProto::FLOAT ? in : Tensor(in.unaryExpr([](double value) { return std::trunc(value); }));
  }

  // (x - mean) / sqrt(variance + epsilon) * scale + bias.
  static Tensor normalize(const onnx::NodeProto& node, const std::vector<Tensor>& in) {
    const auto* epsilon = attribute(node, "epsilon");
    return broadcast(in, [e = epsilon ? epsilon->f() : 1e-5f](const Numbers& x) {
      return (x[0] - x[3]) / std::sqrt(x[4] + e) * x[1] + x[2];
    });
  }

  static Tensor apply(const onnx::NodeProto& node, const std::vector<Tensor>& in) {
    static const std::map<std::string, double (*)(const Numbers&)> of_elements = {
        {"Greater", [](const Numbers& x) { return x[0] > x[1] ? 1.0 : 0.0; }},
        {"LessOrEqual", [](const Numbers& x) { return x[0] <= x[1] ? 1.0 : 0.0; }},
        {"Less", [](const Numbers& x) { return x[0] < x[1] ? 1.0 : 0.0; }},
        {"Not", [](const Numbers& x) { return x[0] == 0 ? 1.0 : 0.0; }},
        {"Max", [](const Numbers& x) { return std::max(x[0], x[1]); }},
        {"Min", [](const Numbers& x) { return std::min(x[0], x[1]); }},
        {"Sub", [](const Numbers& x) { return x[0] - x[1]; }},
        {"Mul", [](const Numbers& x) { return x[0] * x[1]; }},
        {"Add", [](const Numbers& x) { return x[0] + x[1]; }},
        {"Div", [](const Numbers& x) { return x[0] / x[1]; }},
        {"Where", [](const Numbers& x) { return x[0] != 0 ? x[1] : x[2]; }},
        {"Abs", [](const Numbers& x) { return std::abs(x[0]); }},
        {"Neg", [](const Numbers& x) { return -x[0]; }},
        {"Sqrt", [](const Numbers& x) { return std::sqrt(x[0]); }},
        {"Tanh", [](const Numbers& x) { return std::tanh(x[0]); }},
        {"Relu", [](const Numbers& x) { return std::max(x[0], 0.0); }},
        {"Sigmoid", [](const Numbers& x) { return 1 / (1 + std::exp(-x[0])); }}};
    const std::string& type = node.op_type();
    if (const auto found = of_elements.find(type); found != of_elements.end()) return broadcast(in, found->second);
    if (type == "Flatten") return in[0];
    if (type == "BatchNormalization") return normalize(node, in);
    if (type == "Gemm") return gemm(node, in);
    if (type == "Slice") return slice(in);
    if (type == "ReduceMax") return reduce_max(node, in[0]);
    if (type == "ReduceSum") return reduce_sum(node, in);
    if (type == "Gather") return gather(node, in);
    if (type == "GatherElements") return gather_elements(node, in);
    if (type == "Squeeze") return squeeze(in);
    if (type == "Reshape") return reshape(in);
    if (type == "Concat") return concat(node, in);
    if (type == "MatMul") return product(in[0], in[1]);
    if (type == "Cast") return cast(node, in[0]);
    expect(type == "LeakyRelu", "operator " + type);
    const auto* alpha = attribute(node, "alpha");
    return broadcast(in, [a = alpha ? alpha->f() : 0.01](const Numbers& x) { return x[0] < 0 ? a * x[0] : x[0]; });
  }

  const onnx::GraphProto graph_;
  std::map<std::string, Tensor> constants_;
};

}  // namespace tactel::tests
