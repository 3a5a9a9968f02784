// SPDX-License-Identifier: Apache-2.0
#include "host/networks/onnx_builder.h"

#include <bit>

namespace tactel::host {

static_assert(std::endian::native == std::endian::little, "ONNX keeps raw data little-endian");

onnx::NodeProto& OnnxBuilder::node(const std::string& type, Names inputs, const std::string& output) {
  onnx::NodeProto& node = *graph_.add_node();
  node.set_op_type(type);
  node.set_name(output);
  for (const std::string& input : inputs) node.add_input(input);
  node.add_output(output);
  return node;
}

void OnnxBuilder::numbers(const std::string& name, std::initializer_list<std::int64_t> shape, const float* values) {
  tensor(name, onnx::TensorProto::FLOAT, shape, values, sizeof(float));
}

void OnnxBuilder::integers(const std::string& name, std::initializer_list<std::int64_t> values) {
  tensor(name, onnx::TensorProto::INT64, {static_cast<std::int64_t>(values.size())}, values.begin(),
         sizeof(std::int64_t));
}

void OnnxBuilder::attribute(onnx::NodeProto& node, const std::string& name, std::int64_t value) {
  onnx::AttributeProto& attribute = *node.add_attribute();
  attribute.set_name(name);
  attribute.set_type(onnx::AttributeProto::INT);
  attribute.set_i(value);
}

void OnnxBuilder::axis(onnx::NodeProto& node, std::int64_t axis) {
  onnx::AttributeProto& attribute = *node.add_attribute();
  attribute.set_name("axes");
  attribute.set_type(onnx::AttributeProto::INTS);
  attribute.add_ints(axis);
}

void OnnxBuilder::tensor(const std::string& name, onnx::TensorProto::DataType type,
                         std::initializer_list<std::int64_t> shape, const void* data, std::size_t size) {
  onnx::TensorProto& tensor = *graph_.add_initializer();
  tensor.set_name(name);
  tensor.set_data_type(type);
  for (const std::int64_t extent : shape) {
    tensor.add_dims(extent);
    size *= static_cast<std::size_t>(extent);
  }
  tensor.set_raw_data(data, size);
}

}  // namespace tactel::host
