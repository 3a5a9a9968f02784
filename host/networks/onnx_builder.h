// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <onnx/onnx_pb.h>

#include <initializer_list>
#include <string>

namespace tactel::host {

/// Adds the parts of an ONNX graph one by one.
class OnnxBuilder {
 public:
  using Names = std::initializer_list<std::string>;

  explicit OnnxBuilder(onnx::GraphProto& graph) : graph_(graph) {}

  onnx::NodeProto& node(const std::string& type, Names inputs, const std::string& output);
  void numbers(const std::string& name, std::initializer_list<std::int64_t> shape, const float* values);
  void integers(const std::string& name, std::initializer_list<std::int64_t> values);
  void scalar(const std::string& name, float value) { numbers(name, {}, &value); }
  static void attribute(onnx::NodeProto& node, const std::string& name, std::int64_t value);
  static void axis(onnx::NodeProto& node, std::int64_t axis);

 private:
  void tensor(const std::string& name, onnx::TensorProto::DataType type, std::initializer_list<std::int64_t> shape,
              const void* data, std::size_t size);

  onnx::GraphProto& graph_;
};

}  // namespace tactel::host
