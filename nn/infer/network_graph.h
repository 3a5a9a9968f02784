// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "nn/network.h"

namespace tactel::infer {

/// An attribute of an operation: a number, or a list of one number.
struct Attribute {
  std::string name;
  std::int64_t value;
  bool list = false;
};

/// An operation; its name is that of its output.
struct Node {
  std::string type;
  std::vector<std::string> inputs;
  std::string output;
  std::vector<Attribute> attributes;
};

enum class TensorType : std::uint64_t { floats = 1, integers = 7 };

struct Tensor {
  std::string name;
  TensorType type;
  std::vector<std::int64_t> dims;  ///< none: a scalar
  std::string raw;                 ///< little-endian
};

/// An input or output of the graph, [batch, width].
struct Value {
  std::string name;
  int width;
};

/// A graph of ONNX, operators of opset 13.
struct Graph {
  std::string name;
  std::vector<Node> nodes;
  std::vector<Tensor> tensors;
  Value input;
  std::vector<Value> outputs;
};

/// Returns the graph of a network: `frame` [batch, inputs] MPa, of several frames the newest first -> scaling -> layers
/// -> `slip_index` [batch, 1], or another target by its name. One with a bound also has `slip_upper` [batch, 1]: S is
/// below it; `slip_interval` [batch, 2]: S is within it, lower end first; `unlike` [batch, 1]: 1 where the frame is
/// unlike those of the learning set, else 0.
Graph graph_of(const nn::Model& model);

/// Names of the numbers of layer l, from 0.
std::string weight_name(int l);
std::string bias_name(int l);

}  // namespace tactel::infer
